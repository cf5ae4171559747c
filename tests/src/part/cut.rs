//! A cut through a tree over a map of a test, of any shape.

use serde_json::json;
use sglow_graph::description::Number;
use sglow_graph::{Configuration, Errors};
use sglow_runtime::execute::{Faults, Inputs};
use sglow_runtime::indirect::SurfaceViews;
use sglow_runtime::light::LightView;
use sglow_runtime::package::Package;
use sglow_shaders::{Light, Lobes, Precision, Sharpness, SpecularPower, Variance};

use super::Part;

/// What a cut is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CutSettings {
    /// Width and height of the map in texels.
    pub(crate) size: [u32; 2],
    pub(crate) count: u32,
    pub(crate) light: Light,
    /// Columns and rows of the faces' tiles of several lights' map.
    pub(crate) grid: [u32; 2],
    pub(crate) variance: Variance,
    pub(crate) sharpness: Sharpness,
    pub(crate) lobes: Lobes,
    pub(crate) specular_power: SpecularPower,
    pub(crate) precision: Precision,
    pub(crate) diffuse_mean_length: f32,
}

/// A cut.
pub(crate) struct Cut {
    part: Part,
    settings: CutSettings,
}

impl Cut {
    pub(crate) fn new(package: &Package, settings: &CutSettings) -> Result<Self, Errors> {
        let CutSettings { size: [width, height], grid: [columns, rows], lobes, precision, .. } =
            *settings;
        let stride = match (precision, lobes) {
            (Precision::F32, Lobes::Both) => 80,
            (Precision::F32, Lobes::Diffuse) | (Precision::F16, Lobes::Both) => 48,
            (Precision::F16, Lobes::Diffuse) => 32,
        };
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
                "lights_of_cut": {
                    "description": "the virtual lights",
                    "buffer": { "length": "lights", "stride": stride },
                },
            },
            "step": [ {
                "use": "cut",
                "let": {
                    "map_width": width, "map_height": height, "count": "lights",
                    "workgroups": "workgroups", "face_columns": columns, "face_rows": rows,
                },
                "names": {
                    "position": "given_position", "normal": "given_normal",
                    "base_color": "given_base_color", "map_light": "light",
                    "vsgls": "lights_of_cut",
                },
            } ],
        });
        let axes = [
            ("space", "tree".to_owned()),
            ("light", settings.light.to_string()),
            ("variance", settings.variance.to_string()),
            ("sharpness", settings.sharpness.to_string()),
            ("lobes", lobes.to_string()),
            ("specular_power", settings.specular_power.to_string()),
            ("precision", precision.to_string()),
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

    pub(crate) fn run(&mut self, map: SurfaceViews<'_>, light: &LightView) -> Result<(), Faults> {
        let mut given = Inputs::new();
        light.give(&mut given);
        given
            .set("diffuse_mean_length", self.settings.diffuse_mean_length)
            .view("given_position", map.position)
            .view("given_normal", map.normal)
            .view("given_base_color", map.base_color);
        self.part.try_run(&given)
    }

    /// The six numbers of the box around the leaves.
    pub(crate) fn leaves_box(&self) -> Vec<u32> {
        self.part.read("leaves_box")
    }

    pub(crate) fn leaf_count(&self) -> usize {
        self.part.read::<u32>("leaf_count")[0] as usize
    }

    /// The key of each place.
    pub(crate) fn keys(&self) -> Vec<u32> {
        self.part.read("leaves_keys")
    }

    /// The keys, sorted, and the places in their order: after eight digits each is the first one of its pair.
    pub(crate) fn sorted(&self) -> (Vec<u32>, Vec<u32>) {
        (self.part.read("leaves_sorted.0"), self.part.read("leaves_values.0"))
    }

    /// Moments of blocks, by words of 48 or 80 bytes.
    pub(crate) fn blocks(&self) -> Vec<f32> {
        self.part.read("blocks")
    }

    /// First leaf, last leaf, parent and prefix of each node.
    pub(crate) fn nodes(&self) -> Vec<[u32; 4]> {
        self.part.read("nodes")
    }

    pub(crate) fn costs(&self) -> Vec<f32> {
        self.part.read("costs")
    }

    /// What the nodes are sorted by, and the nodes in that order.
    pub(crate) fn ranks(&self) -> (Vec<u32>, Vec<u32>) {
        (self.part.read("nodes_keys"), self.part.read("nodes_values.0"))
    }

    pub(crate) fn vsgls(&self) -> &wgpu::Buffer {
        self.part.buffer("lights_of_cut")
    }
}
