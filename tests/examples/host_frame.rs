//! Repeats with the runtime a frame that a host in another language has run (`tests/hosts`), on the same surfaces and with the
//! same inputs.
//!
//! `cargo run --workspace --example host_frame -- PACKAGE RUN OUT [--graph FILE] [--scale INPUT.MEMBER=FACTOR]`
//!
//! RUN: what the host has left (`tests/hosts/README.md`). OUT receives `diffuse`, `specular` and `vsgls` in the same form.
//! `--scale` multiplies one input of the host's, for controls.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use sglow_graph::description::Table;
use sglow_graph::frame::{Kind, Resource};
use sglow_graph::{Configuration, Description};
use sglow_runtime::execute::{Executor, Input, Inputs, Lists};
use sglow_runtime::package::Package;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const PARTS: [&str; 3] = ["lights", "visibility", "shading"];
const OUTPUTS: [&str; 3] = ["diffuse", "specular", "vsgls"];

struct Arguments {
    package: PathBuf,
    run: PathBuf,
    out: PathBuf,
    graph: Option<PathBuf>,
    scale: Option<(String, f64)>,
}

impl Arguments {
    fn read() -> Result<Self> {
        let (mut places, mut graph, mut scale) = (Vec::new(), None, None);
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            match word.as_str() {
                "--graph" => graph = Some(words.next().ok_or("--graph FILE")?.into()),
                "--scale" => {
                    let text = words.next().unwrap_or_default();
                    let (name, factor) = text.split_once('=').ok_or("--scale INPUT=FACTOR")?;
                    scale = Some((name.to_owned(), factor.parse()?));
                }
                _ => places.push(PathBuf::from(word)),
            }
        }
        let [package, run, out] = <[_; 3]>::try_from(places).map_err(|_| "PACKAGE RUN OUT")?;
        Ok(Self { package, run, out, graph, scale })
    }
}

/// Multiplies a number of the inputs, or all numbers of a vector, by its path.
fn scale(inputs: &mut Value, path: &str, factor: f64) -> Result<()> {
    let pointer = format!("/{}", path.replace('.', "/"));
    let found =
        inputs.pointer_mut(&pointer).ok_or_else(|| format!("there is no input `{path}`"))?;
    let times = |value: &Value| value.as_f64().map(|number| Value::from(number * factor));
    *found = match &*found {
        Value::Array(list) => list.iter().filter_map(times).collect(),
        number => times(number).ok_or_else(|| format!("`{path}` is no number"))?,
    };
    Ok(())
}

/// An input from JSON; every host input of these frames is of 32-bit floats.
fn input(value: &Value) -> Input {
    fn numbers(value: &Value, into: &mut Vec<f32>) {
        match value {
            Value::Array(list) => list.iter().for_each(|value| numbers(value, into)),
            value => into.extend(value.as_f64().map(|number| number as f32)),
        }
    }
    let mut found = Vec::new();
    numbers(value, &mut found);
    Input::F32(found)
}

/// What the host supplied, on the device.
enum Supplied {
    Buffer(wgpu::Buffer),
    Texture(wgpu::Texture),
}

struct Device {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Device {
    fn open() -> Result<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter =
            pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
        eprintln!("{}", adapter.get_info().name);
        let required_features = adapter.features() & wgpu::Features::FLOAT32_FILTERABLE;
        let descriptor = wgpu::DeviceDescriptor {
            required_features,
            required_limits: adapter.limits(),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
        Ok(Self { device, queue })
    }

    /// A resource with the contents of a file: words of 32 bits, which 16 bits hold where the format has no more.
    fn upload(&self, resource: &Resource, words: &[u8]) -> Supplied {
        match &resource.kind {
            Kind::Texture { format, size: [width, height], .. } => {
                let (format, data) = match format.as_str() {
                    "rgba16float" => (wgpu::TextureFormat::Rgba16Float, halves(words)),
                    _ => (wgpu::TextureFormat::Rgba32Float, words.to_owned()),
                };
                let size = wgpu::Extent3d {
                    width: *width as u32,
                    height: *height as u32,
                    depth_or_array_layers: 1,
                };
                let texture = self.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(&resource.name),
                    size,
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                    view_formats: &[],
                });
                let bytes_per_row = Some(data.len() as u32 / size.height);
                let layout = wgpu::TexelCopyBufferLayout {
                    bytes_per_row,
                    rows_per_image: Some(size.height),
                    ..wgpu::TexelCopyBufferLayout::default()
                };
                self.queue.write_texture(texture.as_image_copy(), &data, layout, size);
                Supplied::Texture(texture)
            }
            _ => {
                let usage = wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::VERTEX
                    | wgpu::BufferUsages::INDEX
                    | wgpu::BufferUsages::COPY_DST;
                let size = words.len() as u64;
                let descriptor = wgpu::BufferDescriptor {
                    label: Some(&resource.name),
                    size,
                    usage,
                    mapped_at_creation: false,
                };
                let buffer = self.device.create_buffer(&descriptor);
                self.queue.write_buffer(&buffer, 0, words);
                Supplied::Buffer(buffer)
            }
        }
    }

    /// The bytes of a buffer, or four floats for each texel of a texture, row by row.
    fn read(&self, executor: &Executor, name: &str) -> Result<Option<Vec<u8>>> {
        let texel = |texture: &wgpu::Texture| texture.format().block_copy_size(None);
        let size = |texture: &wgpu::Texture| {
            (texture.width() * texel(texture).unwrap_or(0), texture.height())
        };
        let (row, rows) = match (executor.buffer(name), executor.texture(name)) {
            (Some(buffer), _) => (buffer.size() as u32, 1),
            (None, Some(texture)) => size(texture),
            (None, None) => return Ok(None),
        };
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let copy = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(padded) * u64::from(rows),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        if let Some(buffer) = executor.buffer(name) {
            encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
        } else if let Some(texture) = executor.texture(name) {
            let target = wgpu::TexelCopyBufferInfo {
                buffer: &copy,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded),
                    rows_per_image: None,
                },
            };
            encoder.copy_texture_to_buffer(texture.as_image_copy(), target, texture.size());
        }
        self.queue.submit([encoder.finish()]);
        copy.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        let bytes = copy.slice(..).get_mapped_range()?;
        let rows = bytes.chunks(padded as usize).flat_map(|padded| &padded[..row as usize]);
        let bytes: Vec<u8> = rows.copied().collect();
        let halves = executor.texture(name).and_then(texel) == Some(8);
        Ok(Some(if halves { floats(&bytes) } else { bytes }))
    }
}

/// 16 bits for each of the floats, which hold it exactly.
fn halves(words: &[u8]) -> Vec<u8> {
    let floats = bytemuck::pod_collect_to_vec::<u8, f32>(words);
    floats.iter().flat_map(|float| half::f16::from_f32(*float).to_le_bytes()).collect()
}

/// 32 bits for each of the halves.
fn floats(halves: &[u8]) -> Vec<u8> {
    let halves = halves.chunks_exact(2).map(|bits| half::f16::from_le_bytes([bits[0], bits[1]]));
    halves.flat_map(|half| half.to_f32().to_le_bytes()).collect()
}

fn main() -> Result<()> {
    let arguments = Arguments::read()?;
    let read = |path: &Path| fs::read(path).map_err(|error| format!("{}: {error}", path.display()));
    let mut run: Value = serde_json::from_slice(&read(&arguments.run.join("configuration.json"))?)?;
    if let Some((path, factor)) = &arguments.scale {
        scale(&mut run["inputs"], path, *factor)?;
    }
    let lines = |errors: Vec<sglow_runtime::package::PackageError>| {
        errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    let package = Package::load(&arguments.package).map_err(lines)?;
    let description: Description = match &arguments.graph {
        Some(file) => serde_json::from_slice(&read(file)?)?,
        None => package.description().cloned().ok_or("the package describes no frame")?,
    };
    let configuration = Configuration {
        axes: serde_json::from_value(run["axes"].clone())?,
        parameters: serde_json::from_value(run["parameters"].clone())?,
        parts: Some(PARTS.map(str::to_owned).into()),
        ..Configuration::default()
    };
    let frame = description.evaluate(&configuration)?;

    let device = Device::open()?;
    let mut supplied = Vec::new();
    for resource in frame.resources.iter().filter(|resource| resource.external) {
        let file = arguments.run.join(&resource.name);
        if file.exists() {
            supplied.push((resource.name.as_str(), device.upload(resource, &read(&file)?)));
        }
    }
    let values: Table<Value> = serde_json::from_value(run["inputs"].clone())?;
    let mut inputs = Inputs::new();
    for (name, value) in &values {
        match value {
            Value::Object(members) => members.iter().for_each(|(member, value)| {
                inputs.member(name, member, input(value));
            }),
            value => {
                inputs.set(name, input(value));
            }
        }
    }
    for (name, resource) in &supplied {
        match resource {
            Supplied::Buffer(buffer) => inputs.buffer(name, buffer),
            Supplied::Texture(texture) => inputs.texture(name, texture),
        };
    }
    let mut executor =
        Executor::new(&device.device, &device.queue, &package, &frame, &Lists::new())?;
    for _ in 0..run["frames"].as_u64().unwrap_or(1) {
        let mut encoder = device.device.create_command_encoder(&Default::default());
        executor.encode(&mut encoder, &inputs, None)?;
        device.queue.submit([encoder.finish()]);
    }
    fs::create_dir_all(&arguments.out)?;
    for name in OUTPUTS {
        if let Some(bytes) = device.read(&executor, name)? {
            fs::write(arguments.out.join(name), bytes)?;
        }
    }
    Ok(())
}
