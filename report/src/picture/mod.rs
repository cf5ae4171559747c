//! Pictures: layers in linear units, written losslessly or as a person sees them.

use crate::failure::{Failure, Result};

pub mod compare;
pub mod density;
pub mod exr;
pub mod false_colour;
pub mod kernels;
pub mod png;
pub mod read;
pub mod tone;

/// One quantity of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Layer {
    /// Light that comes straight from the sources.
    Direct,
    /// Indirect light by diffuse reflection at the pixel.
    IndirectDiffuse,
    /// Indirect light by specular reflection at the pixel.
    IndirectSpecular,
    /// Light that surfaces emit towards the camera.
    Emission,
    /// Base colour.
    Albedo,
    /// Unit shading normal in world space.
    Normal,
    /// Position in world space.
    Position,
}

impl Layer {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Direct,
        Self::IndirectDiffuse,
        Self::IndirectSpecular,
        Self::Emission,
        Self::Albedo,
        Self::Normal,
        Self::Position,
    ];

    /// The name in a file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::IndirectDiffuse => "indirect_diffuse",
            Self::IndirectSpecular => "indirect_specular",
            Self::Emission => "emission",
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Position => "position",
        }
    }

    /// The unit of its numbers.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Direct | Self::IndirectDiffuse | Self::IndirectSpecular | Self::Emission => {
                "radiance per channel, W m^-2 sr^-1 if lights are given in watts, cd m^-2 if in lumens"
            }
            Self::Albedo => "1, reflectance from 0 to 1",
            Self::Normal => "1, components of a unit vector",
            Self::Position => "m, or the scene's own unit of length",
        }
    }

    /// Names of its channels in a file.
    pub fn channels(self) -> [&'static str; 3] {
        match self {
            Self::Normal | Self::Position => ["X", "Y", "Z"],
            _ => ["R", "G", "B"],
        }
    }

    /// Whether its numbers are radiance, so that they add up to what the camera sees.
    pub fn is_radiance(self) -> bool {
        matches!(
            self,
            Self::Direct | Self::IndirectDiffuse | Self::IndirectSpecular | Self::Emission
        )
    }
}

/// Three numbers per pixel, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 3]>,
}

impl Image {
    /// An image of `pixels`, row by row from the top.
    ///
    /// # Errors
    ///
    /// When there are not `width * height` pixels, or none.
    pub fn new(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Result<Self> {
        if pixels.is_empty() || width.checked_mul(height) != Some(pixels.len()) {
            return Err(Failure::new(format!(
                "a picture of {width} x {height} cannot have {} pixels",
                pixels.len()
            )));
        }
        Ok(Self { width, height, pixels })
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }
}

/// Layers of one size.
#[derive(Clone, Debug)]
pub struct Picture {
    layers: Vec<(Layer, Image)>,
}

impl Picture {
    /// A picture of `layers`, each at most once.
    ///
    /// # Errors
    ///
    /// When there is none, one comes twice or their sizes differ.
    pub fn new(mut layers: Vec<(Layer, Image)>) -> Result<Self> {
        layers.sort_by_key(|(layer, _)| *layer);
        let Some((_, first)) = layers.first() else {
            return Err(Failure::new("a picture needs a layer"));
        };
        let size = (first.width, first.height);
        if let Some(pair) = layers.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err(Failure::new(format!("layer {} comes twice", pair[0].0.name())));
        }
        if let Some((layer, _)) =
            layers.iter().find(|(_, image)| (image.width, image.height) != size)
        {
            return Err(Failure::new(format!("layer {} has a size of its own", layer.name())));
        }
        Ok(Self { layers })
    }

    /// All layers, in the order of [`Layer`].
    pub fn layers(&self) -> &[(Layer, Image)] {
        &self.layers
    }

    /// One layer.
    ///
    /// # Errors
    ///
    /// When the picture lacks it; names those that it has.
    pub fn layer(&self, wanted: Layer) -> Result<&Image> {
        let found = self.layers.iter().find(|(layer, _)| *layer == wanted);
        found.map(|(_, image)| image).ok_or_else(|| {
            let known: Vec<&str> = self.layers.iter().map(|(layer, _)| layer.name()).collect();
            Failure::new(format!("the picture has no layer {}", wanted.name()))
                .help(format!("it has {}", known.join(", ")))
        })
    }

    /// What the camera sees: the sum of all layers of radiance.
    ///
    /// # Errors
    ///
    /// When there is no such layer.
    pub fn radiance(&self) -> Result<Image> {
        let mut sum: Option<Image> = None;
        for (_, image) in self.layers.iter().filter(|(layer, _)| layer.is_radiance()) {
            match &mut sum {
                None => sum = Some(image.clone()),
                Some(sum) => {
                    for (total, part) in sum.pixels.iter_mut().zip(&image.pixels) {
                        *total = std::array::from_fn(|channel| total[channel] + part[channel]);
                    }
                }
            }
        }
        sum.ok_or_else(|| Failure::new("the picture has no layer of radiance"))
    }
}

/// Luminance of a linear Rec. 709 colour.
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(value: f32) -> Image {
        Image::new(2, 1, vec![[value; 3]; 2]).unwrap()
    }

    #[test]
    fn radiance_adds_up_without_the_other_layers() {
        let picture = Picture::new(vec![
            (Layer::Albedo, flat(100.0)),
            (Layer::IndirectDiffuse, flat(2.0)),
            (Layer::Direct, flat(1.0)),
        ]);
        let picture = picture.unwrap();
        assert_eq!(picture.radiance().unwrap(), flat(3.0));
        let missing = picture.layer(Layer::Normal).unwrap_err().to_string();
        assert!(missing.contains("direct, indirect_diffuse, albedo"), "{missing}");
    }

    #[test]
    fn sizes_that_do_not_fit_are_refused() {
        assert!(Image::new(2, 2, vec![[0.0; 3]; 3]).is_err());
        let tall = Image::new(1, 2, vec![[0.0; 3]; 2]).unwrap();
        let mixed = Picture::new(vec![(Layer::Direct, flat(1.0)), (Layer::Normal, tall)]);
        assert!(mixed.is_err());
        let twice = Picture::new(vec![(Layer::Direct, flat(1.0)), (Layer::Direct, flat(1.0))]);
        assert!(twice.is_err());
    }
}
