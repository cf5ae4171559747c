//! Scenes made by code.

use super::SceneError;
use crate::draft::Draft;

mod atrium;
mod caustic;
mod columns;
mod cornell;
mod paint;
mod shape;

/// The names of the built-in scenes. `atrium` may be followed by the number of triangles, as in
/// `atrium:75k`.
pub const NAMES: [&str; 5] = ["atrium", "caustic", "columns", "cornell", "cornell-glossy"];

/// Whether a name is that of a built-in scene, with or without a number behind it.
pub(super) fn is_builtin(name: &str) -> bool {
    NAMES.contains(&name.split(':').next().unwrap_or_default())
}

/// The error for a name that is not built in.
pub(super) fn unknown(name: &str) -> SceneError {
    let known = format!("{}; atrium:75k, atrium:262k, atrium:331k have more triangles", {
        NAMES.join(", ")
    });
    SceneError::UnknownBuiltin { name: name.to_owned(), known }
}

/// Makes the scene of a name.
pub(super) fn make(name: &str) -> Result<Draft, SceneError> {
    let detail = |reason: String| SceneError::Detail { name: name.to_owned(), reason };
    let (base, number) = match name.split_once(':') {
        Some((base, number)) => (base, Some(number)),
        None => (name, None),
    };
    let draft = match (base, number) {
        ("atrium", None) => atrium::small(),
        ("atrium", Some(number)) => {
            let triangles = parse_count(number).filter(|count| atrium::RANGE.contains(count));
            atrium::with_triangles(triangles.ok_or_else(|| {
                let (least, most) = (atrium::RANGE.start(), atrium::RANGE.end());
                detail(format!(
                    "`{number}` is not a number of triangles from {least} to {most}, such as `75k`"
                ))
            })?)
        }
        ("caustic", None) => caustic::make(),
        ("columns", None) => columns::make(),
        ("cornell", None) => cornell::diffuse(),
        ("cornell-glossy", None) => cornell::glossy(),
        (known, Some(_)) if NAMES.contains(&known) => {
            return Err(detail("only `atrium` takes a number of triangles".to_owned()));
        }
        _ => return Err(unknown(name)),
    };
    Ok(draft)
}

/// `75k` or `75000`.
fn parse_count(number: &str) -> Option<usize> {
    match number.strip_suffix('k') {
        Some(thousands) => thousands.parse::<usize>().ok()?.checked_mul(1000),
        None => number.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LightKind, Scene};

    #[test]
    fn every_built_in_scene_is_whole() {
        for name in NAMES {
            let scene = Scene::builtin(name).unwrap();
            assert_eq!(scene.name, name);
            // Made by code, they leave nothing to be mended.
            assert_eq!(scene.notes, [], "{name}");
            for mesh in &scene.meshes {
                assert_eq!(mesh.positions.len(), mesh.normals.len());
                assert!(mesh.uvs.len() == mesh.positions.len());
                assert!(mesh.material < scene.materials.len());
                // Shading normals face the same side as the triangles.
                for (corners, positions) in
                    mesh.indices.as_chunks::<3>().0.iter().zip(mesh.triangles())
                {
                    let [a, b, c] = positions.map(glam::Vec3::from);
                    let face = (b - a).cross(c - a).normalize();
                    for &corner in corners {
                        let normal = glam::Vec3::from(mesh.normals[corner as usize]);
                        assert!(normal.is_normalized());
                        assert!(normal.dot(face) > 0.1, "{name}, {}, {positions:?}", mesh.name);
                    }
                }
            }
        }
    }

    #[test]
    fn facts_are_those_of_the_scenes() {
        let facts = |name: &str| {
            let facts = Scene::builtin(name).unwrap().facts();
            facts.iter().filter(|fact| fact.holds).map(|fact| fact.name).collect::<Vec<_>>()
        };
        assert_eq!(facts("cornell"), ["occluders", "spot_light"]);
        assert_eq!(facts("cornell-glossy"), ["occluders", "specular", "spot_light"]);
        assert_eq!(facts("caustic"), ["occluders", "specular", "spot_light"]);
        assert_eq!(facts("columns"), ["occluders", "spot_light"]);
        assert_eq!(
            facts("atrium"),
            ["cutout", "directional_light", "occluders", "specular", "textured"]
        );
    }

    #[test]
    fn the_cornell_box_has_the_published_size() {
        let scene = Scene::builtin("cornell").unwrap();
        assert_eq!(scene.triangle_count(), 30);
        assert_eq!(scene.bounds().min, [0.0, 0.0, 0.0]);
        assert_eq!(scene.bounds().max, [5.56, 5.488, 5.592]);
        // 35 mm of focal length over 25 mm of film.
        assert!((scene.camera.vertical_fov.to_degrees() - 39.3077).abs() < 1e-3);
        assert!(matches!(scene.lights[0].kind, LightKind::Spot { .. }));
    }

    #[test]
    fn the_atrium_has_as_many_triangles_as_asked_for() {
        for (name, triangles) in [
            ("atrium:15k", 15e3),
            ("atrium:20k", 20e3),
            ("atrium:75k", 75e3),
            ("atrium:262k", 262e3),
            ("atrium:331000", 331e3),
        ] {
            let count = Scene::builtin(name).unwrap().triangle_count() as f64;
            assert!((count / triangles - 1.0).abs() < 0.01, "{name}: {count}");
        }
    }

    #[test]
    fn built_in_scenes_are_the_same_every_time() {
        let [one, two] = [(); 2].map(|()| Scene::builtin("atrium").unwrap());
        assert_eq!(one.meshes, two.meshes);
        assert!(one.images == two.images);
        assert_ne!(one.meshes, Scene::builtin("atrium:75k").unwrap().meshes);
    }

    #[test]
    fn names_that_are_not_built_in_are_refused() {
        let message = |name: &str| Scene::load(name).unwrap_err().to_string();
        assert!(message("atriun").contains("atrium, caustic, columns, cornell, cornell-glossy"));
        assert!(message("atrium:9").contains("`9` is not a number of triangles"));
        assert!(message("atrium:many").contains("`many`"));
        assert!(message("cornell:75k").contains("only `atrium`"));
    }
}
