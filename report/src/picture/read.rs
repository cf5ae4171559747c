//! Pictures of files: OpenEXR with its layers, Radiance HDR, PNG.

use std::path::Path;

use exr::image::{AnyChannels, FlatSamples};

use crate::failure::{Failure, Result};
use crate::picture::{Image, file};

/// A file's picture: linear Rec. 709 light, or whatever its layers hold.
#[derive(Clone, Debug)]
pub struct Read {
    /// Its layers by name; the one without a name is empty text.
    pub layers: Vec<(String, Image)>,
    /// Where a pixel has an alpha above 0, if there is an alpha.
    pub covered: Option<Vec<bool>>,
    /// Whether it was converted from sRGB to linear light.
    pub converted: bool,
}

/// The name of the sum of both layers of indirect light.
pub const INDIRECT: &str = "indirect";
/// The name of the sum of all layers of radiance.
pub const RADIANCE: &str = "radiance";
/// Layers that [`INDIRECT`] is the sum of.
const INDIRECT_PARTS: [&str; 2] = ["indirect_diffuse", "indirect_specular"];
/// Layers that [`RADIANCE`] is the sum of; a file may lack some.
const RADIANCE_PARTS: [&str; 4] = ["direct", "indirect_diffuse", "indirect_specular", "emission"];

impl Read {
    /// Reads a file: .exr, .hdr, .png.
    ///
    /// # Errors
    ///
    /// When it is of another kind, cannot be read or has no layer of colour.
    pub fn new(path: &Path) -> Result<Self> {
        let extension = path.extension().map(|word| word.to_string_lossy().to_lowercase());
        let plain = |srgb: bool| -> Result<Self> {
            let ([width, height], pixels) = decoded(path, srgb)?;
            let layers = vec![(String::new(), Image::new(width, height, pixels)?)];
            Ok(Self { layers, covered: None, converted: srgb })
        };
        match extension.as_deref() {
            Some("exr") => exr_layers(path),
            Some("hdr") => plain(false),
            Some("png") => plain(true),
            _ => Err(Failure::new(format!("{}: unknown kind of picture", path.display()))
                .help("expected .exr, .hdr or .png")),
        }
    }

    /// Names that [`Self::layer`] takes.
    pub fn names(&self) -> Vec<String> {
        let named = self.layers.iter().filter(|layer| !layer.0.is_empty());
        let mut names: Vec<String> = named.map(|layer| layer.0.clone()).collect();
        let sums = [INDIRECT, RADIANCE].into_iter().filter(|sum| self.layer(sum).is_some());
        names.extend(sums.map(str::to_owned));
        names
    }

    /// A layer by its name, or the sum of those of indirect light or of all radiance.
    pub fn layer(&self, name: &str) -> Option<Image> {
        let own = |name: &str| self.layers.iter().find(|layer| layer.0 == name).map(|one| &one.1);
        if let Some(layer) = own(name) {
            return Some(layer.clone());
        }
        let parts: Vec<&Image> = match name {
            INDIRECT => INDIRECT_PARTS.iter().map(|part| own(part)).collect::<Option<_>>()?,
            RADIANCE => RADIANCE_PARTS.iter().filter_map(|part| own(part)).collect(),
            _ => return None,
        };
        let first = parts.first()?;
        // Layers of other sizes have no sum.
        let size = |part: &Image| (part.width(), part.height());
        if parts.iter().any(|part| size(part) != size(first)) {
            return None;
        }
        let sum = |at: usize| {
            core::array::from_fn(|channel| {
                parts.iter().map(|part| part.pixels()[at][channel]).sum::<f32>()
            })
        };
        let pixels = (0..first.pixels().len()).map(sum).collect();
        Image::new(first.width(), first.height(), pixels).ok()
    }

    /// What is compared if nobody says: the layer without a name, the one that there is, or the sum of all radiance.
    pub fn whole(&self) -> Option<Image> {
        match self.layers.as_slice() {
            [(_, only)] => Some(only.clone()),
            _ => self.layer("").or_else(|| self.layer(RADIANCE)),
        }
    }

    /// Whether each pixel shows a surface, and how that is known.
    pub fn surfaces(&self) -> Option<(Vec<bool>, &'static str)> {
        if let Some(normal) = self.layer("normal") {
            let present = normal.pixels().iter().map(|normal| *normal != [0.0; 3]).collect();
            return Some((present, "where layer normal is not 0"));
        }
        self.covered.clone().map(|covered| (covered, "where alpha is above 0"))
    }
}

/// Linear pixels of what the image library reads; a grey image has the same number three times.
pub fn decoded(path: &Path, srgb: bool) -> Result<([usize; 2], Vec<[f32; 3]>)> {
    let image = file::pixels(path)?;
    let size = [image.width() as usize, image.height() as usize];
    let linear = |value: f32| {
        if srgb { sglow_oracle::flip::decoded(f64::from(value)) as f32 } else { value }
    };
    Ok((size, image.pixels().map(|pixel| pixel.0.map(linear)).collect()))
}

/// Every layer of an OpenEXR file that has three channels, or a luminance, or one channel: a part by its name, and
/// within it the channels by what stands before their last point.
fn exr_layers(path: &Path) -> Result<Read> {
    let place = path.display();
    let file = file::exr(path)?;
    let mut read = Read { layers: Vec::new(), covered: None, converted: false };
    for part in &file.layer_data {
        let size = [part.size.width(), part.size.height()];
        let channels: &AnyChannels<FlatSamples> = &part.channel_data;
        let of = |name: &str| -> (String, String) {
            let (layer, channel) = name.rsplit_once('.').unwrap_or(("", name));
            (layer.to_owned(), channel.to_owned())
        };
        let samples = |index: usize| -> Vec<f32> {
            channels.list[index].sample_data.values_as_f32().collect()
        };
        let mut groups: Vec<(String, Vec<(String, usize)>)> = Vec::new();
        for (index, channel) in channels.list.iter().enumerate() {
            let (layer, name) = of(&channel.name.to_string());
            match groups.iter_mut().find(|group| group.0 == layer) {
                Some(group) => group.1.push((name, index)),
                None => groups.push((layer, vec![(name, index)])),
            }
        }
        let own = part.attributes.layer_name.as_ref().map(ToString::to_string);
        for (layer, channels) in groups {
            let find = |wanted: &str| channels.iter().find(|one| one.0 == wanted).map(|one| one.1);
            let three = |names: [&str; 3]| -> Option<[usize; 3]> {
                let [r, g, b] = names.map(find);
                Some([r?, g?, b?])
            };
            let alone = || (channels.len() == 1).then(|| [channels[0].1; 3]);
            let chosen = three(["R", "G", "B"])
                .or_else(|| three(["X", "Y", "Z"]))
                .or_else(|| find("Y").map(|y| [y; 3]))
                .or_else(alone);
            // A lone channel is no picture, unless it is all there is: it is called by its own name.
            let unnamed = layer.is_empty() && own.is_none();
            let lone = unnamed && channels.len() == 1 && channels[0].0 != "Y";
            let layer = if lone { &channels[0].0 } else { &layer };
            let name = match (own.as_deref().unwrap_or_default(), layer.as_str()) {
                ("", layer) => layer.to_owned(),
                (own, "") => own.to_owned(),
                (own, layer) => format!("{own}.{layer}"),
            };
            if let Some(alpha) = find("A").filter(|_| unnamed) {
                let alpha = samples(alpha);
                let covered = || alpha.iter().map(|alpha| *alpha > 0.0).collect();
                read.covered = (alpha.len() == size[0] * size[1]).then(covered);
            }
            let Some(chosen) = chosen else { continue };
            let samples = chosen.map(samples);
            // Channels that were stored with fewer samples than the image has pixels do not fit.
            if samples.iter().any(|samples| samples.len() != size[0] * size[1]) {
                continue;
            }
            let pixels = (0..size[0] * size[1]).map(|at| [0, 1, 2].map(|part| samples[part][at]));
            read.layers.push((name, Image::new(size[0], size[1], pixels.collect())?));
        }
    }
    if read.layers.is_empty() {
        return Err(Failure::new(format!(
            "{place}: no part has the channels R, G and B, or X, Y and Z, or Y, or one alone"
        )));
    }
    Ok(read)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{Layer, Picture, exr};

    fn flat(value: f32) -> Image {
        Image::new(2, 1, vec![[value; 3]; 2]).unwrap()
    }

    #[test]
    fn layers_come_back_by_name_with_their_sums_and_surfaces() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let normal = Image::new(2, 1, vec![[0.0; 3], [0.0, 1.0, 0.0]]).unwrap();
        let layers = vec![
            (Layer::Direct, flat(4.0)),
            (Layer::IndirectDiffuse, flat(1.0)),
            (Layer::IndirectSpecular, flat(2.0)),
            (Layer::Normal, normal),
        ];
        exr::write(&path, &Picture::new(layers).unwrap(), "a test").unwrap();
        let read = Read::new(&path).unwrap();
        assert_eq!(read.layer("indirect").unwrap(), flat(3.0));
        assert_eq!(read.whole().unwrap(), flat(7.0));
        assert_eq!(read.surfaces().unwrap().0, [false, true]);
        assert!(read.layer("albedo").is_none());
        let names = read.names();
        assert!(
            ["direct", "normal", "indirect", "radiance"]
                .iter()
                .all(|one| names.contains(&(*one).to_owned()))
        );
    }

    #[test]
    fn a_png_is_converted_to_linear_light() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        image::RgbImage::from_pixel(2, 1, image::Rgb([188; 3])).save(&path).unwrap();
        let read = Read::new(&path).unwrap();
        assert!(read.converted && read.surfaces().is_none());
        assert!((read.whole().unwrap().pixels()[0][0] - 0.5029).abs() < 1e-3);
        let wrong = Read::new(Path::new("a.jpeg")).unwrap_err().to_string();
        assert!(wrong.contains("unknown kind") && wrong.contains(".hdr"), "{wrong}");
    }
}
