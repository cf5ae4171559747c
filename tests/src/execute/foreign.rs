//! A frame that has nothing to do with light, in the same runtime: counts that are kept, sums in a pair of buffers, no rounds
//! and some, and as many bars as a buffer says.

use sglow_graph::description::Number;
use sglow_graph::frame::{Action, Binding, Size, View};
use sglow_graph::{Configuration, Frame};
use sglow_renderer::readback;
use sglow_runtime::execute::{Executor, Inputs, Lists};
use sglow_runtime::package::Package;
use sglow_shader_gen::library::Library;

use super::submit;
use crate::common::{gpu, packaged, write};

const SIZE: [u32; 2] = [48, 5];
const BINS: usize = 256;

pub(super) struct Foreign {
    package: Package,
    image: wgpu::Texture,
    texels: Vec<u8>,
}

impl Foreign {
    pub(super) fn new() -> Self {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../shader-gen/tests/foreign");
        let library = Library::load(root.as_ref()).unwrap();
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
        Self { package: packaged("foreign", &library, &library.variants()), image, texels }
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
        self.executor_with(again, order, &[])
    }

    /// An executor with resources of a host's own.
    pub(super) fn executor_with(&self, again: u64, order: &str, supplied: &[&str]) -> Executor {
        let supplied = supplied.iter().map(|name| (*name).to_owned()).collect();
        let configuration = Configuration { supplied, ..Self::configuration(again, order) };
        let frame = self.package.description().unwrap();
        let frame = frame.evaluate(&configuration).unwrap();
        let gpu = gpu();
        Executor::new(&gpu.device, &gpu.queue, &self.package, &frame, &Lists::new()).unwrap()
    }

    fn run(&self, executor: &mut Executor, first_column: u32) {
        let inputs = self.inputs(first_column);
        submit(|encoder| executor.encode(encoder, &inputs, None).unwrap());
    }

    pub(super) fn inputs(&self, first_column: u32) -> Inputs<'static> {
        let mut inputs = Inputs::new();
        inputs.set("first_column", first_column).texture("image", &self.image);
        inputs
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

#[test]
fn what_does_not_fit_is_named_all_at_once() {
    let foreign = Foreign::new();
    let description = foreign.package.description().unwrap();
    let whole = description.evaluate(&Foreign::configuration(1, "inclusive")).unwrap();
    let made = |frame: &Frame| {
        let gpu = gpu();
        let made = Executor::new(&gpu.device, &gpu.queue, &foreign.package, frame, &Lists::new());
        made.err().map(|faults| faults.to_string())
    };
    assert_eq!(made(&whole), None);

    let mut frame = whole.clone();
    frame.uniforms[0].remove("first_column");
    let image = frame.resource("image").unwrap();
    for group in &mut frame.groups {
        // The sum gets an image to read, and no place for its results.
        group.remove("tally_sums");
        let view = View { resource: image, level: None };
        group.entry("tally_input".to_owned()).and_modify(|given| *given = Binding::View(view));
    }
    let show = "step.4: a target has to be a texture";
    if let Action::Draw(draw) = &mut frame.steps.last_mut().unwrap().action {
        draw.color[0].resource = frame.resources.iter().position(|one| one.name == "bars").unwrap();
    }
    let step = "step";
    let scan = "variant 'scan-inclusive' binds";
    let expected = [
        format!(
            "{step}.1: variant 'count-red-direct' binds `tally_settings`, member `first_column`: nothing is given for it"
        ),
        format!("{step}.2: {scan} `tally_input`, and what is given for it is of another kind"),
        format!("{step}.2: {scan} `tally_sums`, and nothing is given for it"),
        format!(
            "{step}.3.steps.0: {scan} `tally_input`, and what is given for it is of another kind"
        ),
        format!("{step}.3.steps.0: {scan} `tally_sums`, and nothing is given for it"),
        show.to_owned(),
    ];
    assert_eq!(made(&frame).unwrap().lines().collect::<Vec<_>>(), expected);

    // What is larger than the device allows.
    let mut frame = whole.clone();
    let counted = frame.resource("counted").unwrap();
    frame.resources[counted].bytes = 1 << 60;
    let refused = made(&frame).unwrap();
    let start = "resource `counted`, a buffer of 1152921504606846976 bytes, cannot be made on this device: ";
    assert!(refused.starts_with(start) && refused.contains("maximum buffer size"), "{refused}");

    // More than a device counts.
    let mut frame = whole;
    for step in &mut frame.steps {
        if let Action::Dispatch(dispatch) = &mut step.action {
            dispatch.size = Size::Groups([1 << 32, 1, 1]);
        }
    }
    let many = made(&frame).unwrap();
    let count = "step.1: 4294967296 workgroups; this device allows ";
    assert!(many.lines().any(|line| line.starts_with(count)), "{many}");
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
