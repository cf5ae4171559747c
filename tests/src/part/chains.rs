//! Markov chains by the density of a test.

use serde_json::json;
use sglow_graph::Configuration;
use sglow_graph::description::Number;
use sglow_runtime::execute::Inputs;
use sglow_runtime::package::Package;
use sglow_shaders::Start;

use super::Part;

/// How chains begin and how they move; names and ranges are those of the frame's parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChainSettings {
    pub(crate) count: u32,
    pub(crate) mutations: u32,
    /// Half the side of the square that a small step leads into.
    pub(crate) radius: f32,
    pub(crate) large_steps: f32,
    pub(crate) seed: u32,
    pub(crate) start: Start,
}

impl ChainSettings {
    /// The defaults.
    pub(crate) fn of(count: u32) -> Self {
        let start = Start::Warped;
        Self { count, mutations: 1, radius: 0.01, large_steps: 0.02, seed: 1, start }
    }
}

/// Chains.
pub(crate) struct Chains(Part);

impl Chains {
    /// Chains over a density that is a square of a power of two.
    pub(crate) fn new(package: &Package, settings: &ChainSettings, side: u32) -> Self {
        let frame = json!({
            "let": { "workgroups": "div_ceil(lights, 64)" },
            "resource": { "given": {
                "description": "a density with its mips", "external": true,
                "texture": { "format": "r32float", "size": [side, side], "levels": side.ilog2() + 1 },
            } },
            "step": [ {
                "use": "chains", "let": { "count": "lights", "workgroups": "workgroups" },
                "names": { "density": "given" },
            } ],
        });
        let whole = |number: u32| Number::Whole(number.into());
        let real = |number: f32| Number::Real(number.into());
        let parameters = [
            ("lights", whole(settings.count)),
            ("mutations", whole(settings.mutations)),
            ("seed", whole(settings.seed)),
            ("small_step", real(settings.radius)),
            ("large_steps", real(settings.large_steps)),
        ];
        let configuration = Configuration {
            axes: [("start".to_owned(), settings.start.to_string())].into(),
            parameters: parameters.map(|(name, number)| (name.to_owned(), number)).into(),
            ..Configuration::default()
        };
        Self(Part::new(package, frame, &configuration))
    }

    /// One frame.
    pub(crate) fn advance(&mut self, density: &wgpu::Texture) {
        let mut inputs = Inputs::new();
        inputs.texture("given", density);
        self.0.run(&inputs);
    }

    pub(crate) fn buffer(&self) -> &wgpu::Buffer {
        self.0.buffer("chains")
    }

    pub(crate) fn read(&self) -> Vec<[f32; 2]> {
        self.0.read("chains")
    }
}
