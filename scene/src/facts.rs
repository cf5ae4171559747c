//! What is true of a scene, and what shows it: what the rules in `library.toml` decide by.

use std::cell::RefCell;
use std::collections::BTreeMap;

use super::occlusion::occlusion;
use super::{Image, Light, LightKind, Material, Scene, TextureUse};

/// The least roughness alpha that the rasteriser writes.
const LEAST_ALPHA: f32 = 0.01;

/// Something that is true or false of a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fact {
    /// Its name in `library.toml`.
    pub name: &'static str,
    /// Whether it is true.
    pub holds: bool,
    /// What shows it.
    pub evidence: String,
}

/// All facts of a scene, sorted by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Facts(Vec<Fact>);

impl Facts {
    /// Whether the fact called `name` holds; none where there is no such fact.
    pub fn holds(&self, name: &str) -> Option<bool> {
        self.get(name).map(|fact| fact.holds)
    }

    /// The fact called `name`.
    pub fn get(&self, name: &str) -> Option<&Fact> {
        self.0.iter().find(|fact| fact.name == name)
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &Fact> {
        self.0.iter()
    }

    /// Each by its name, as rules take them.
    pub fn known(&self) -> BTreeMap<String, bool> {
        self.iter().map(|fact| (fact.name.to_owned(), fact.holds)).collect()
    }
}

/// What a material's factors, with the texels that they are multiplied with, ask of the passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Traits {
    /// Some texture has a say in it.
    pub textured: bool,
    /// Some of it is less opaque than its cutoff.
    pub cutout: bool,
    /// It has a normal map, colours of vertices, or a texture at a second set of texture coordinates.
    pub detailed: bool,
    /// Some of its vertices have colours.
    pub colored: bool,
    /// Some of it emits light.
    pub emits: bool,
    /// Some of it reflects specularly.
    pub specular: bool,
    /// The least and the greatest roughness alpha.
    pub alpha: [f32; 2],
}

/// The minimum and the maximum of each channel of images, of those that were requested.
pub(crate) struct Texels<'a> {
    images: &'a [Image],
    ranges: RefCell<BTreeMap<usize, [[u8; 2]; 4]>>,
}

impl<'a> Texels<'a> {
    pub(crate) fn new(images: &'a [Image]) -> Self {
        Self { images, ranges: RefCell::default() }
    }

    /// The range of a channel, 0 to 1, in the image's own encoding, which keeps 0 and 1 and the order. What has no
    /// texture is multiplied with 1. Filters and mip levels give means, which lie within the range.
    fn range(&self, texture: Option<&TextureUse>, channel: usize) -> [f32; 2] {
        let found =
            texture.and_then(|texture| Some((texture.image, self.images.get(texture.image)?)));
        let Some((index, image)) = found else { return [1.0; 2] };
        let mut ranges = self.ranges.borrow_mut();
        let range = ranges.entry(index).or_insert_with(|| {
            let mut range = [[u8::MAX, 0]; 4];
            for texel in image.rgba8.as_chunks::<4>().0 {
                for ([minimum, maximum], value) in range.iter_mut().zip(texel) {
                    (*minimum, *maximum) = ((*minimum).min(*value), (*maximum).max(*value));
                }
            }
            range
        });
        range[channel].map(|value| f32::from(value) / 255.0)
    }

    /// Whether a colour times a texture is black everywhere.
    fn black(&self, color: [f32; 3], texture: Option<&TextureUse>) -> bool {
        color
            .iter()
            .enumerate()
            .all(|(channel, factor)| *factor == 0.0 || self.range(texture, channel)[1] == 0.0)
    }

    /// The minimum opacity of a material: `vertices` is that of its vertices, if they have any.
    fn minimum_opacity(&self, material: &Material, vertices: Option<f32>) -> f32 {
        let texture = self.range(material.base_color_texture.as_ref(), 3)[0];
        material.base_color[3] * texture * vertices.unwrap_or(1.0)
    }

    /// What a material needs of the passes; `vertices` is the minimum opacity of its vertices, if they have any.
    pub(crate) fn traits(&self, material: &Material, vertices: Option<f32>) -> Traits {
        let Material { metallic, dielectric, base_color: [r, g, b, _], .. } = *material;
        let (color, surface) =
            (material.base_color_texture.as_ref(), material.metallic_roughness_texture.as_ref());
        // A filter's weights may sum to a little less than 1.
        let cutout = material.alpha_cutoff.is_some_and(|cutoff| {
            self.minimum_opacity(material, vertices) * (255.0 / 256.0) < cutoff
        });
        let emits =
            material.emits() && !self.black(material.emission, material.emission_texture.as_ref());
        let specular = dielectric > 0.0
            || (metallic > 0.0 && self.range(surface, 2)[1] > 0.0 && !self.black([r, g, b], color));
        let read = color.is_some() || surface.is_some();
        let second = |texture: Option<&TextureUse>| texture.is_some_and(|texture| texture.second);
        let emission = material.emission_texture.as_ref().filter(|_| emits);
        let detailed = vertices.is_some()
            || (material.normal_texture.is_some() && material.normal_scale != 0.0)
            || [color, surface, emission].into_iter().any(second);
        Traits {
            // The pass that cuts out reads an opacity texture, white where there is none.
            textured: cutout || read || (emits && material.emission_texture.is_some()),
            cutout,
            detailed,
            colored: vertices.is_some(),
            emits,
            specular,
            alpha: self
                .range(surface, 1)
                .map(|texel| (material.roughness * texel).powi(2).max(LEAST_ALPHA)),
        }
    }
}

impl Scene {
    /// What each material needs of the passes, in their order.
    pub fn traits(&self) -> Vec<Traits> {
        let texels = Texels::new(&self.images);
        let materials = self.materials.iter().zip(self.opacity_of_vertices());
        materials.map(|(material, vertices)| texels.traits(material, vertices)).collect()
    }

    /// For each material the minimum opacity of its meshes' vertices; none where no mesh has colours of vertices.
    fn opacity_of_vertices(&self) -> Vec<Option<f32>> {
        let mut all = vec![None; self.materials.len()];
        for mesh in self.meshes.iter().filter(|mesh| !mesh.detail.colors.is_empty()) {
            let opacities = mesh.detail.colors.iter().map(|color| color[3]);
            let own = opacities.fold(1.0, f32::min);
            if let Some(minimum) = all.get_mut(mesh.material) {
                *minimum = Some(minimum.map_or(own, |minimum: f32| minimum.min(own)));
            }
        }
        all
    }

    /// What the scene holds, for the rules that turn facts into needs, with what shows it: `cutout`, `detailed`,
    /// `directional_light`, `emissive`, `occluders`, `point_light`, `several_lights`, `specular`, `spot_light`, `textured`.
    ///
    /// A fact that could be either way holds: what follows is that nothing is left out for it.
    pub fn facts(&self) -> Facts {
        self.facts_with(&self.lights)
    }

    /// The facts of the scene as if its light number `light` were the only one; of all where there is no such light.
    pub fn facts_lit_by(&self, light: usize) -> Facts {
        self.facts_with(self.lights.get(light..=light).unwrap_or(&self.lights))
    }

    fn facts_with(&self, lights: &[Light]) -> Facts {
        let texels = Texels::new(&self.images);
        let vertices = self.opacity_of_vertices();
        let mut used: Vec<_> = self.meshes.iter().map(|mesh| mesh.material).collect();
        used.sort_unstable();
        used.dedup();
        let used: Vec<_> = used
            .into_iter()
            .filter_map(|index| Some((self.materials.get(index)?, vertices.get(index)?)))
            .map(|(material, vertices)| (material, *vertices, texels.traits(material, *vertices)))
            .collect();
        let material = |name,
                        test: fn(&Traits) -> bool,
                        shown: &dyn Fn(&Material, Option<f32>) -> String,
                        none: &str| {
            let found = used.iter().find(|(.., traits)| test(traits));
            let evidence = match found {
                Some((material, vertices, _)) => {
                    format!("material `{}` {}", material.name, shown(material, *vertices))
                }
                None => format!("none of {} {none}", count(used.len(), "material")),
            };
            Fact { name, holds: found.is_some(), evidence }
        };
        let light = |name, kind: &str, test: fn(&LightKind) -> bool| {
            let found = lights.iter().find(|light| test(&light.kind));
            let evidence = match found {
                Some(light) => format!("light `{}` is {kind}", light.name),
                None => format!("none of {} is {kind}", count(lights.len(), "light")),
            };
            Fact { name, holds: found.is_some(), evidence }
        };
        let occlusion = occlusion(self);
        Facts(vec![
            material(
                "cutout",
                |traits| traits.cutout,
                &|material, vertices| {
                    let opacity = texels.minimum_opacity(material, vertices);
                    let cutoff = material.alpha_cutoff.unwrap_or_default();
                    format!("has an opacity of {opacity:.3}, its cutoff is {cutoff}")
                },
                "is less opaque than its cutoff anywhere",
            ),
            material(
                "detailed",
                |traits| traits.detailed,
                &|material, vertices| match vertices {
                    Some(_) => "has colours of vertices".to_owned(),
                    None if material.normal_texture.is_some() => "has a normal map".to_owned(),
                    None => "has textures at two sets of texture coordinates".to_owned(),
                },
                "has a normal map, colours of vertices or two sets of texture coordinates",
            ),
            light("directional_light", "directional", |kind| {
                matches!(kind, LightKind::Directional)
            }),
            material(
                "emissive",
                |traits| traits.emits,
                &|material, _| {
                    let [r, g, b] = material.emission;
                    format!("emits ({r}, {g}, {b})")
                },
                "emits light",
            ),
            Fact { name: "occluders", holds: occlusion.possible, evidence: occlusion.evidence },
            light("point_light", "a point", |kind| matches!(kind, LightKind::Point)),
            Fact {
                name: "several_lights",
                holds: lights.len() > 1,
                evidence: format!("it is lit by {}", count(lights.len(), "light")),
            },
            material(
                "specular",
                |traits| traits.specular,
                &|material, _| {
                    if material.dielectric > 0.0 {
                        format!("has a specular reflectance of {}", material.dielectric)
                    } else {
                        format!("is metallic ({})", material.metallic)
                    }
                },
                "has any specular reflectance",
            ),
            light("spot_light", "a spot", |kind| matches!(kind, LightKind::Spot { .. })),
            material(
                "textured",
                |traits| traits.textured,
                &|material, _| match material.textures().count() {
                    0 => "is cut out, which a texture does".to_owned(),
                    textures => format!("has {}", count(textures, "texture")),
                },
                "has a texture that changes anything",
            ),
        ])
    }
}

fn count(number: usize, what: &str) -> String {
    if number == 1 { format!("1 {what}") } else { format!("{number} {what}s") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mesh;

    /// One texel in each image: what a texture multiplies with everywhere.
    fn scene(material: Material, texels: &[[u8; 4]]) -> Scene {
        let image = |texel: &[u8; 4]| Image {
            name: "texels".to_owned(),
            width: 1,
            height: 2,
            rgba8: [*texel, *texel].concat(),
            srgb: false,
        };
        let mut scene = Scene::builtin("cornell").unwrap();
        scene.meshes = vec![quad([[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])];
        scene.materials = vec![material];
        scene.images = texels.iter().map(image).collect();
        scene
    }

    fn quad(corners: [[f32; 3]; 4]) -> Mesh {
        Mesh {
            name: "quad".to_owned(),
            positions: corners.to_vec(),
            normals: vec![[0.0, 0.0, 1.0]; 4],
            uvs: vec![[0.0; 2]; 4],
            indices: vec![0, 1, 2, 0, 2, 3],
            material: 0,
            detail: crate::Detail::default(),
        }
    }

    fn holds(scene: &Scene, name: &str) -> bool {
        let facts = scene.facts();
        let fact = facts.get(name).unwrap();
        assert!(!fact.evidence.is_empty());
        fact.holds
    }

    #[test]
    fn a_texture_that_takes_everything_away_is_seen() {
        let texture = |index| Some(TextureUse::repeating(index));
        let grey = || Material::diffuse("grey", [0.5; 3]);
        let metal = Material {
            metallic: 1.0,
            roughness: 0.4,
            metallic_roughness_texture: texture(0),
            ..grey()
        };
        let lamp = Material { emission: [2.0, 0.0, 0.0], emission_texture: texture(0), ..grey() };
        let mask = Material { alpha_cutoff: Some(0.5), base_color_texture: texture(0), ..grey() };
        let black = Material { base_color: [0.0, 0.0, 0.0, 1.0], ..metal.clone() };
        for (fact, material, texel, expected) in [
            ("specular", &metal, [255, 255, 0, 255], false),
            ("specular", &metal, [255, 255, 1, 255], true),
            ("specular", &black, [255, 255, 255, 255], false),
            ("emissive", &lamp, [0, 255, 255, 255], false),
            ("emissive", &lamp, [1, 0, 0, 255], true),
            ("textured", &lamp, [0, 255, 255, 255], false),
            ("textured", &lamp, [255, 255, 255, 255], true),
            ("textured", &mask, [255, 255, 255, 255], true),
            ("cutout", &mask, [255, 255, 255, 129], false),
            ("cutout", &mask, [255, 255, 255, 127], true),
        ] {
            let scene = scene(material.clone(), &[texel]);
            assert_eq!(
                holds(&scene, fact),
                expected,
                "{fact} of {} times {texel:?}",
                material.name
            );
        }
        // What no mesh is made of does not count.
        let mut unused = scene(grey(), &[]);
        unused.materials.push(Material { dielectric: 0.04, ..grey() });
        assert!(!holds(&unused, "specular"));
        unused.meshes[0].material = 1;
        assert!(holds(&unused, "specular"));
    }

    #[test]
    fn a_light_that_is_not_used_does_not_count() {
        let mut scene = scene(Material::diffuse("grey", [0.5; 3]), &[]);
        scene.lights.push(Light { kind: LightKind::Point, ..scene.lights[0].clone() });
        let lights = |facts: &Facts| {
            ["spot_light", "point_light", "several_lights"]
                .map(|fact| facts.holds(fact).unwrap_or_default())
        };
        assert_eq!(lights(&scene.facts()), [true, true, true]);
        assert_eq!(lights(&scene.facts_lit_by(0)), [true, false, false]);
        assert_eq!(lights(&scene.facts_lit_by(1)), [false, true, false]);
    }

    #[test]
    fn what_is_convex_from_within_has_no_occluders() {
        let matt = Material::diffuse("matt", [0.5; 3]);
        let floor = [[0.0; 3], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]];
        // Faces +y into the room above the floor.
        let wall = [[4.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [4.0, 0.0, 3.0]];
        let back = [wall[3], wall[2], wall[1], wall[0]];
        let table = [[1.0, 1.0, 1.0], [2.0, 1.0, 1.0], [2.0, 2.0, 1.0], [1.0, 2.0, 1.0]];
        let sunk = [[0.0, 0.0, -1e-9], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]];
        let occluders = |quads: &[[[f32; 3]; 4]], double_sided: bool| {
            let mut scene = scene(Material { double_sided, ..matt.clone() }, &[]);
            scene.meshes = quads.iter().map(|corners| quad(*corners)).collect();
            holds(&scene, "occluders")
        };
        assert!(!occluders(&[floor], false) && !occluders(&[floor], true));
        assert!(!occluders(&[floor, wall], false));
        assert!(!occluders(&[sunk, wall], false), "rounding is no occluder");
        assert!(
            occluders(&[floor, wall], true),
            "the wall's other side hides it from what is beyond"
        );
        assert!(occluders(&[floor, back], false), "the floor lies behind the wall");
        assert!(occluders(&[floor, wall, table], false));
    }

    #[test]
    fn what_would_take_too_long_to_prove_may_hide_something() {
        let mut scene = scene(Material::diffuse("matt", [0.5; 3]), &[]);
        let flat = scene.meshes.remove(0);
        scene.meshes = vec![flat; 1500];
        let facts = scene.facts();
        let fact = facts.get("occluders").unwrap();
        assert!(fact.holds && fact.evidence.contains("too many"), "{}", fact.evidence);
    }
}
