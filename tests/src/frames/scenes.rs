//! The scenes that frames are taken of, and how light and eye move from frame to frame.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use glam::{Quat, Vec3};
use sglow_scene::{Light, LightKind, Material, Scene};

/// What is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Place {
    /// The Cornell box: diffuse, constant materials.
    Cornell,
    /// The Cornell box with a polished floor and a block of metal.
    Glossy,
    /// The walls of the Cornell box alone: nothing occludes anything, nothing reflects specularly.
    Walls,
    /// The walls of the glossy box alone: nothing occludes anything.
    GlossyWalls,
    /// A ring of metal.
    Caustic,
    /// Columns in front of the light.
    Columns,
    /// The atrium: textured, with holes, under directional light.
    Atrium,
    /// The atrium with emission of a material of each kind: constant, textured, with holes.
    Lamps,
    /// The glossy Cornell box with normal maps, colours of vertices, second texture coordinates; some surfaces emit.
    Details,
}

impl Place {
    pub(super) const ALL: [Self; 9] = [
        Self::Cornell,
        Self::Glossy,
        Self::Walls,
        Self::GlossyWalls,
        Self::Caustic,
        Self::Columns,
        Self::Atrium,
        Self::Lamps,
        Self::Details,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Cornell => "cornell",
            Self::Glossy => "glossy",
            Self::Walls => "walls",
            Self::GlossyWalls => "glossy-walls",
            Self::Caustic => "caustic",
            Self::Columns => "columns",
            Self::Atrium => "atrium",
            Self::Lamps => "lamps",
            Self::Details => "details",
        }
    }

    /// The scene, made once.
    pub(super) fn scene(self) -> &'static Scene {
        static SCENES: OnceLock<BTreeMap<Place, Scene>> = OnceLock::new();
        &SCENES.get_or_init(|| Self::ALL.map(|place| (place, place.make())).into())[&self]
    }

    fn make(self) -> Scene {
        let builtin = |name: &str| Scene::builtin(name).unwrap();
        match self {
            Self::Cornell => builtin("cornell"),
            Self::Glossy => builtin("cornell-glossy"),
            Self::Walls => walls(builtin("cornell")),
            Self::GlossyWalls => walls(builtin("cornell-glossy")),
            Self::Caustic => builtin("caustic"),
            Self::Columns => builtin("columns"),
            Self::Atrium => builtin("atrium"),
            Self::Lamps => lamps(builtin("atrium")),
            Self::Details => details(),
        }
    }
}

/// A scene without blocks.
fn walls(mut scene: Scene) -> Scene {
    let meshes = scene.meshes.len();
    scene.meshes.retain(|mesh| !mesh.name.contains("block"));
    assert_eq!(scene.meshes.len(), meshes - 2);
    scene
}

/// A scene of which the first material of each kind that is drawn emits.
fn lamps(mut scene: Scene) -> Scene {
    let traits = scene.traits();
    let drawn: Vec<usize> = scene.meshes.iter().map(|mesh| mesh.material).collect();
    for kind in [(false, false), (true, false), (true, true)] {
        let of_kind = |material: &usize| {
            let traits = &traits[*material];
            (traits.textured, traits.cutout) == kind
        };
        let material = drawn.iter().copied().find(of_kind).expect("a material of each kind");
        let emission = [3.0, 1.5, 0.25];
        scene.materials[material] = Material { emission, ..scene.materials[material].clone() };
    }
    scene
}

/// A scene with everything that few surfaces have, of which one with holes and one without emit.
fn details() -> Scene {
    let mut scene = crate::detail::scene();
    for material in [0, 1] {
        scene.materials[material].emission = [3.0, 1.5, 0.25];
    }
    scene
}

/// What the light is of: the scene's own kind, or another one at the same place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Lamp {
    Own,
    Spot,
    Directional,
    Point,
    /// The scene's own, high above it and turned away: nothing is lit.
    Away,
    /// One of each kind.
    Several,
}

impl Lamp {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Spot => "spot",
            Self::Directional => "directional",
            Self::Point => "point",
            Self::Away => "away",
            Self::Several => "several",
        }
    }

    /// The lights of a frame.
    pub(super) fn lights(self, scene: &Scene, frame: u32, nudge: bool) -> Vec<Light> {
        if self != Self::Several {
            return vec![self.light(scene, frame, nudge)];
        }
        // Each is weaker than it is alone.
        let share = |lamp: Self| {
            let light = lamp.light(scene, frame, nudge);
            Light { intensity: light.intensity.map(|channel| 0.4 * channel), ..light }
        };
        [Self::Spot, Self::Directional, Self::Point].map(share).into()
    }

    /// The light of a frame: moved, turned and brighter than the scene's, from frame to frame more so. With a nudge it is
    /// moved and turned by about ten units in the last place, as if everything were rounded otherwise.
    fn light(self, scene: &Scene, frame: u32, nudge: bool) -> Light {
        let own = &scene.lights[0];
        let kind = match self {
            Self::Own | Self::Away | Self::Several => own.kind,
            Self::Spot => LightKind::Spot { inner: 0.4, outer: 1.1 },
            Self::Directional => LightKind::Directional,
            Self::Point => LightKind::Point,
        };
        // Not as the scene has it in the first frame either: a light that looks straight down on a plane has texels on a
        // grid, many of them equally close to two clusters, and the last bit decides whose they are.
        let frame = frame as f32 + 0.37;
        // Down from the middle of the ceiling, for a point light a good way down, so that no face of its map is empty.
        let down = match self {
            Self::Point => 0.4 * scene.bounds().radius(),
            Self::Away => -2.0 * scene.bounds().radius(),
            _ => 0.0,
        };
        let side = if self == Self::Away { -1.0 } else { 1.0 };
        let step = 0.02 * scene.bounds().radius() * frame;
        let position = Vec3::from(own.position) + step * Vec3::new(1.0, -1.0, 0.5) - down * Vec3::Y;
        let nudge = if nudge { 1e-6 } else { 0.0 };
        let turn = Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 0.05 * frame);
        Light {
            name: own.name.clone(),
            kind,
            position: (position * (1.0 + nudge)).into(),
            direction: (side * (turn * Vec3::from(own.direction)) + 0.2 * nudge).normalize().into(),
            intensity: own.intensity.map(|channel| channel * (1.0 + 0.125 * frame)),
            range: own.range,
            map_share: own.map_share,
        }
    }

    /// The scene as the first frame has it.
    pub(super) fn lit(self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        scene.lights = self.lights(&scene, 0, false);
        scene
    }
}

/// The eye of a frame, from where it was in the first.
pub(super) fn eye(first: Vec3, scene: &Scene, frame: u32) -> Vec3 {
    first + 0.03 * scene.bounds().radius() * frame as f32 * Vec3::new(1.0, 0.5, -0.25)
}
