//! Textures of a document: images, samplers, transforms of texture coordinates.

use gltf::material::NormalTexture;
use gltf::texture::{Info, MagFilter, MinFilter, WrappingMode};
use serde_json::Value;

use super::buffer::{Views, read_uri};
use crate::files::Files;
use crate::{Filter, Image, TextureUse, UvTransform, Wrap};

/// Extensions that name an image of a format that is not read, and the format.
const UNREAD: [(&str, &str); 3] =
    [("KHR_texture_basisu", "KTX2"), ("EXT_texture_avif", "AVIF"), ("MSFT_texture_dds", "DDS")];

/// The images that materials use, decoded once for each way they are read.
pub(super) struct Textures<'a> {
    files: Files<'a>,
    document: &'a gltf::Document,
    views: &'a Views<'a>,
    pub(super) images: Vec<Image>,
    /// Which image of the file, read as sRGB or not, was decoded to which of `images`, or why it was not.
    decoded: Vec<((usize, bool), Result<usize, String>)>,
}

impl<'a> Textures<'a> {
    pub(super) fn new(
        files: Files<'a>,
        document: &'a gltf::Document,
        views: &'a Views<'a>,
    ) -> Self {
        Self { files, document, views, images: Vec::new(), decoded: Vec::new() }
    }

    /// How a material reads a texture. The error says what is wrong with its image.
    pub(super) fn read(&mut self, place: &Place<'_>, srgb: bool) -> Result<TextureUse, String> {
        let texture = &place.texture;
        let webp = texture.extension_value("EXT_texture_webp").and_then(|webp| webp.get("source"));
        let webp = webp.and_then(Value::as_u64).and_then(|source| usize::try_from(source).ok());
        let plain = texture.source().map(|source| source.index());
        let image = match (plain, webp) {
            // What every reader understands goes first; the other is the same picture, smaller.
            (Some(plain), webp) => match (self.image(plain, srgb), webp) {
                (Err(_), Some(webp)) => self.image(webp, srgb)?,
                (plain, _) => plain?,
            },
            (None, Some(webp)) => self.image(webp, srgb)?,
            (None, None) => {
                let unread =
                    UNREAD.iter().find(|(name, _)| texture.extension_value(name).is_some());
                let index = texture.index();
                return Err(match unread {
                    Some((_, format)) => format!("texture {index} is {format}, which is not read"),
                    None => format!("texture {index} has no image"),
                });
            }
        };
        Ok(TextureUse { image, ..place.usage() })
    }

    /// The index of an image in `images`.
    fn image(&mut self, index: usize, srgb: bool) -> Result<usize, String> {
        let key = (index, srgb);
        if let Some((_, known)) = self.decoded.iter().find(|(known, _)| *known == key) {
            return known.clone();
        }
        let decoded = self.decode(index, srgb).map(|image| self.push(image));
        self.decoded.push((key, decoded.clone()));
        decoded
    }

    fn decode(&self, index: usize, srgb: bool) -> Result<Image, String> {
        let image = self.document.as_json().images.get(index);
        let image = image.ok_or_else(|| format!("there is no image {index}"))?;
        let file_name = image.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
        let named = file_name.or(image.name.as_deref());
        let name = named.map_or_else(|| index.to_string(), str::to_owned);
        let limits = &self.files.options.limits;
        let decode = |bytes: &[u8]| Image::decode(&name, bytes, srgb, limits, self.texels_left());
        let decoded = match (&image.buffer_view, &image.uri) {
            (Some(view), _) => self.views.get(view.value()).and_then(decode),
            (None, Some(uri)) => match read_uri(&self.files, uri) {
                Ok((_, bytes)) => decode(&bytes),
                Err(fault) => Err(fault.to_string()),
            },
            (None, None) => Err("has neither a buffer view nor a URI".to_owned()),
        };
        decoded.map_err(|reason| format!("image `{name}`: {reason}"))
    }

    /// Adds an image.
    pub(super) fn push(&mut self, image: Image) -> usize {
        self.images.push(image);
        self.images.len() - 1
    }

    /// How many texels the images may still take.
    pub(super) fn texels_left(&self) -> usize {
        let taken: usize = self.images.iter().map(Image::texels).sum();
        let limits = &self.files.options.limits;
        limits.texels.saturating_sub(taken).min(limits.image_texels)
    }
}

/// A texture, and where a material reads it.
pub(super) struct Place<'a> {
    texture: gltf::Texture<'a>,
    transform: UvTransform,
    /// Which of the mesh's sets of texture coordinates it is read at.
    pub(super) set: u32,
}

impl<'a> Place<'a> {
    pub(super) fn of(info: &Info<'a>) -> Self {
        let moved = info.texture_transform();
        let set = moved.as_ref().and_then(|moved| moved.tex_coord()).unwrap_or(info.tex_coord());
        let transform = moved.map_or(UvTransform::default(), |moved| UvTransform {
            offset: moved.offset(),
            rotation: moved.rotation(),
            scale: moved.scale(),
        });
        Self { texture: info.texture(), transform, set }
    }

    /// That of a normal map, whose extensions the `gltf` crate leaves as they are. [KHR_texture_transform]
    pub(super) fn of_normals(normal: &NormalTexture<'a>) -> Self {
        let moved = normal.extension_value("KHR_texture_transform");
        let number = |value: Option<&Value>, default: f32| {
            value.and_then(Value::as_f64).map_or(default, |number| number as f32)
        };
        let pair = |key: &str, default: f32| {
            let list = moved.and_then(|moved| moved.get(key));
            [0, 1].map(|index| number(list.and_then(|list| list.get(index)), default))
        };
        let transform = UvTransform {
            offset: pair("offset", 0.0),
            rotation: number(moved.and_then(|moved| moved.get("rotation")), 0.0),
            scale: pair("scale", 1.0),
        };
        let set = moved.and_then(|moved| moved.get("texCoord")).and_then(Value::as_u64);
        let set = set.and_then(|set| u32::try_from(set).ok()).unwrap_or(normal.tex_coord());
        Self { texture: normal.texture(), transform, set }
    }

    /// How it is read, of whatever image.
    fn usage(&self) -> TextureUse {
        how(&self.texture, self.transform)
    }
}

fn how(texture: &gltf::Texture<'_>, transform: UvTransform) -> TextureUse {
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
    TextureUse {
        image: 0,
        wrap: [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())],
        magnify: if sampler.mag_filter() == Some(MagFilter::Nearest) { Nearest } else { Linear },
        minify,
        mip,
        transform,
        second: false,
    }
}
