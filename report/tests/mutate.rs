//! Images with seeded mutations: none may panic, overflow the stack, run long or take much memory.

#![allow(clippy::unwrap_used, reason = "helpers of tests are tests, too")]

use std::alloc::System;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use cap::Cap;
use exr::image::{Encoding, Image, SpecificChannels};
use exr::math::Vec2;
use exr::prelude::{Compression, WritableImage as _};
use image::{DynamicImage, ImageFormat, Rgb, Rgb32FImage, RgbImage};
use sglow_fuzz::{Case, MAXIMUM_MEMORY, Target, corpus};
use sglow_report::picture::density::Density;
use sglow_report::picture::read::{INDIRECT, RADIANCE, Read};
use sglow_scene::Scene;

/// Beyond this the allocator says no, and the process ends.
#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MAXIMUM_MEMORY);

const WORDS: [&[u8]; 12] = [
    b"\xff\xff\xff\xff",
    b"\x00\x00\x00\x00",
    b"\x00\x00\x00\x80",
    b"\xff\xff\xff\x7f",
    b"\x00\x00\x10\x00",
    b"IDAT",
    b"IHDR",
    b"dataWindow\0box2i\0",
    b"channels\0chlist\0",
    b"layer.R\0",
    b"-Y 100000 +X 100000\n",
    b"#?RADIANCE\n",
];

/// Small images of every kind that is read.
fn cases() -> Vec<Case> {
    let mut cases = corpus(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus/images"));
    let mut add = |name: &str, bytes: Vec<u8>| cases.push(Case { name: name.to_owned(), bytes });
    let colour = |x: u32, y: u32| Rgb([20 * x as u8, 40 * y as u8, 128]);
    let light = |x: u32, y: u32| Rgb([x as f32, 0.5 * y as f32, 0.25]);
    let bytes = DynamicImage::from(RgbImage::from_fn(9, 5, colour));
    let words = DynamicImage::from(bytes.to_rgb16());
    let floats = DynamicImage::from(Rgb32FImage::from_fn(9, 5, light));
    for (name, image, format) in [
        ("made.png", &bytes, ImageFormat::Png),
        ("words.png", &words, ImageFormat::Png),
        ("made.jpg", &bytes, ImageFormat::Jpeg),
        ("made.webp", &bytes, ImageFormat::WebP),
        ("made.bmp", &bytes, ImageFormat::Bmp),
        ("made.tga", &bytes, ImageFormat::Tga),
        ("made.hdr", &floats, ImageFormat::Hdr),
    ] {
        let mut written = Cursor::new(Vec::new());
        // Kinds that no crate of this build writes are left out.
        if image.write_to(&mut written, format).is_ok() {
            add(name, written.into_inner());
        }
    }
    for (name, compression) in [
        ("plain.exr", Compression::Uncompressed),
        ("rle.exr", Compression::RLE),
        ("zip.exr", Compression::ZIP16),
        ("piz.exr", Compression::PIZ),
        ("pxr24.exr", Compression::PXR24),
        ("b44.exr", Compression::B44),
    ] {
        let channels =
            SpecificChannels::rgb(|at: Vec2<usize>| (at.x() as f32, at.y() as f32, 0.5_f32));
        let encoding = Encoding { compression, ..Encoding::FAST_LOSSLESS };
        let mut written = Cursor::new(Vec::new());
        let image = Image::from_encoded_channels((9, 5), encoding, channels);
        image.write().to_buffered(&mut written).unwrap();
        add(name, written.into_inner());
    }
    assert!(cases.len() > 12);
    cases
}

/// The check sum of a PNG chunk. [PNG, Annex D]
fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & 0_u32.wrapping_sub(crc & 1))
        })
    };
    !bytes.iter().fold(u32::MAX, step)
}

/// A PNG with the check sums of what is in it, so that a reader goes on to that.
fn mended(mut bytes: Vec<u8>) -> Vec<u8> {
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 8) {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let end = (at + 8).saturating_add(length);
        let Some(chunk) = bytes.get(at + 4..end) else { break };
        let sum = crc(chunk).to_be_bytes();
        let Some(place) = bytes.get_mut(end..end + 4) else { break };
        place.copy_from_slice(&sum);
        at = end + 4;
    }
    bytes
}

#[test]
fn check_sums_are_those_of_the_standard() {
    // [PNG, Section 11.2.5]: the last chunk of every file.
    assert_eq!(crc(b"IEND"), 0xae42_6082);
    let case = cases().into_iter().find(|case| case.name == "png_9000x1.png").unwrap();
    assert_eq!(mended(case.bytes.clone()), case.bytes);
}

#[test]
fn no_mutated_image_panics_runs_long_or_takes_much_memory() {
    let folder = tempfile::tempdir().unwrap();
    let material = "newmtl a\nmap_Kd NAME\nmap_Pr NAME\n";
    let object = "mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";
    fs::write(folder.path().join("a.obj"), object).unwrap();
    let tried = Target::new("image", 60).run(&cases(), &WORDS, |case| {
        let extension = case.name.rsplit('.').next().unwrap();
        let name = format!("input.{extension}");
        let path = folder.path().join(&name);
        // A quarter of them keeps wrong check sums.
        let png = extension == "png" && case.bytes.len() % 4 > 0;
        let bytes = if png { mended(case.bytes.clone()) } else { case.bytes.clone() };
        fs::write(&path, bytes).unwrap();
        let mut taken = false;
        if ["exr", "hdr", "png"].contains(&extension) {
            if let Ok(density) = Density::load(&path.to_string_lossy(), 8, None) {
                assert_eq!(density.texels.len(), density.size[0] * density.size[1]);
                let sum: f32 = density.texels.iter().sum();
                assert!(sum.is_finite() && density.texels.iter().all(|texel| *texel >= 0.0));
                taken = true;
            }
            if let Ok(read) = Read::new(&path) {
                assert!(!read.layers.is_empty());
                let layers = read.names().iter().filter_map(|name| read.layer(name)).count();
                let _ = (layers, read.whole(), read.surfaces());
                let _ = (read.layer(INDIRECT), read.layer(RADIANCE));
                taken = true;
            }
        }
        if extension != "exr" && extension != "hdr" {
            fs::write(folder.path().join("a.mtl"), material.replace("NAME", &name)).unwrap();
            let scene = Scene::load(&folder.path().join("a.obj").to_string_lossy());
            let images = scene.map(|scene| scene.images).unwrap_or_default();
            for image in &images {
                assert_eq!(image.rgba8.len(), 4 * image.width as usize * image.height as usize);
            }
            taken |= !images.is_empty();
        }
        taken
    });
    // Both happen, or the mutations are no test.
    assert!(tried.refused > 10 && tried.taken > 10, "{tried:?}");
}
