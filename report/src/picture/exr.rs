//! Lossless files: OpenEXR with one part per layer, 32-bit floats in linear units.

use std::io::BufWriter;
use std::path::Path;

use exr::image::{
    AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image as File, Layer as Part, Layers,
};
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{Compression, IntegerBounds, LineOrder, SmallVec, WritableImage as _};

use crate::failure::{Failure, Result};
use crate::picture::{Layer, Picture};
use crate::write;

/// Writes all layers of `picture`; `comment` says what was rendered, and how.
///
/// Each layer is a part of its own that is named after it, with its unit as attribute `unit`.
///
/// # Errors
///
/// When the file cannot be written.
pub fn write(path: &Path, picture: &Picture, comment: &str) -> Result {
    let parts: Layers<AnyChannels<FlatSamples>> =
        picture.layers().iter().map(|(layer, image)| part(*layer, image, comment)).collect();
    let (_, first) = &picture.layers()[0];
    let bounds = IntegerBounds::from_dimensions((first.width(), first.height()));
    let file = File { attributes: ImageAttributes::new(bounds), layer_data: parts };
    write::file(path, |sink| {
        file.write()
            .non_parallel()
            .to_buffered(BufWriter::new(sink))
            .map_err(|error| Failure::new(error.to_string()))
    })
}

fn part(layer: Layer, image: &super::Image, comment: &str) -> Part<AnyChannels<FlatSamples>> {
    let names = layer.channels();
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = (0..3)
        .map(|channel| {
            let samples = image.pixels().iter().map(|pixel| pixel[channel]).collect();
            AnyChannel::new(Text::new_or_panic(names[channel]), FlatSamples::F32(samples))
        })
        .collect();
    let text = |text: &str| AttributeValue::Text(Text::new_or_none(text).unwrap_or_default());
    let mut attributes = LayerAttributes::named(layer.name());
    attributes.software_name = Text::new_or_none(concat!("sglow ", env!("CARGO_PKG_VERSION")));
    attributes.comments = Text::new_or_none(comment);
    attributes.other.extend([
        (Text::from("unit"), text(layer.unit())),
        (Text::from("colour"), text("linear, primaries of Rec. 709")),
    ]);
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    Part::new((image.width(), image.height()), attributes, encoding, AnyChannels::sort(channels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Image;

    #[test]
    fn every_layer_comes_back_bit_by_bit_with_its_unit() {
        let image = |scale: f32| {
            let pixels = (0..12).map(|i| [scale * i as f32, 1e-30 * scale, -scale]);
            Image::new(4, 3, pixels.collect()).unwrap()
        };
        let layers = vec![
            (Layer::Direct, image(1.5)),
            (Layer::IndirectSpecular, image(7e30)),
            (Layer::Position, image(-3.25)),
        ];
        let picture = Picture::new(layers.clone()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        write(&path, &picture, "a test").unwrap();

        let file = exr::prelude::read_all_flat_layers_from_file(&path).unwrap();
        assert_eq!(file.layer_data.len(), layers.len());
        for ((layer, image), part) in layers.iter().zip(&file.layer_data) {
            assert_eq!(part.attributes.layer_name, Some(Text::from(layer.name())));
            assert_eq!(part.attributes.comments, Some(Text::from("a test")));
            let unit = &part.attributes.other[&Text::from("unit")];
            assert_eq!(*unit, AttributeValue::Text(Text::from(layer.unit())));
            for (index, name) in layer.channels().into_iter().enumerate() {
                let found = part.channel_data.list.iter().find(|c| c.name.eq(name));
                let samples: Vec<f32> = found.unwrap().sample_data.values_as_f32().collect();
                let expected: Vec<f32> = image.pixels().iter().map(|p| p[index]).collect();
                assert_eq!(samples, expected, "{} {name}", layer.name());
            }
        }
    }
}
