//! A scene's lights as passes see them.

use glam::{DVec3, Vec3};
use sglow_runtime::light::{LightView, LightsError, Surroundings, grid};
use sglow_scene::{Bounds, Light, LightKind};

/// The view of a light on a scene with these bounds, for a map of `size` texels squared.
#[must_use]
pub fn view(light: &Light, bounds: &Bounds, size: u32) -> LightView {
    let double = |[x, y, z]: [f32; 3]| DVec3::new(x.into(), y.into(), z.into());
    let around = Surroundings {
        origin: DVec3::ZERO,
        center: double(bounds.center()),
        radius: bounds.radius(),
        map: size,
    };
    let (position, direction) = (double(light.position), Vec3::from(light.direction));
    match light.kind {
        LightKind::Spot { inner, outer } => {
            LightView::spot(&around, position, direction, [inner, outer], light.intensity)
        }
        LightKind::Directional => LightView::directional(&around, direction, light.intensity),
        LightKind::Point => LightView::point(&around, position, light.intensity),
    }
}

/// The view of several lights in one map.
///
/// # Errors
///
/// Lights that no map can have together.
pub fn view_of_all(lights: &[Light], bounds: &Bounds, size: u32) -> Result<LightView, LightsError> {
    let tile = size / grid(faces(lights))[0];
    let sized = |light: &Light| {
        // What remains of a tile lies on both sides.
        let margin = (0.5 * (1.0 - light.map_share) * tile as f32).round() as u32;
        let texels = tile.saturating_sub(2 * margin).max(2 - tile % 2);
        let texels = (light.map_share < 1.0).then_some(texels);
        let mut view = view(light, bounds, size);
        view.texels = texels;
        view
    };
    LightView::several(&lights.iter().map(sized).collect::<Vec<_>>())
}

/// The faces of the map of lights: six of a point light, one of another.
#[must_use]
pub fn faces(lights: &[Light]) -> u32 {
    lights.iter().map(|light| if light.kind == LightKind::Point { 6 } else { 1 }).sum()
}

/// The kind of lights as an axis has it: that of the light if there is one, else several.
#[must_use]
pub fn kind_of_all(lights: &[Light]) -> sglow_shaders::Light {
    match lights {
        [light] => kind(light),
        _ => sglow_shaders::Light::Several,
    }
}

/// The kind of a light as an axis has it.
#[must_use]
pub fn kind(light: &Light) -> sglow_shaders::Light {
    match light.kind {
        LightKind::Spot { .. } => sglow_shaders::Light::Spot,
        LightKind::Directional => sglow_shaders::Light::Directional,
        LightKind::Point => sglow_shaders::Light::Point,
    }
}
