//! A scene about another origin.

use glam::DVec3;

use super::Scene;
use super::origin;

impl Scene {
    /// Takes positions relative to another origin: `given`, such as an engine's own, else the one that a file with these
    /// positions would get. For scenes that were not loaded, for those of files are near their origin already.
    pub fn rebase(&mut self, given: Option<[f64; 3]>) {
        let own = DVec3::from(self.origin);
        let world = |position: [f32; 3]| DVec3::from(position.map(f64::from)) + own;
        let corners = self.meshes.iter().flat_map(|mesh| mesh.triangles().flatten()).map(world);
        let near = || origin::box_around(corners).map(origin::of);
        let Some(origin) = given.map(DVec3::from).or_else(near) else { return };
        let positions = self.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions);
        let positions = positions.chain(self.lights.iter_mut().map(|light| &mut light.position));
        for position in positions.chain([&mut self.camera.position]) {
            *position = origin::relative(world(*position), origin);
        }
        self.origin = origin.into();
    }
}
