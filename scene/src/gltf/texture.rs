//! Textures of a document: images, samplers, transforms of texture coordinates.

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
    pub(super) fn read(&mut self, info: &Info<'_>, srgb: bool) -> Result<TextureUse, String> {
        let texture = info.texture();
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
        Ok(TextureUse { image, ..how(info) })
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

/// How a texture is read, of whatever image.
fn how(info: &Info<'_>) -> TextureUse {
    let sampler = info.texture().sampler();
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
        transform: info.texture_transform().map_or(UvTransform::default(), |transform| {
            UvTransform {
                offset: transform.offset(),
                rotation: transform.rotation(),
                scale: transform.scale(),
            }
        }),
    }
}

/// Which set of texture coordinates a texture is read at.
pub(super) fn set(info: &Info<'_>) -> u32 {
    let moved = info.texture_transform().and_then(|transform| transform.tex_coord());
    moved.unwrap_or(info.tex_coord())
}
