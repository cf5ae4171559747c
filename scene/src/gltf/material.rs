//! Materials and their textures.

use gltf::material::AlphaMode;
use gltf::texture::Info;
use serde_json::Value;

use super::specular;
use super::texture::{Place, Textures};
use crate::note::{NoteKind, Notes};
use crate::{Material, TextureUse};

/// Specular reflectance of the metallic-roughness model's dielectric at normal incidence.
/// [glTF 2.0, appendix B.2.2]
const DIELECTRIC: f32 = 0.04;

/// Where textures stand in [`Converted::sets`].
const BASE_COLOR: usize = 0;
const SURFACE: usize = 1;
const EMISSION: usize = 2;
const NORMAL: usize = 3;

/// A material, and which set of texture coordinates each of its textures is read at: base colour, metallic and
/// roughness, emission, normals.
#[derive(Clone, Debug)]
pub(super) struct Converted {
    pub(super) material: Material,
    pub(super) sets: [u32; 4],
}

impl Converted {
    /// The set that the mesh's texture coordinates are: that of the first texture.
    pub(super) fn main_set(&self) -> u32 {
        let sets = self.textures().into_iter().zip(self.sets);
        sets.filter(|(texture, _)| texture.is_some()).map(|(_, set)| set).next().unwrap_or(0)
    }

    /// In the order of [`slots`].
    pub(super) fn textures(&self) -> [Option<TextureUse>; 4] {
        let material = &self.material;
        [
            material.base_color_texture,
            material.metallic_roughness_texture,
            material.emission_texture,
            material.normal_texture,
        ]
    }
}

/// A material's textures in the order of [`Converted::sets`].
pub(super) fn slots(material: &mut Material) -> [&mut Option<TextureUse>; 4] {
    [
        &mut material.base_color_texture,
        &mut material.metallic_roughness_texture,
        &mut material.emission_texture,
        &mut material.normal_texture,
    ]
}

/// Takes a texture away: its factor must not stay without it, for that is 1 where a texture says all. What the picture
/// then lacks.
pub(super) fn neutral(material: &mut Material, slot: usize) -> &'static str {
    match slot {
        BASE_COLOR => {
            material.base_color_texture = None;
            "the base colour is its factor everywhere"
        }
        SURFACE => {
            material.metallic_roughness_texture = None;
            material.metallic = 0.0;
            "the surface is not metallic, its roughness is the factor"
        }
        EMISSION => {
            material.emission_texture = None;
            material.emission = [0.0; 3];
            "the surface emits nothing"
        }
        _ => {
            material.normal_texture = None;
            "the surface is shaded smooth"
        }
    }
}

/// Converts a material, and decodes the images that it uses.
pub(super) fn convert(
    source: &gltf::Material<'_>,
    textures: &mut Textures<'_>,
    notes: &mut Notes,
) -> Converted {
    let pbr = source.pbr_metallic_roughness();
    let index = source.index().map_or("default material".to_owned(), |i| format!("material {i}"));
    let name = source.name().map_or(index, str::to_owned);
    let mut ignored = |what: &str| notes.add(NoteKind::Ignored, what, &name);
    if source.occlusion_texture().is_some() {
        ignored("occlusion map: occlusion is what is computed");
    }
    if let Some(Value::Object(specular)) = source.extension_value("KHR_materials_specular")
        && specular.keys().any(|key| key != "specularFactor")
    {
        ignored(
            "specular colour and specular map: the reflectance is grey and the same everywhere",
        );
    }
    let emission_scale = source.emissive_strength().unwrap_or(1.0);
    let material = Material {
        base_color: pbr.base_color_factor(),
        roughness: pbr.roughness_factor(),
        metallic: pbr.metallic_factor(),
        dielectric: dielectric(source),
        emission: source.emissive_factor().map(|channel| channel * emission_scale),
        double_sided: source.double_sided(),
        alpha_cutoff: match source.alpha_mode() {
            AlphaMode::Opaque => None,
            AlphaMode::Mask => Some(source.alpha_cutoff().unwrap_or(0.5)),
            AlphaMode::Blend => {
                notes.add(NoteKind::Assumed, "blended alpha is cut off at 0.5", &name);
                Some(0.5)
            }
        },
        ..Material::diffuse(&name, [1.0; 3])
    };
    let mut converted = Converted { material, sets: [0; 4] };
    let specular = source.pbr_specular_glossiness();
    let infos = match &specular {
        Some(specular) => [specular.diffuse_texture(), None, source.emissive_texture()],
        None => {
            [pbr.base_color_texture(), pbr.metallic_roughness_texture(), source.emissive_texture()]
        }
    };
    if let Some(specular) = &specular {
        let text = "specular-glossiness converted to metallic-roughness";
        notes.add(NoteKind::Assumed, text, &name);
        specular::of_factors(&mut converted.material, specular);
    }
    let mut uses = [None; 4];
    let mut read = |slot: usize, place: Place<'_>, converted: &mut Converted, notes: &mut Notes| {
        converted.sets[slot] = place.set;
        match textures.read(&place, slot != SURFACE && slot != NORMAL) {
            Ok(usage) => uses[slot] = Some(usage),
            Err(reason) => {
                let lacks = neutral(&mut converted.material, slot);
                notes.add(NoteKind::Ignored, format!("{reason}; {lacks}"), &name);
            }
        }
    };
    for (slot, info) in infos.iter().enumerate() {
        if let Some(info) = info {
            read(slot, Place::of(info), &mut converted, notes);
        }
    }
    if let Some(normal) = source.normal_texture() {
        converted.material.normal_scale = normal.scale();
        read(NORMAL, Place::of_normals(&normal), &mut converted, notes);
    }
    for (slot, usage) in slots(&mut converted.material).into_iter().zip(uses) {
        *slot = usage;
    }
    if let Some(specular) = &specular
        && let Some(info) = specular.specular_glossiness_texture()
    {
        let result =
            specular_map(&mut converted, specular, &info, infos[BASE_COLOR].is_some(), textures);
        if let Err(reason) = result {
            let material = &mut converted.material;
            (material.dielectric, material.metallic, material.roughness) = (DIELECTRIC, 0.0, 1.0);
            let [r, g, b, alpha] = specular.diffuse_factor();
            material.base_color = [r, g, b, alpha];
            let text = format!("specular-glossiness map: {reason}; the reflectance is 0.04");
            notes.add(NoteKind::Ignored, text, &name);
        }
    }
    converted
}

/// Reads the map of specular colour and glossiness.
fn specular_map(
    converted: &mut Converted,
    source: &gltf::material::PbrSpecularGlossiness<'_>,
    info: &Info<'_>,
    diffuse_named: bool,
    textures: &mut Textures<'_>,
) -> Result<(), String> {
    let place = Place::of(info);
    let usage = textures.read(&place, true)?;
    let diffuse = converted.material.base_color_texture;
    let set = place.set;
    if diffuse_named
        && diffuse.is_some_and(|diffuse| {
            diffuse.transform != usage.transform || converted.sets[BASE_COLOR] != set
        })
    {
        return Err("is read at other texture coordinates than the diffuse one".to_owned());
    }
    specular::of_maps(&mut converted.material, source, textures, diffuse, usage)?;
    converted.sets[BASE_COLOR] = set;
    converted.sets[SURFACE] = set;
    Ok(())
}

/// [KHR_materials_ior: ((ior - 1) / (ior + 1))^2] [KHR_materials_specular: times specularFactor]
fn dielectric(source: &gltf::Material<'_>) -> f32 {
    let number = |extension: &str, key: &str| {
        let value = source.extension_value(extension)?.get(key)?;
        Value::as_f64(value).map(|number| number as f32)
    };
    let of_ior = number("KHR_materials_ior", "ior").map_or(DIELECTRIC, |ior| {
        let ratio = (ior - 1.0) / (ior + 1.0);
        ratio * ratio
    });
    let scale = number("KHR_materials_specular", "specularFactor").unwrap_or(1.0);
    (of_ior * scale).clamp(0.0, 1.0)
}
