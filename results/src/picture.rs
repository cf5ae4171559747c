//! Pictures as numbers: layers in linear units.

use thiserror::Error;

/// Errors of pictures.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LayersError {
    /// There are more or fewer pixels than the size says, or none.
    #[error("a picture of {width} x {height} cannot have {pixels} pixels")]
    Pixels {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
        /// The pixels that were given.
        pixels: usize,
    },
    /// There is no layer.
    #[error("a picture needs a layer")]
    Empty,
    /// A layer comes twice.
    #[error("layer {0} comes twice")]
    Twice(&'static str),
    /// A layer is not as large as the others.
    #[error("layer {0} has a size of its own")]
    Size(&'static str),
    /// The picture lacks a layer.
    #[error("the picture has no layer {layer}\nhelp: it has {}", known.join(", "))]
    Missing {
        /// The layer.
        layer: &'static str,
        /// The layers that it has.
        known: Vec<&'static str>,
    },
    /// No layer is radiance.
    #[error("the picture has no layer of radiance")]
    NoRadiance,
}

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
    pub fn new(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Result<Self, LayersError> {
        if pixels.is_empty() || width.checked_mul(height) != Some(pixels.len()) {
            return Err(LayersError::Pixels { width, height, pixels: pixels.len() });
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
    pub fn new(mut layers: Vec<(Layer, Image)>) -> Result<Self, LayersError> {
        layers.sort_by_key(|(layer, _)| *layer);
        let Some((_, first)) = layers.first() else {
            return Err(LayersError::Empty);
        };
        let size = (first.width, first.height);
        if let Some(pair) = layers.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err(LayersError::Twice(pair[0].0.name()));
        }
        if let Some((layer, _)) =
            layers.iter().find(|(_, image)| (image.width, image.height) != size)
        {
            return Err(LayersError::Size(layer.name()));
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
    pub fn layer(&self, wanted: Layer) -> Result<&Image, LayersError> {
        let found = self.layers.iter().find(|(layer, _)| *layer == wanted);
        found.map(|(_, image)| image).ok_or_else(|| {
            let known = self.layers.iter().map(|(layer, _)| layer.name()).collect();
            LayersError::Missing { layer: wanted.name(), known }
        })
    }

    /// What the camera sees: the sum of all layers of radiance.
    ///
    /// # Errors
    ///
    /// When there is no such layer.
    pub fn radiance(&self) -> Result<Image, LayersError> {
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
        sum.ok_or(LayersError::NoRadiance)
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
