//! What each stage costs, and how large each method is: Tables 1 to 3 of [Tokuyoshi 2016].

use serde::Serialize;

use super::method::Method;
use crate::time::Time;

/// One stage.
#[derive(Clone, Debug, Serialize)]
pub struct Stage {
    /// What it is called.
    pub name: &'static str,
    /// Of the camera's map, or of the light's.
    pub camera: bool,
    /// How long it takes.
    pub time: Time,
    /// Its dispatches.
    pub dispatches: usize,
}

/// The stages of a method. What all methods share, the density and its mips, is left out.
#[derive(Clone, Debug, Serialize)]
pub struct Stages {
    /// The method.
    pub method: Method,
    /// In the order in which they run.
    pub stages: Vec<Stage>,
}

impl Stages {
    /// The sum of medians, of the camera's map, of the light's or of both.
    #[must_use]
    pub fn total(&self, camera: Option<bool>) -> f64 {
        let counts = |stage: &&Stage| camera.is_none_or(|camera| stage.camera == camera);
        self.stages.iter().filter(counts).map(|stage| stage.time.median).sum()
    }

    /// The median of a stage of the light's map.
    #[must_use]
    pub fn light(&self, name: &str) -> f64 {
        let stage = self.stages.iter().find(|stage| !stage.camera && stage.name == name);
        stage.map_or(0.0, |stage| stage.time.median)
    }
}

/// How large a method is: Table 3 of [Tokuyoshi 2016].
#[derive(Clone, Debug, Serialize)]
pub struct Code {
    /// The method.
    pub method: Method,
    /// The variants that it runs from one map to the lights, the mips' apart.
    pub shaders: Vec<String>,
    /// The variants of the mip chains; the paper leaves them to the graphics API.
    pub mips: Vec<String>,
    /// Lines of the shaders without blank ones and comments, and of the mips'.
    pub lines: [usize; 2],
}
