//! Materials, and how they use images.

use super::note::{NoteKind, Notes};

/// The largest and the smallest positive half float: what is emitted is drawn into textures of them. [IEEE 754 binary16]
const LARGEST_HALF: f32 = 65504.0;
const SMALLEST_HALF: f32 = 5.960_464_5e-8;
/// The smallest normal half: below it steps are as wide as there. [IEEE 754 binary16]
const SMALLEST_NORMAL_HALF: f32 = 6.103_515_6e-5;

/// A surface of the metallic-roughness model.
///
/// `R_d = base_color (1 - metallic)`, `R_s = mix(dielectric, base_color, metallic)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Its name, or `material` and its number.
    pub name: String,
    /// Linear Rec. 709 reflectance and alpha, each 0 to 1; times the texture.
    pub base_color: [f32; 4],
    /// Perceptual roughness, 0 to 1, the square root of the GGX alpha; times the texture's green.
    pub roughness: f32,
    /// 0 to 1; times the texture's blue.
    pub metallic: f32,
    /// Specular reflectance of the dielectric part at normal incidence, 0 to 1: 0.04 for glTF
    /// unless it says otherwise, 0 for OBJ materials without `Ks`.
    pub dielectric: f32,
    /// Emitted radiance, linear Rec. 709; times the texture.
    pub emission: [f32; 3],
    /// sRGB colour and linear alpha.
    pub base_color_texture: Option<TextureUse>,
    /// Linear: roughness in green, metallic in blue.
    pub metallic_roughness_texture: Option<TextureUse>,
    /// sRGB.
    pub emission_texture: Option<TextureUse>,
    /// Linear: the normal in the space of the tangent, each coordinate from -1 to 1, green up.
    pub normal_texture: Option<TextureUse>,
    /// What x and y of the normal map are multiplied with.
    pub normal_scale: f32,
    /// Where alpha is below this, there is no surface.
    pub alpha_cutoff: Option<f32>,
    /// Whether the back is seen and lit as well, with the normal turned over.
    pub double_sided: bool,
}

impl Material {
    /// A diffuse, one-sided material.
    pub fn diffuse(name: &str, color: [f32; 3]) -> Self {
        let [r, g, b] = color;
        Self {
            name: name.to_owned(),
            base_color: [r, g, b, 1.0],
            roughness: 1.0,
            metallic: 0.0,
            dielectric: 0.0,
            emission: [0.0; 3],
            base_color_texture: None,
            metallic_roughness_texture: None,
            emission_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            alpha_cutoff: None,
            double_sided: false,
        }
    }

    /// Brings the factors into their ranges, emission into that of the halves that pictures are made of.
    pub(super) fn mend(&mut self, notes: &mut Notes) {
        let mut moved = false;
        let mut clamp = |factor: &mut f32, most: f32| {
            // NaN becomes 0.
            let inside = factor.max(0.0).min(most);
            moved |= inside != *factor;
            *factor = inside;
        };
        self.base_color.iter_mut().for_each(|channel| clamp(channel, 1.0));
        self.emission.iter_mut().for_each(|channel| clamp(channel, f32::MAX));
        clamp(&mut self.roughness, 1.0);
        clamp(&mut self.metallic, 1.0);
        clamp(&mut self.dielectric, 1.0);
        if !self.normal_scale.is_finite() {
            (self.normal_scale, moved) = (1.0, true);
        }
        if moved {
            notes.add(NoteKind::Assumed, "factors clamped to their range", &self.name);
        }
        let brightest = self.emission.iter().copied().fold(0.0, f32::max);
        if brightest > LARGEST_HALF {
            // All channels alike, so that the hue stays.
            let scale = f64::from(LARGEST_HALF) / f64::from(brightest);
            self.emission = self.emission.map(|channel| (f64::from(channel) * scale) as f32);
            let text = "emission above 65504, the largest half, scaled to it";
            notes.add(NoteKind::Assumed, text, format!("{}: {brightest}", self.name));
        } else if brightest > 0.0 && brightest < SMALLEST_HALF {
            let text = "emission below 6e-8, the smallest half: it is not seen";
            notes.add(NoteKind::Ignored, text, format!("{}: {brightest}", self.name));
        } else if brightest > 0.0 && brightest < SMALLEST_NORMAL_HALF {
            let text = "emission below 6.1e-5, where halves are coarse: it may be off by half a step of 6e-8";
            notes.add(NoteKind::Assumed, text, format!("{}: {brightest}", self.name));
        }
    }

    /// Notes textures that are read with another one's sampler: a material has one.
    pub(super) fn note_samplers(&self, notes: &mut Notes) {
        let how =
            |texture: &TextureUse| (texture.wrap, texture.magnify, texture.minify, texture.mip);
        let mut textures = self.textures();
        let Some(first) = textures.next() else { return };
        if textures.any(|texture| how(texture) != how(first)) {
            let text = "textures of a material are filtered and repeated as its first one is";
            notes.add(NoteKind::Assumed, text, &self.name);
        }
    }

    /// Whether it emits light.
    pub fn emits(&self) -> bool {
        self.emission.iter().any(|&channel| channel > 0.0)
    }

    /// The textures it uses.
    pub fn textures(&self) -> impl Iterator<Item = &TextureUse> {
        [
            &self.base_color_texture,
            &self.metallic_roughness_texture,
            &self.emission_texture,
            &self.normal_texture,
        ]
        .into_iter()
        .flatten()
    }
}

/// How a material reads an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// Index into [`super::Scene::images`].
    pub image: usize,
    /// Outside of the image, across and down.
    pub wrap: [Wrap; 2],
    /// Between texels, where the image is magnified.
    pub magnify: Filter,
    /// Between texels, where it is minified.
    pub minify: Filter,
    /// Between mip levels; `None` reads the finest level only.
    pub mip: Option<Filter>,
    /// From the mesh's texture coordinates to those the image is read at.
    pub transform: UvTransform,
    /// Whether these are the mesh's second ones.
    pub second: bool,
}

impl TextureUse {
    /// Repeating, with linear filtering throughout.
    pub fn repeating(image: usize) -> Self {
        Self {
            image,
            wrap: [Wrap::Repeat; 2],
            magnify: Filter::Linear,
            minify: Filter::Linear,
            mip: Some(Filter::Linear),
            transform: UvTransform::default(),
            second: false,
        }
    }
}

/// What lies outside of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    Repeat,
    /// The image, mirrored every other time.
    Mirror,
    /// The edge's texels.
    Clamp,
}

/// What lies between two texels or mip levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The nearest one.
    Nearest,
    /// The linear blend.
    Linear,
}

/// A transform of texture coordinates: scaled, then rotated, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// Added last, in image sizes.
    pub offset: [f32; 2],
    /// Radians, counter-clockwise with v pointing down.
    pub rotation: f32,
    /// Multiplied first.
    pub scale: [f32; 2],
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2] }
    }
}

impl UvTransform {
    /// The rows of the transform, each to be multiplied with `(u, v, 1)`.
    pub fn rows(&self) -> [[f32; 3]; 2] {
        // [KHR_texture_transform, overview: translation * rotation * scale]
        let (sin, cos) = self.rotation.sin_cos();
        let [sx, sy] = self.scale;
        let [ox, oy] = self.offset;
        [[cos * sx, sin * sy, ox], [-sin * sx, cos * sy, oy]]
    }
}
