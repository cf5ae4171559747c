//! Materials and their textures.

use std::path::Path;

use gltf::material::AlphaMode;
use gltf::texture::{Info, MagFilter, MinFilter, WrappingMode};
use serde_json::Value;

use super::buffer::{Views, read_uri};
use crate::note::{NoteKind, Notes};
use crate::{Filter, Image, Material, SceneError, TextureUse, UvTransform, Wrap};

/// Specular reflectance of the metallic-roughness model's dielectric at normal incidence.
/// [glTF 2.0, appendix B.2.2]
const DIELECTRIC: f32 = 0.04;

/// Converts materials, and decodes the images that they use.
pub(super) struct Materials<'a> {
    file: &'a Path,
    document: &'a gltf::Document,
    views: &'a Views,
    pub(super) images: Vec<Image>,
    /// Which image of the file, read as sRGB or not, each of `images` is.
    origins: Vec<(usize, bool)>,
}

/// A material, and which set of texture coordinates its meshes need.
pub(super) struct Converted {
    pub(super) material: Material,
    pub(super) uv_set: u32,
}

impl<'a> Materials<'a> {
    pub(super) fn new(file: &'a Path, document: &'a gltf::Document, views: &'a Views) -> Self {
        Self { file, document, views, images: Vec::new(), origins: Vec::new() }
    }

    pub(super) fn convert(
        &mut self,
        source: &gltf::Material<'_>,
        notes: &mut Notes,
    ) -> Result<Converted, SceneError> {
        let pbr = source.pbr_metallic_roughness();
        let index =
            source.index().map_or("default material".to_owned(), |i| format!("material {i}"));
        let name = source.name().map_or(index, str::to_owned);
        let mut ignored = |what: &str| notes.add(NoteKind::Ignored, what, &name);
        if source.normal_texture().is_some() {
            ignored("normal map");
        }
        if source.occlusion_texture().is_some() {
            ignored("occlusion map: occlusion is what is computed");
        }
        if let Some(Value::Object(specular)) = source.extension_value("KHR_materials_specular")
            && specular.keys().any(|key| key != "specularFactor")
        {
            ignored("specular colour and specular map");
        }
        let emission_scale = source.emissive_strength().unwrap_or(1.0);
        let mut base_color_info = pbr.base_color_texture();
        let mut metallic_roughness_info = pbr.metallic_roughness_texture();
        let emission_info = source.emissive_texture();
        let mut material = Material {
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
        if let Some(specular) = source.pbr_specular_glossiness() {
            let text = "specular-glossiness converted to metallic-roughness";
            notes.add(NoteKind::Assumed, text, &name);
            if specular.specular_glossiness_texture().is_some() {
                notes.add(NoteKind::Ignored, "specular-glossiness map", &name);
            }
            from_specular_glossiness(&mut material, &specular);
            base_color_info = specular.diffuse_texture();
            metallic_roughness_info = None;
        }
        // A mesh has one set of texture coordinates: that of the base colour, or of whatever there is.
        let set = |info: &Info<'_>| {
            let moved = info.texture_transform().and_then(|transform| transform.tex_coord());
            moved.unwrap_or(info.tex_coord())
        };
        let infos = [base_color_info, metallic_roughness_info, emission_info];
        let uv_set = infos.iter().flatten().map(set).next().unwrap_or(0);
        let mut uses = [None; 3];
        for ((usage, info), srgb) in uses.iter_mut().zip(infos).zip([true, false, true]) {
            let Some(info) = info else { continue };
            if set(&info) == uv_set {
                *usage = Some(self.texture(&info, srgb)?);
            } else {
                let text = "texture on another set of texture coordinates than the base colour";
                notes.add(NoteKind::Ignored, text, &name);
            }
        }
        [
            material.base_color_texture,
            material.metallic_roughness_texture,
            material.emission_texture,
        ] = uses;
        Ok(Converted { material, uv_set })
    }

    fn texture(&mut self, info: &Info<'_>, srgb: bool) -> Result<TextureUse, SceneError> {
        let texture = info.texture();
        let sampler = texture.sampler();
        let wrap = |mode| match mode {
            WrappingMode::Repeat => Wrap::Repeat,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::ClampToEdge => Wrap::Clamp,
        };
        use Filter::{Linear, Nearest};
        let (minify, mip) = match sampler.min_filter() {
            Some(MinFilter::Nearest) => (Nearest, None),
            Some(MinFilter::Linear) => (Linear, None),
            Some(MinFilter::NearestMipmapNearest) => (Nearest, Some(Nearest)),
            Some(MinFilter::LinearMipmapNearest) => (Linear, Some(Nearest)),
            Some(MinFilter::NearestMipmapLinear) => (Nearest, Some(Linear)),
            Some(MinFilter::LinearMipmapLinear) | None => (Linear, Some(Linear)),
        };
        Ok(TextureUse {
            image: self.image(texture.source().index(), srgb)?,
            wrap: [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())],
            magnify: if sampler.mag_filter() == Some(MagFilter::Nearest) {
                Nearest
            } else {
                Linear
            },
            minify,
            mip,
            transform: info.texture_transform().map_or(UvTransform::default(), |transform| {
                UvTransform {
                    offset: transform.offset(),
                    rotation: transform.rotation(),
                    scale: transform.scale(),
                }
            }),
        })
    }

    /// Decodes an image once for each way it is read.
    fn image(&mut self, index: usize, srgb: bool) -> Result<usize, SceneError> {
        if let Some(known) = self.origins.iter().position(|&origin| origin == (index, srgb)) {
            return Ok(known);
        }
        let json = &self.document.as_json().images[index];
        let file_name = json.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
        let named = file_name.or(json.name.as_deref());
        let name = named.map_or_else(|| index.to_string(), str::to_owned);
        let fault = |reason: String| SceneError::Image {
            file: self.file.into(),
            image: name.clone(),
            reason,
        };
        let image = match (&json.buffer_view, &json.uri) {
            (Some(view), _) => Image::decode(&name, self.views.get(view.value()), srgb),
            (None, Some(uri)) => Image::decode(&name, &read_uri(self.file, uri)?.1, srgb),
            (None, None) => Err("has neither a buffer view nor a URI".to_owned()),
        };
        self.images.push(image.map_err(fault)?);
        self.origins.push((index, srgb));
        Ok(self.images.len() - 1)
    }
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

/// Finds base colour, metallic and dielectric with the same `R_d` and `R_s`: exactly where the
/// specular colour is grey, else with the same mean over the channels.
fn from_specular_glossiness(
    material: &mut Material,
    source: &gltf::material::PbrSpecularGlossiness<'_>,
) {
    let mean = |color: [f32; 3]| color.iter().sum::<f32>() / 3.0;
    let [r, g, b, alpha] = source.diffuse_factor();
    let specular = source.specular_factor();
    let [smallest, largest] = [specular.iter().copied().fold(1.0, f32::min), {
        specular.iter().copied().fold(0.0, f32::max)
    }];
    // [KHR_materials_pbrSpecularGlossiness: c_diff = diffuse (1 - max(specular))]
    let diffuse = [r, g, b].map(|channel| channel * (1.0 - largest));
    material.roughness = 1.0 - source.glossiness_factor();
    material.dielectric = smallest;
    if largest - smallest <= 1e-3 {
        material.metallic = 0.0;
        material.base_color = [diffuse[0], diffuse[1], diffuse[2], alpha];
        return;
    }
    // With t = 1 - metallic and d the dielectric, R_d = base t and R_s = d t + base (1 - t), so
    // base = R_d + R_s - d t and d t^2 - (D + S) t + D = 0 for the means D and S; the smaller root,
    // in the form that does not cancel.
    let (d, s) = (mean(diffuse), mean(specular));
    let root = ((d + s) * (d + s) - 4.0 * smallest * d).max(0.0).sqrt();
    let t = (2.0 * d / (d + s + root)).clamp(0.0, 1.0);
    let base = |i: usize| (diffuse[i] + specular[i] - smallest * t).clamp(0.0, 1.0);
    material.metallic = 1.0 - t;
    material.base_color = [base(0), base(1), base(2), alpha];
}
