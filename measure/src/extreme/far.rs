//! Scenes far from the world's origin, as files and engines have them: vertices are rounded there, then an origin near the
//! scene is subtracted in 64 bits.

use sglow_renderer::device::Gpu;
use sglow_results::stability::report::ExtremeReport;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::{LightKind, Scene};

use super::outcome::{ExtremeError, render, verdict};
use crate::bound;

/// A light on a scene at a distance from the origin.
pub(super) struct Far {
    pub(super) name: &'static str,
    light: Kind,
    /// Along x and against z, in the scene's units; the scene is 5.5 wide.
    distance: f32,
}

#[derive(Clone, Copy)]
enum Kind {
    Spot,
    Directional,
    Point,
}

const fn far(name: &'static str, light: Kind, distance: f32) -> Far {
    Far { name, light, distance }
}

pub(super) const ALL: [Far; 12] = [
    far("spot light, 1e3 away", Kind::Spot, 1e3),
    far("spot light, 1e4 away", Kind::Spot, 1e4),
    far("spot light, 1e5 away", Kind::Spot, 1e5),
    far("spot light, 1e6 away", Kind::Spot, 1e6),
    far("directional light, 1e3 away", Kind::Directional, 1e3),
    far("directional light, 1e4 away", Kind::Directional, 1e4),
    far("directional light, 1e5 away", Kind::Directional, 1e5),
    far("directional light, 1e6 away", Kind::Directional, 1e6),
    far("point light, 1e3 away", Kind::Point, 1e3),
    far("point light, 1e4 away", Kind::Point, 1e4),
    far("point light, 1e5 away", Kind::Point, 1e5),
    far("point light, 1e6 away", Kind::Point, 1e6),
];

/// Values of axes by their names.
type Set = &'static [(&'static str, &'static str)];

/// The configurations whose passes have positions of their own, and whether the bound applies: clusters in world space assign
/// a texel at equal distances of two centres to either, by rounding.
const CONFIGURATIONS: [(&str, Set, bool); 7] = [
    ("default", &[], true),
    ("visibility=shadow_map", &[("visibility", "shadow_map")], true),
    ("visibility=imperfect", &[("visibility", "imperfect")], true),
    ("precision=f16", &[("precision", "f16")], true),
    ("density=bidirectional", &[("density", "bidirectional")], true),
    ("space=tree", &[("space", "tree"), ("emitter", "disc"), ("visibility", "shadow_map")], true),
    ("space=world", &[("space", "world"), ("emitter", "disc")], false),
];

impl Far {
    /// The scene at the origin.
    fn scene(&self) -> Result<Scene, ExtremeError> {
        let mut scene = Scene::load("cornell-glossy")?;
        for light in &mut scene.lights {
            match self.light {
                Kind::Spot => {}
                Kind::Directional => {
                    // Through the open side.
                    light.kind = LightKind::Directional;
                    light.direction = [0.0, -0.6, 0.8];
                    light.intensity = [5.0; 3];
                }
                Kind::Point => {
                    light.kind = LightKind::Point;
                    light.position[1] -= 1.0;
                }
            }
        }
        Ok(scene)
    }

    /// The scene far away, with rounded positions, and with these positions moved back, which is exact in single precision.
    fn far_and_near(&self) -> Result<[Scene; 2], ExtremeError> {
        let mut far = self.scene()?;
        move_by(&mut far, self.distance);
        let mut near = far.clone();
        move_by(&mut near, -self.distance);
        Ok([far, near])
    }

    /// Renders it in every configuration.
    pub(super) fn attempt(
        &self,
        gpu: &Gpu,
        package: &Package,
    ) -> Result<ExtremeReport, ExtremeError> {
        let [mut far, near] = self.far_and_near()?;
        far.rebase(None);
        let bound = bound::extreme("far with an origin");
        let mut tried = Vec::new();
        for (name, set, bounded) in CONFIGURATIONS {
            let settings = settings(set)?;
            let expected = render(gpu, package, &near, &settings)?.mean;
            let outcome = render(gpu, package, &far, &settings)?;
            let bound = bound.at_most.filter(|_| bounded);
            tried.push(verdict(name.to_owned(), &outcome, Some(expected), bound));
        }
        Ok(ExtremeReport {
            name: self.name,
            description: "the scene moved along x and z, rounded there, and taken relative to an origin near it; it is 5.5 wide",
            bound: bound.at_most,
            reason: bound.reason,
            variants: tried,
        })
    }
}

/// The relative deviation of the mean of a far scene without a rebased origin, with shadow maps of virtual lights, from that
/// of the scene at the origin.
///
/// # Errors
///
/// When it does not render.
pub fn without_origin(gpu: &Gpu, package: &Package) -> Result<f64, ExtremeError> {
    let [far, near] = far("", Kind::Spot, 1e6).far_and_near()?;
    let settings = settings(&[("visibility", "shadow_map")])?;
    let expected = render(gpu, package, &near, &settings)?.mean;
    Ok(render(gpu, package, &far, &settings)?.mean / expected - 1.0)
}

fn settings(set: Set) -> Result<Settings, ExtremeError> {
    let mut settings = Settings { size: [48, 27], map: 64, lights: 64, ..Settings::default() };
    for (axis, value) in set {
        settings.set(axis, value)?;
    }
    Ok(settings)
}

fn move_by(scene: &mut Scene, offset: f32) {
    let moved = |[x, y, z]: [f32; 3]| [x + offset, y, z - offset];
    let positions = scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions);
    let positions = positions.chain(scene.lights.iter_mut().map(|light| &mut light.position));
    for position in positions.chain([&mut scene.camera.position]) {
        *position = moved(*position);
    }
}
