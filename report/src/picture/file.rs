//! The files of pictures: regular ones, whose size is checked before memory is allocated.

use std::io::Cursor;
use std::panic::catch_unwind;
use std::path::Path;

use exr::block::BlockIndex;
use exr::block::chunk::{CompressedBlock, TileCoordinates};
use exr::image::{AnyChannels, FlatSamples, Image, Layers};
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{ReadChannels as _, ReadLayers as _, read};
use image::{ImageFormat, ImageReader, Limits, Rgb32FImage};

use crate::failure::{Context as _, Failure, Result};

/// Bytes of a file at most.
const FILE: u64 = 1 << 30;
/// Pixels of a picture at most: 8192 by 4096.
const PIXELS: u64 = 1 << 25;
/// Pixels of a tile at most, where the picture has fewer: 1024 by 1024.
const TILE: u64 = 1 << 20;
/// Bytes of all channels of a file at most, when they are unpacked.
const UNPACKED: u64 = 1 << 30;

/// Every layer of an OpenEXR file, with its channels as they are stored.
pub(super) fn exr(path: &Path) -> Result<Image<Layers<AnyChannels<FlatSamples>>>> {
    let place = path.display();
    let cannot = |error: exr::error::Error| Failure::new(format!("{place}: cannot read: {error}"));
    let bytes = bytes(path)?;
    let meta = MetaData::read_from_buffered(bytes.as_slice(), false).map_err(cannot)?;
    let mut unpacked = 0_u64;
    for header in &meta.headers {
        let [width, height] = [header.layer_size.width(), header.layer_size.height()];
        let pixels = bounded(path, [width as u64, height as u64])?;
        unpacked =
            unpacked.saturating_add(pixels.saturating_mul(header.channels.bytes_per_pixel as u64));
        // The reader takes memory for whole tiles, however small the picture is.
        if let BlockDescription::Tiles(tiles) = header.blocks {
            let [width, height] = [tiles.tile_size.width(), tiles.tile_size.height()];
            if (width as u64).saturating_mul(height as u64) > pixels.max(TILE) {
                return Err(Failure::new(format!(
                    "{place}: tiles of {width} x {height} pixels; at most {TILE} pixels, or those of the picture"
                )));
            }
        }
    }
    if unpacked > UNPACKED {
        return Err(Failure::new(format!(
            "{place}: would take {unpacked} bytes when it is unpacked; at most {UNPACKED}"
        )));
    }
    // The reader panics at a tile whose own level is not that of its place.
    let largest =
        |_: &MetaData, tile: TileCoordinates, _: BlockIndex| tile.is_largest_resolution_level();
    let chunks = exr::block::read(Cursor::new(&bytes), false).map_err(cannot)?;
    for chunk in chunks.filter_chunks(false, largest).map_err(cannot)? {
        if let CompressedBlock::Tile(tile) = chunk.map_err(cannot)?.compressed_block
            && !tile.coordinates.is_largest_resolution_level()
        {
            return Err(Failure::new(format!(
                "{place}: a tile is of another level than its place"
            )));
        }
    }
    let layers = read().no_deep_data().largest_resolution_level().all_channels().all_layers();
    let layers = layers.all_attributes().non_parallel();
    // The reader panics at some damaged files.
    let image = catch_unwind(|| layers.from_buffered(Cursor::new(bytes)));
    let damaged = || Failure::new(format!("{place}: cannot read: the file is damaged"));
    image.map_err(|_| damaged())?.map_err(cannot)
}

/// The pixels of a Radiance or PNG file as its extension says, in numbers of 32 bits.
pub(super) fn pixels(path: &Path) -> Result<Rgb32FImage> {
    let place = path.display();
    let bytes = bytes(path)?;
    let cannot = || format!("{place}: cannot read");
    let format = ImageFormat::from_path(path).context(cannot())?;
    let reader = || ImageReader::with_format(Cursor::new(&bytes), format);
    let (width, height) = reader().into_dimensions().context(cannot())?;
    let count = bounded(path, [width.into(), height.into()])?;
    let mut limits = Limits::default();
    // Of 16-bit images a decoder keeps 8 bytes a pixel, and some a second copy.
    limits.max_alloc = Some(count.saturating_mul(24).saturating_add(1 << 22));
    let mut reader = reader();
    reader.limits(limits);
    Ok(reader.decode().context(cannot())?.into_rgb32f())
}

/// The number of pixels, if a picture may have so many.
fn bounded(path: &Path, [width, height]: [u64; 2]) -> Result<u64> {
    let pixels = width.saturating_mul(height);
    if pixels <= PIXELS {
        return Ok(pixels);
    }
    let place = path.display();
    Err(Failure::new(format!(
        "{place}: {width} x {height} pixels would take {} bytes; at most {PIXELS} pixels, such as 8192 x 4096",
        pixels.saturating_mul(12)
    )))
}

fn bytes(path: &Path) -> Result<Vec<u8>> {
    sglow_seal::read_regular(path, FILE).context(format!("{}: cannot read", path.display()))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[cfg(unix)]
    #[test]
    fn devices_and_folders_are_no_pictures() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("zero.png");
        std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
        for path in [link.as_path(), folder.path(), Path::new("/dev/null")] {
            for error in [exr(path).err(), pixels(path).err()] {
                let text = error.unwrap().to_string();
                assert!(text.contains("is no regular file"), "{text}");
            }
        }
    }

    #[test]
    fn large_pictures_are_refused_before_memory_is_allocated() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wide.png");
        image::GrayImage::new(1 << 16, 1).save(&path).unwrap();
        assert_eq!(pixels(&path).unwrap().dimensions(), (1 << 16, 1));
        image::GrayImage::new(1 << 16, 513).save(&path).unwrap();
        let text = pixels(&path).unwrap_err().to_string();
        assert!(text.contains("65536 x 513 pixels would take 403439616 bytes"), "{text}");

        // A header whose window is larger than all that follows.
        let path = folder.path().join("small.exr");
        Rgb32FImage::new(2, 3).save(&path).unwrap();
        let mut bytes = fs::read(&path).unwrap();
        let window = [0_i32, 0, 1, 2].map(i32::to_le_bytes).concat();
        let places: Vec<usize> =
            (0..bytes.len() - 16).filter(|&at| bytes[at..at + 16] == window[..]).collect();
        assert!(!places.is_empty());
        for at in places {
            bytes[at + 10] = 3;
            bytes[at + 14] = 3;
        }
        fs::write(&path, bytes).unwrap();
        let text = exr(&path).unwrap_err().to_string();
        assert!(text.contains("would take"), "{text}");
    }

    /// The fuzzer's input took 730 MB and seconds for 495 bytes.
    #[test]
    fn tiles_that_are_larger_than_the_picture_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tiles.exr");
        fs::write(
            &path,
            include_bytes!("../../../fuzz/corpus/images/exr_tiles_larger_than_the_picture.exr"),
        )
        .unwrap();
        let text = exr(&path).unwrap_err().to_string();
        assert!(text.contains("tiles of 12714048 x 64 pixels"), "{text}");
    }
}
