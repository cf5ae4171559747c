//! Clusters of a map of a test, of any shape, by a density of a test; and the sort that they need.

use serde_json::json;
use sglow_graph::description::Number;
use sglow_graph::{Configuration, Errors};
use sglow_runtime::execute::{Faults, Inputs};
use sglow_runtime::indirect::SurfaceViews;
use sglow_runtime::light::LightView;
use sglow_runtime::package::Package;
use sglow_shaders::{Draw, Light, Lobes, Sharpness, Space, SpecularPower, Variance};

use super::Part;
use crate::common::gpu;

/// What clusters are made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClusterSettings {
    /// Width and height of the map in texels.
    pub(crate) size: [u32; 2],
    pub(crate) count: u32,
    pub(crate) draw: Draw,
    pub(crate) space: Space,
    pub(crate) light: Light,
    /// Columns and rows of the faces' tiles of several lights' map.
    pub(crate) grid: [u32; 2],
    pub(crate) variance: Variance,
    pub(crate) sharpness: Sharpness,
    pub(crate) lobes: Lobes,
    pub(crate) specular_power: SpecularPower,
    pub(crate) diffuse_mean_length: f32,
}

/// What one frame of clusters reads.
pub(crate) struct ClusterInputs<'a> {
    pub(crate) map: SurfaceViews<'a>,
    pub(crate) light: &'a LightView,
    /// All levels of the density: a power-of-two square, 0 where the map is smaller.
    pub(crate) density: &'a wgpu::TextureView,
    /// Where the chains are, if they draw the centres.
    pub(crate) chains: Option<&'a wgpu::Buffer>,
}

/// Clusters.
pub(crate) struct Clusters {
    part: Part,
    settings: ClusterSettings,
}

impl Clusters {
    pub(crate) fn new(package: &Package, settings: &ClusterSettings) -> Result<Self, Errors> {
        let ClusterSettings { size: [width, height], grid: [columns, rows], draw, lobes, .. } =
            *settings;
        let side = width.max(height).next_power_of_two();
        let stride = if lobes == Lobes::Both { 80 } else { 48 };
        let image = |format: &str| {
            json!({ "description": "a map", "external": true,
                    "texture": { "format": format, "size": [width, height] } })
        };
        let frame = json!({
            "let": { "workgroups": "div_ceil(lights, 64)" },
            "resource": {
                "given_position": image("rgba32float"),
                "given_normal": image("rgba32float"),
                "given_base_color": image("rgba32float"),
                "given_density": {
                    "description": "a density with its mips", "external": true,
                    "texture": {
                        "format": "r32float", "size": [side, side], "levels": side.ilog2() + 1,
                    },
                },
                "given_chains": {
                    "description": "where chains are, if they draw the centres", "external": true,
                    "when": "draw == 'metropolis'", "buffer": { "length": "lights", "stride": 8 },
                },
                "lights_of_clusters": {
                    "description": "the virtual lights",
                    "buffer": { "length": "lights", "stride": stride },
                },
            },
            "step": [ {
                "use": "clusters",
                "let": {
                    "map_width": width, "map_height": height, "count": "lights",
                    "workgroups": "workgroups", "face_columns": columns, "face_rows": rows,
                },
                "names": {
                    "position": "given_position", "normal": "given_normal",
                    "base_color": "given_base_color", "map_light": "light",
                    "density": "given_density", "chains": "given_chains",
                    "vsgls": "lights_of_clusters",
                },
            } ],
        });
        let axes = [
            ("draw", draw.to_string()),
            ("space", settings.space.to_string()),
            ("light", settings.light.to_string()),
            ("variance", settings.variance.to_string()),
            ("sharpness", settings.sharpness.to_string()),
            ("lobes", lobes.to_string()),
            ("specular_power", settings.specular_power.to_string()),
        ];
        let count = Number::Whole(settings.count.into());
        let configuration = Configuration {
            axes: axes.map(|(axis, value)| (axis.to_owned(), value)).into(),
            // A map of any size is given; the parameter of this name has to suit any light.
            parameters: [("lights".to_owned(), count), ("map".to_owned(), Number::Whole(4))].into(),
            ..Configuration::default()
        };
        let part = Part::try_new(package, frame, &configuration)?;
        Ok(Self { part, settings: *settings })
    }

    pub(crate) fn run(&mut self, inputs: &ClusterInputs<'_>) -> Result<(), Faults> {
        let ClusterInputs { map, light, density, chains } = inputs;
        let mut given = Inputs::new();
        light.give(&mut given);
        given
            .set("diffuse_mean_length", self.settings.diffuse_mean_length)
            .view("given_position", map.position)
            .view("given_normal", map.normal)
            .view("given_base_color", map.base_color)
            .texture("given_density", density.texture());
        if let Some(chains) = chains {
            given.buffer("given_chains", chains);
        }
        self.part.try_run(&given)
    }

    pub(crate) fn centres(&self) -> Vec<[f32; 4]> {
        self.part.read("centres")
    }

    pub(crate) fn assignment(&self) -> Vec<u32> {
        self.part.read("texels_keys")
    }

    pub(crate) fn order(&self) -> Vec<u32> {
        // As many digits were sorted by as the numbers of clusters have.
        let bits = u32::BITS - (self.settings.count - 1).leading_zeros();
        self.part.read(["texels_values.0", "texels_values.1"][bits.div_ceil(4) as usize % 2])
    }

    pub(crate) fn starts(&self) -> Vec<u32> {
        self.part.read("starts")
    }

    pub(crate) fn vsgls(&self) -> &wgpu::Buffer {
        self.part.buffer("lights_of_clusters")
    }
}

/// Sorts on the device by the lowest `bits` of keys; the keys and the values that came out.
pub(crate) fn sorted(keys: &[u32], bits: u32, package: &Package) -> (Vec<u32>, Vec<u32>) {
    let length = keys.len();
    let words = |flip: bool| json!({ "description": "words", "flip": flip, "buffer": { "length": length, "stride": 4 } });
    let frame = json!({
        "resource": { "given_keys": words(false), "given_values": words(true) },
        "step": [ {
            "use": "sort", "let": { "length": length, "bits": bits },
            "names": { "keys": "given_keys", "values": "given_values" },
        } ],
    });
    let mut part = Part::new(package, frame, &Configuration::default());
    let values: Vec<u32> = (0..length as u32).collect();
    let queue = &gpu().queue;
    queue.write_buffer(part.buffer("given_keys"), 0, bytemuck::cast_slice(keys));
    queue.write_buffer(part.buffer("given_values.0"), 0, bytemuck::cast_slice(&values));
    part.run(&Inputs::new());
    let front = bits.div_ceil(4) as usize % 2;
    let keys = if bits == 0 { "given_keys" } else { ["sorted.0", "sorted.1"][front] };
    (part.read(keys), part.read(["given_values.0", "given_values.1"][front]))
}
