//! A frame that has nothing to do with light, in the same runtime: counts that are kept, sums in a pair of buffers, no rounds
//! and some, and as many bars as a buffer says.

use std::collections::BTreeSet;

use sglow_graph::description::Number;
use sglow_graph::{Configuration, Description};
use sglow_runtime::execute::{Executor, Inputs, Lists};
use sglow_runtime::package::Package;
use sglow_runtime::readback;
use sglow_shader_gen::library::Library;

use super::{described, packaged, submit};
use crate::common::{gpu, write};

const SIZE: [u32; 2] = [48, 5];
const BINS: usize = 256;

struct Foreign {
    description: Description,
    package: Package,
    image: wgpu::Texture,
    texels: Vec<u8>,
}

impl Foreign {
    fn new() -> Self {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../shader-gen/tests/foreign");
        let library = Library::load(root.as_ref()).unwrap();
        let all: BTreeSet<_> = library.variants().iter().map(|variant| variant.id()).collect();
        let image = gpu().device.create_texture(&wgpu::TextureDescriptor {
            label: Some("image"),
            size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        // Values in the middles of bins, none in the first one.
        let texel = |index: u32| (index * 37 % 255 + 1) as u8;
        let texels: Vec<_> = (0..SIZE[0] * SIZE[1]).map(texel).collect();
        write(&image, &texels, SIZE, 1, 1);
        Self { description: described(&library), package: packaged(&library, &all), image, texels }
    }

    fn configuration(again: u64, order: &str) -> Configuration {
        let axes = [("channel", "red"), ("counter", "direct"), ("order", order)];
        let [width, height] = SIZE.map(u64::from);
        let parameters = [("width", width), ("height", height), ("again", again)];
        Configuration {
            axes: axes.map(|(axis, value)| (axis.to_owned(), value.to_owned())).into(),
            parameters: parameters
                .map(|(name, number)| (name.to_owned(), Number::Whole(number)))
                .into(),
            ..Configuration::default()
        }
    }

    fn executor(&self, again: u64, order: &str) -> Executor {
        let frame = self.description.evaluate(&Self::configuration(again, order)).unwrap();
        let gpu = gpu();
        Executor::new(&gpu.device, &gpu.queue, &self.package, &frame, &Lists::new()).unwrap()
    }

    fn run(&self, executor: &mut Executor, first_column: u32) {
        let mut inputs = Inputs::new();
        inputs.set("first_column", first_column).texture("image", &self.image);
        submit(|encoder| executor.encode(encoder, &inputs, None).unwrap());
    }

    /// How often each value occurs from a column on.
    fn counts(&self, first_column: u32) -> Vec<u32> {
        let mut counts = vec![0; BINS];
        for (index, &texel) in (0..).zip(&self.texels) {
            if index % SIZE[0] >= first_column {
                let bin = f32::from(texel) / 255.0 * BINS as f32;
                counts[(bin as usize).min(BINS - 1)] += 1;
            }
        }
        counts
    }
}

/// Running sums, each with its own element or without.
fn sums(counts: &[u32], own: bool) -> Vec<u32> {
    let mut sum = 0;
    let next = |count: &u32| {
        sum += count;
        if own { sum } else { sum - count }
    };
    counts.iter().map(next).collect()
}

fn words(executor: &Executor, name: &str) -> Vec<u32> {
    readback::buffer(gpu(), executor.buffer(name).unwrap()).unwrap()
}

#[test]
fn a_foreign_frame_runs_in_the_same_runtime() {
    let foreign = Foreign::new();
    for again in [0, 1, 2] {
        let mut executor = foreign.executor(again, "inclusive");
        let mut counts = vec![0; BINS];
        for first_column in [0, 7, 40] {
            foreign.run(&mut executor, first_column);
            let new = foreign.counts(first_column);
            counts.iter_mut().zip(&new).for_each(|(sum, new)| *sum += new);
            assert_eq!(words(&executor, "counted"), counts, "from {first_column} on");
        }
        let expected = (0..=again).fold(counts.clone(), |counts, _| sums(&counts, true));
        // After an odd number of rounds the second of the pair is the front.
        let front = format!("sums.{}", again % 2);
        assert_eq!(words(&executor, &front), expected, "{again} times again");
        let picture = executor.texture("picture").unwrap();
        let bars = bars(picture);
        let highest = f64::from(expected[BINS - 1]);
        for (bin, (bar, sum)) in bars.iter().zip(&expected).enumerate() {
            let height = f64::from(*sum) / highest * f64::from(picture.height());
            // Corners may be moved to a sixteenth of a texel.
            assert!(
                (f64::from(*bar) - height).abs() <= 0.5 + 1.0 / 16.0,
                "bar {bin}: {bar}, not {height}"
            );
        }
        assert_eq!((bars[0], bars[BINS - 1]), (0, picture.height()));

        // What is kept is cleared when it begins again.
        executor.restart();
        foreign.run(&mut executor, 0);
        assert_eq!(words(&executor, "counted"), foreign.counts(0));
    }
}

/// How many texels of each column are white.
fn bars(picture: &wgpu::Texture) -> Vec<u32> {
    let [width, height] = [picture.width(), picture.height()];
    let staging = gpu().device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(4 * width * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    submit(|encoder| {
        encoder.copy_texture_to_buffer(
            picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &staging,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(4 * width),
                    rows_per_image: Some(height),
                },
            },
            picture.size(),
        );
    });
    let texels: Vec<[u8; 4]> = readback::buffer(gpu(), &staging).unwrap();
    let mut bars = vec![0; width as usize];
    for (index, texel) in texels.iter().enumerate() {
        bars[index % width as usize] += u32::from(texel[0] == 255);
    }
    bars
}
