//! Materials, and the images they use.

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
            alpha_cutoff: None,
            double_sided: false,
        }
    }

    /// Brings the factors into their ranges; whether one was outside.
    pub(super) fn clamp(&mut self) -> bool {
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
        moved
    }

    /// Whether it emits light.
    pub fn emits(&self) -> bool {
        self.emission.iter().any(|&channel| channel > 0.0)
    }

    /// The textures it uses.
    pub fn textures(&self) -> impl Iterator<Item = &TextureUse> {
        [&self.base_color_texture, &self.metallic_roughness_texture, &self.emission_texture]
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

/// An image in memory, row 0 at the top.
#[derive(Clone, PartialEq, Eq)]
pub struct Image {
    /// Its name or file name.
    pub name: String,
    /// In texels, at least 1.
    pub width: u32,
    /// In texels, at least 1.
    pub height: u32,
    /// Red, green, blue and alpha, a byte each, row by row without padding.
    pub rgba8: Vec<u8>,
    /// Whether red, green and blue are sRGB encoded; alpha never is.
    pub srgb: bool,
}

impl std::fmt::Debug for Image {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, width, height, srgb, rgba8: _ } = self;
        write!(out, "Image({name:?}, {width}x{height}, srgb: {srgb})")
    }
}

impl Image {
    /// Decodes PNG or JPEG. The error says why it does not decode.
    pub(super) fn decode(name: &str, bytes: &[u8], srgb: bool) -> Result<Self, String> {
        let reader = image::ImageReader::new(std::io::Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|error| error.to_string())?;
        let decoded = match reader.format() {
            Some(image::ImageFormat::Png | image::ImageFormat::Jpeg) => {
                reader.decode().map_err(|error| error.to_string())?.into_rgba8()
            }
            _ => return Err("is neither PNG nor JPEG".to_owned()),
        };
        let (width, height) = decoded.dimensions();
        Ok(Self { name: name.to_owned(), width, height, rgba8: decoded.into_raw(), srgb })
    }
}
