//! Whether anything can hide one surface of a scene from another.

use glam::DVec3;

use super::Scene;

/// The most pairs of a triangle and a vertex that are looked at, a fraction of a second's work.
pub const MOST_PAIRS: usize = 1 << 24;

/// How far behind a triangle a vertex may lie and count as in its plane, in units of the scene's radius: a hundredth of
/// the distance within which nothing hides a virtual light (`Config::least_near` of [`sglow_renderer::frame::Renderer`]).
pub const PLANE: f64 = 1e-6;

/// An answer with what shows it.
pub(super) struct Occlusion {
    /// Whether something can, for all that was shown.
    pub(super) possible: bool,
    pub(super) evidence: String,
}

/// Nothing can hide a surface from another where every vertex lies in front of every triangle, or in its plane: a
/// straight line between two surfaces would have to cross a triangle to be interrupted, and so reach behind it. The
/// surfaces then are the inside of something convex, or a plane. Where a triangle has two sides, both count as its
/// front. Lights may be anywhere: what counts is what lies between surfaces.
pub(super) fn occlusion(scene: &Scene) -> Occlusion {
    let double = DVec3::from;
    let wide = |point: [f32; 3]| double(point.map(f64::from));
    let tolerance = PLANE * f64::from(scene.bounds().radius());
    let mut pairs = 0;
    for mesh in &scene.meshes {
        let both = scene.materials.get(mesh.material).is_some_and(|of| of.double_sided);
        for corners in mesh.triangles() {
            let [a, b, c] = corners.map(wide);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            for other in &scene.meshes {
                let behind = |point: &&[f32; 3]| {
                    let height = normal.dot(wide(**point) - a);
                    height < -tolerance || (both && height > tolerance)
                };
                if other.positions.iter().any(|point| behind(&point)) {
                    let evidence =
                        format!("`{}` reaches behind a triangle of `{}`", other.name, mesh.name);
                    return Occlusion { possible: true, evidence };
                }
                pairs += other.positions.len();
                if pairs > MOST_PAIRS {
                    let evidence = format!(
                        "nothing was found in {MOST_PAIRS} pairs of triangles and vertices, and there are too many to prove it"
                    );
                    return Occlusion { possible: true, evidence };
                }
            }
        }
    }
    let evidence =
        "every vertex lies in front of every triangle: a plane, or the inside of something convex";
    Occlusion { possible: false, evidence: evidence.to_owned() }
}
