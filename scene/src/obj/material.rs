//! Materials of MTL as ours.
//!
//! `Kd` is the base colour, the mean of `Ks` the dielectric's reflectance, `Ns` the exponent of a Blinn lobe, `Ke` the
//! emission; with `Pr` or `Pm` roughness and metallic are those, and the dielectric's reflectance follows from `Ni`.
//! Colours are taken as linear.

use std::cell::Cell;
use std::collections::HashMap;

use super::library::{Finder, Found};
use super::mtl::{Definition, Map};
use crate::note::{NoteKind, Notes};
use crate::{Image, Material, TextureUse, UvTransform, Wrap};

/// Specular reflectance at normal incidence of what does not say its own. [glTF 2.0, appendix B.2.2]
const DIELECTRIC: f32 = 0.04;

/// The images of a scene while its materials are converted.
pub(super) struct Images<'a> {
    finder: &'a Finder<'a>,
    pub(super) images: Vec<Image>,
    /// By what they are made of.
    known: HashMap<String, Result<usize, String>>,
    /// How many texels were decoded, those included that were not kept.
    worked: Cell<usize>,
}

/// How many times the limit of texels may be decoded for images that are not kept.
const MOST_WORK: usize = 4;

/// What a map is made into.
enum Use<'m> {
    /// An sRGB colour.
    Color(&'m Map),
    /// A colour, and the opacity.
    Cut(Option<&'m Map>, &'m Map),
    /// Roughness in green, metallic in blue.
    Surface(Option<&'m Map>, Option<&'m Map>),
    Normal(&'m Map),
}

impl<'a> Images<'a> {
    pub(super) fn new(finder: &'a Finder<'a>) -> Self {
        Self { finder, images: Vec::new(), known: HashMap::new(), worked: Cell::new(0) }
    }

    fn decode(&self, map: &Map, srgb: bool, notes: &mut Notes) -> Result<Image, String> {
        let limits = &self.finder.files.options.limits;
        let Found { path, alike, bytes } =
            self.finder.read(&map.name).map_err(|fault| fault.to_string())?;
        if alike {
            let text = "image of the same name in the scene's folder";
            notes.add(NoteKind::Assumed, text, &map.name);
        }
        let taken: usize = self.images.iter().map(Image::texels).sum();
        let work = limits.texels.saturating_mul(MOST_WORK).saturating_sub(self.worked.get());
        let left = limits.texels.saturating_sub(taken).min(work);
        let image = Image::decode(&map.name, &bytes, srgb, limits, left)
            .map_err(|reason| format!("{}: {reason}", path.display()))?;
        self.worked.set(self.worked.get() + image.texels());
        Ok(image)
    }

    /// The index of an image, made when it is first used.
    fn index(&mut self, usage: &Use<'_>, notes: &mut Notes) -> Result<usize, String> {
        let of = |map: Option<&Map>| map.map(|map| (map.name.clone(), map.channel));
        let key = match usage {
            Use::Color(map) => format!("{:?}", &map.name),
            Use::Normal(map) => format!("normals {:?}", &map.name),
            Use::Cut(color, opacity) => format!("cut {:?} {:?}", of(*color), of(Some(*opacity))),
            Use::Surface(roughness, metallic) => {
                format!("surface {:?} {:?}", of(*roughness), of(*metallic))
            }
        };
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let made = match usage {
            Use::Color(map) => self.decode(map, true, notes),
            Use::Normal(map) => self.decode(map, false, notes),
            Use::Cut(color, opacity) => self.cut(*color, opacity, notes),
            Use::Surface(roughness, metallic) => self.surface(*roughness, *metallic, notes),
        };
        let index = made.map(|image| {
            self.images.push(image);
            self.images.len() - 1
        });
        self.known.insert(key, index.clone());
        index
    }

    /// A colour with the opacity of another map in its alpha.
    fn cut(&self, color: Option<&Map>, opacity: &Map, notes: &mut Notes) -> Result<Image, String> {
        let mask = self.decode(opacity, false, notes)?;
        let channel = opacity.channel.unwrap_or(if mask.has_alpha() { 'm' } else { 'l' });
        let color = color.map(|map| self.decode(map, true, notes)).transpose()?;
        let size = larger([Some(&mask), color.as_ref()]);
        self.fits(size)?;
        let name = format!("{} with {}", color.as_ref().map_or("white", |c| &c.name), mask.name);
        Ok(Image::make(&name, size, true, |u, v| {
            let [r, g, b, _] = color.as_ref().map_or([1.0; 4], |color| color.nearest(u, v));
            [r, g, b, scalar(mask.nearest(u, v), channel)]
        }))
    }

    /// Roughness and metallic of maps of their own; what has none is 1.
    fn surface(
        &self,
        roughness: Option<&Map>,
        metallic: Option<&Map>,
        notes: &mut Notes,
    ) -> Result<Image, String> {
        type Read = Option<(Image, Option<char>)>;
        let mut read = |map: Option<&Map>| -> Result<Read, String> {
            let Some(map) = map else { return Ok(None) };
            Ok(Some((self.decode(map, false, notes)?, map.channel)))
        };
        let (roughness, metallic) = (read(roughness)?, read(metallic)?);
        let size =
            larger([roughness.as_ref(), metallic.as_ref()].map(|one| one.map(|(image, _)| image)));
        self.fits(size)?;
        let name =
            [&roughness, &metallic].into_iter().flatten().map(|(image, _)| image.name.as_str());
        let name = name.collect::<Vec<_>>().join(" and ");
        let at = |of: &Read, u, v| {
            of.as_ref()
                .map_or(1.0, |(image, channel)| scalar(image.nearest(u, v), channel.unwrap_or('l')))
        };
        Ok(Image::make(&name, size, false, |u, v| {
            [0.0, at(&roughness, u, v), at(&metallic, u, v), 1.0]
        }))
    }

    /// Whether another image of that size is within the limits.
    fn fits(&self, [width, height]: [u32; 2]) -> Result<(), String> {
        let limits = &self.finder.files.options.limits;
        let taken: usize = self.images.iter().map(Image::texels).sum();
        let count = width as usize * height as usize;
        if count > limits.image_texels || taken.saturating_add(count) > limits.texels {
            return Err(format!("together they take {count} texels, more than the limit"));
        }
        Ok(())
    }
}

/// The larger of two images' sizes along each side.
fn larger(images: [Option<&Image>; 2]) -> [u32; 2] {
    let sizes = images.into_iter().flatten().map(|image| [image.width, image.height]);
    sizes.fold([1; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])])
}

/// A number of a texel: `-imfchan` r, g, b, m (alpha), and else luminance.
fn scalar([r, g, b, a]: [f32; 4], channel: char) -> f32 {
    match channel {
        'r' => r,
        'g' => g,
        'b' => b,
        'm' => a,
        _ => 0.2126 * r + 0.7152 * g + 0.0722 * b,
    }
}

/// How a map is read.
fn usage(map: &Map, image: usize) -> TextureUse {
    // v points up there and down here.
    let offset = [map.offset[0], 1.0 - map.scale[1] - map.offset[1]];
    TextureUse {
        wrap: [if map.clamp { Wrap::Clamp } else { Wrap::Repeat }; 2],
        transform: UvTransform { offset, rotation: 0.0, scale: map.scale },
        ..TextureUse::repeating(image)
    }
}

/// Converts a material; maps that cannot be read take a neutral value, and a note says what the picture lacks.
pub(super) fn convert(source: &Definition, images: &mut Images<'_>, notes: &mut Notes) -> Material {
    let name = source.name.cut.as_str();
    let number = |key: &str| source.numbers.get(key).copied();
    let map = |key: &str| source.maps.get(key);
    let mut lost = |map: &Map, reason: &str, lacks: &str, notes: &mut Notes| {
        let message = format!("material `{name}`: image `{}`: {reason}; {lacks}", map.name);
        notes.add_at(NoteKind::Ignored, &source.file, map.place, &message);
    };
    // A map times 0 is no use of it: what is meant is the map.
    let factor = |color: Option<[f32; 3]>, map: Option<&Map>, notes: &mut Notes, key: &str| match (
        color, map,
    ) {
        (Some(color), Some(_)) if color == [0.0; 3] => {
            notes.add(NoteKind::Assumed, format!("{key} of 0 beside its map taken as 1"), name);
            Some([1.0; 3])
        }
        (None, Some(_)) => Some([1.0; 3]),
        (color, _) => color,
    };
    let color = |key: &str| source.colors.get(key).copied();
    let kd = factor(color("kd"), map("kd"), notes, "Kd").unwrap_or([1.0; 3]);
    let mut material = Material::diffuse(name, kd);

    opacity(source, &mut material, notes);
    let cut =
        map("d").filter(|_| material.alpha_cutoff.is_none_or(|_| material.base_color[3] > 0.0));
    let base = match (map("kd"), cut) {
        (color, Some(opacity)) => Some((opacity, Use::Cut(color, opacity))),
        (Some(color), None) => Some((color, Use::Color(color))),
        (None, None) => None,
    };
    if let Some((shown, made)) = base {
        if let Some(color) = map("kd")
            && matches!(made, Use::Cut(..))
            && (color.scale, color.offset, color.clamp) != (shown.scale, shown.offset, shown.clamp)
        {
            notes.add(NoteKind::Assumed, "map_Kd is read at the places of map_d", name);
        }
        match images.index(&made, notes) {
            Ok(image) => {
                material.base_color_texture = Some(usage(shown, image));
                if matches!(made, Use::Cut(..)) {
                    material.alpha_cutoff = Some(0.5);
                }
            }
            Err(reason) if matches!(made, Use::Cut(..)) => {
                lost(shown, &reason, "the surface has no holes", notes);
                if let Some(color) = map("kd") {
                    match images.index(&Use::Color(color), notes) {
                        Ok(image) => material.base_color_texture = Some(usage(color, image)),
                        Err(reason) => {
                            lost(color, &reason, "the base colour is Kd everywhere", notes)
                        }
                    }
                }
            }
            Err(reason) => lost(shown, &reason, "the base colour is Kd everywhere", notes),
        }
    }

    if let Some(emission) = factor(color("ke"), map("ke"), notes, "Ke") {
        material.emission = emission;
    }
    if let Some(map) = map("ke") {
        match images.index(&Use::Color(map), notes) {
            Ok(image) => material.emission_texture = Some(usage(map, image)),
            Err(reason) => {
                lost(map, &reason, "the surface emits nothing", notes);
                material.emission = [0.0; 3];
            }
        }
    }

    normals(source, &mut material, images, &mut lost, notes);
    let physical = ["pr", "pm"].iter().any(|key| number(key).is_some() || map(key).is_some());
    // [Walter et al. 2007, section 5.2: alpha = sqrt(2 / (n + 2))]; roughness is its square root.
    let exponent = number("ns").unwrap_or(0.0).max(0.0);
    material.roughness = (2.0 / (exponent + 2.0)).powf(0.25);
    if physical {
        physically_based(source, &mut material, images, &mut lost, notes);
    } else {
        let mean = |color: [f32; 3]| (color.iter().sum::<f32>() / 3.0).clamp(0.0, 1.0);
        material.dielectric = match (color("ks"), map("ks")) {
            (ks, None) => ks.map_or(0.0, mean),
            (ks, Some(map)) => match images.decode(map, true, notes) {
                Ok(image) => {
                    let text = "map_Ks: the reflectance is its mean everywhere";
                    notes.add(NoteKind::Assumed, text, name);
                    let [r, g, b, _] = image.mean();
                    mean(ks.unwrap_or([1.0; 3])) * mean([r, g, b])
                }
                Err(reason) => {
                    lost(map, &reason, "the reflectance is 0.04", notes);
                    DIELECTRIC
                }
            },
        };
        if number("illum").is_some_and(|illum| illum < 2.0) && material.dielectric > 0.0 {
            notes.add(
                NoteKind::Assumed,
                "illum 0 and 1 have no highlight; Ks is read all the same",
                name,
            );
        }
    }
    if let Some(ambient) = color("ka")
        && ambient.iter().any(|&channel| channel > 0.0)
    {
        let text = "ambient colour Ka; a surface emits by Ke";
        notes.add(NoteKind::Ignored, text, format!("{name}: Ka {ambient:?}"));
    }
    material
}

/// `norm`, and `map_Bump` where its image holds normals, as programs write them there.
fn normals(
    source: &Definition,
    material: &mut Material,
    images: &mut Images<'_>,
    lost: &mut impl FnMut(&Map, &str, &str, &mut Notes),
    notes: &mut Notes,
) {
    let named = source.maps.get("norm");
    let Some(map) = named.or(source.maps.get("bump")) else { return };
    let lacks = "the surface is shaded smooth";
    match images.index(&Use::Normal(map), notes) {
        Ok(image) if named.is_some() || images.images.get(image).is_some_and(holds_normals) => {
            if named.is_none() {
                let text = "map_Bump holds normals, and is read as such";
                notes.add(NoteKind::Assumed, text, &source.name.cut);
            }
            material.normal_texture = Some(usage(map, image));
            material.normal_scale = map.multiplier;
        }
        Ok(_) => lost(map, "heights are not read", lacks, notes),
        Err(reason) => lost(map, &reason, lacks, notes),
    }
}

/// Whether an image is one of normals rather than of heights: blue on the whole, and neither red nor green.
fn holds_normals(image: &Image) -> bool {
    let [r, g, b, _] = image.mean();
    b > 0.7 && [r, g].iter().all(|mean| (mean - 0.5).abs() < 0.15)
}

/// `d`, or 1 - `Tr`.
fn opacity(source: &Definition, material: &mut Material, notes: &mut Notes) {
    let name = &source.name.cut;
    let [d, tr] = ["d", "tr"].map(|key| source.numbers.get(key).copied());
    let alpha = match (d, tr) {
        (Some(d), _) => d,
        (None, Some(tr)) if tr >= 1.0 => {
            // Some programs write opacity here.
            notes.add(NoteKind::Assumed, "Tr of 1 without d taken as opaque", name);
            1.0
        }
        (None, Some(tr)) => 1.0 - tr,
        (None, None) => 1.0,
    };
    if alpha < 1.0 {
        notes.add(NoteKind::Assumed, "blended alpha is cut off at 0.5", name);
        material.base_color[3] = alpha;
        material.alpha_cutoff = Some(0.5);
    }
}

/// `Pr`, `Pm`, their maps, `Ni`.
fn physically_based(
    source: &Definition,
    material: &mut Material,
    images: &mut Images<'_>,
    lost: &mut impl FnMut(&Map, &str, &str, &mut Notes),
    notes: &mut Notes,
) {
    let name = &source.name.cut;
    let map = |key: &str| source.maps.get(key);
    let factor = |key: &str, default: f32, notes: &mut Notes| match source.numbers.get(key) {
        Some(0.0) if map(key).is_some() => {
            notes.add(NoteKind::Assumed, format!("{key} of 0 beside its map taken as 1"), name);
            1.0
        }
        Some(&number) => number,
        None if map(key).is_some() => 1.0,
        None => default,
    };
    material.roughness = factor("pr", material.roughness, notes);
    material.metallic = factor("pm", 0.0, notes);
    // [KHR_materials_ior: ((ior - 1) / (ior + 1))^2]
    material.dielectric = match source.numbers.get("ni") {
        Some(&ior) if ior > 1.0 => ((ior - 1.0) / (ior + 1.0)).powi(2),
        _ => DIELECTRIC,
    };
    if source.colors.get("ks").is_some_and(|ks| *ks != [0.0; 3]) || map("ks").is_some() {
        notes.add(NoteKind::Ignored, "Ks beside Pr or Pm; the reflectance follows from Ni", name);
    }
    let mut maps = [map("pr"), map("pm")];
    if let [Some(roughness), Some(metallic)] = maps
        && (roughness.scale, roughness.offset, roughness.clamp)
            != (metallic.scale, metallic.offset, metallic.clamp)
    {
        notes.add(NoteKind::Assumed, "map_Pm is read at the places of map_Pr", name);
    }
    // Either may be lost without the other.
    for (slot, lacks) in [(0, "the roughness is Pr everywhere"), (1, "the surface is not metallic")]
    {
        let Some(map) = maps[slot] else { continue };
        let alone =
            if slot == 0 { Use::Surface(Some(map), None) } else { Use::Surface(None, Some(map)) };
        if maps[1 - slot].is_some()
            && let Err(reason) = images.decode(map, false, notes)
        {
            lost(map, &reason, lacks, notes);
            maps[slot] = None;
        } else if maps[1 - slot].is_none()
            && let Err(reason) = images.index(&alone, notes)
        {
            lost(map, &reason, lacks, notes);
            maps[slot] = None;
        }
        if maps[slot].is_none() && slot == 1 {
            material.metallic = 0.0;
        }
    }
    let [roughness, metallic] = maps;
    let Some(shown) = roughness.or(metallic) else { return };
    match images.index(&Use::Surface(roughness, metallic), notes) {
        Ok(image) => material.metallic_roughness_texture = Some(usage(shown, image)),
        Err(reason) => {
            lost(shown, &reason, "roughness and metallic are neutral", notes);
            material.metallic = 0.0;
        }
    }
}
