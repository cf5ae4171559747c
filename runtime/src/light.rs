//! The image that the reflective shadow map of a light is, or of several: its projections, and what the shaders know of the
//! lights.

use std::slice;

use glam::camera::rh::proj::directx::orthographic;
use glam::camera::rh::view::look_to_mat4;
use glam::{DVec3, Mat4, Vec2, Vec3, Vec4};
use sglow_shaders::frame::input;
use sglow_shaders::{Light, SglowLight};
use thiserror::Error;

use crate::execute::{Input, Inputs};
use crate::host;

/// Faces that the map of several lights has at most: the maximum of the parameter `light_faces`.
pub const MAXIMUM_FACES: usize = 64;

/// Lights that no map can have together.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LightsError {
    /// There are none.
    #[error("no light is given; expected at least one")]
    None,
    /// None of them sends light.
    #[error("none of {count} lights has power: give at least one of them a positive intensity")]
    Dark {
        /// How many there are.
        count: usize,
    },
    /// Their map has too many faces.
    #[error(
        "{lights} lights have {faces} faces, 6 of a point light and 1 of another; one map has at most {MAXIMUM_FACES}: use fewer \
         lights"
    )]
    TooMany {
        /// How many lights there are.
        lights: usize,
        /// The faces of their maps.
        faces: usize,
    },
    /// They are of several lights already, or for other surroundings than the first.
    #[error("light {index} is {found}; expected a single light for the surroundings of light 0")]
    Apart {
        /// Its number, from 0 on.
        index: usize,
        /// What it is.
        found: String,
    },
    /// One has a width that does not lie in the middle of its tile.
    #[error(
        "light {index} is {texels} texels wide in a tile of {tile}; expected as many or an even number less, at least 1"
    )]
    Size {
        /// Its number, from 0 on.
        index: usize,
        /// Its width in texels.
        texels: u32,
        /// Width of a tile.
        tile: u32,
    },
}

/// One face of a light's map.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    /// From positions relative to the light's to clip space.
    pub clip_from_light: Mat4,
    /// Unit axes of its image: to the right, up, and into the scene.
    pub axes: [Vec3; 3],
    /// The face's rectangle in the map: left, top, width, height, each as a share of the map.
    pub tile: [f32; 4],
}

/// A light, or several, as passes see them.
#[derive(Clone, Debug)]
pub struct LightView {
    /// Its kind.
    pub kind: Light,
    /// Width and height of its map in texels.
    pub map: u32,
    /// Among several: the width in texels of what each of its faces has in the middle of its tile, of the tile's proportions;
    /// nothing for all of it. Around that of a directional light no scene may lie.
    pub texels: Option<u32>,
    /// The light's uniform; the position of a directional light lies in the image's plane. Of several lights that of the first.
    pub uniform: SglowLight,
    /// The light's position with w = 1, or the direction towards it with w = 0. Of several lights that of the first.
    pub eye: Vec4,
    /// One face, or the six of a point light in the order +x, -x, +y, -y, +z, -z; of several lights those of each in turn.
    pub faces: Vec<Face>,
    /// Several lights, each as it is by itself; nothing of one.
    pub lights: Vec<LightView>,
    /// What the moments' positions are relative to: the middle of the scene, itself relative to [`Surroundings::origin`].
    pub origin: Vec3,
    /// The least positional variance of a virtual light: that of a square as large as a texel of the map, at the
    /// distance of the scene's radius.
    pub minimum_variance: f32,
    /// The power that a one stands for where moments are held in halves: the power of two that puts the brightest
    /// photon the light can give between 16384 and 32768, below the largest half and 29 binades above the least one that
    /// keeps all its bits.
    pub power_unit: f32,
    /// What lies within this distance of a virtual light does not occlude it, in world units.
    pub least_near: f32,
    /// The power of the brightest photon that the light can give a texel of its map.
    brightest: f64,
}

/// Forward and up of the six faces of a point light's map.
const FACES: [(Vec3, Vec3); 6] = [
    (Vec3::X, Vec3::Y),
    (Vec3::NEG_X, Vec3::Y),
    (Vec3::Y, Vec3::Z),
    (Vec3::NEG_Y, Vec3::NEG_Z),
    (Vec3::Z, Vec3::Y),
    (Vec3::NEG_Z, Vec3::Y),
];

/// Of a light without one: the tangent of half an angle of 90 degrees, and an intensity that does not fall.
const NO_CONE: [f32; 3] = [1.0, 0.0, 1.0];

/// What a light shines on: a sphere around it, and the map that it is seen in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings {
    /// What positions in surface textures and uniforms are relative to, in world units: 32-bit floats far from it are
    /// coarse.
    pub origin: DVec3,
    /// The middle of the lit scene, in world units.
    pub center: DVec3,
    /// Its radius, in world units.
    pub radius: f32,
    /// Width and height of the reflective shadow map in texels.
    pub map: u32,
}

impl LightView {
    /// A spot light at `position`. `inner` and `outer` are angles from `direction` in radians, between which the intensity
    /// falls to 0 (KHR_lights_punctual), at most 1.569, for the map is one perspective image; `intensity` is in W/sr per channel, or candela.
    pub fn spot(
        around: &Surroundings,
        position: DVec3,
        direction: Vec3,
        [inner, outer]: [f32; 2],
        intensity: [f32; 3],
    ) -> Self {
        let outer = outer.clamp(1e-3, 1.569);
        // KHR_lights_punctual, inner and outer cone angles
        let scale = 1.0 / (inner.min(outer).cos() - outer.cos()).max(1e-3);
        let cone = [outer.tan(), scale, -outer.cos() * scale];
        let position = (position - around.origin).as_vec3();
        Self::new(Light::Spot, cone, position, direction, intensity, around)
    }

    /// A light from infinitely far away that shines along `direction`; `irradiance` is that on a facing surface, in W/m^2
    /// per channel, or lux.
    pub fn directional(around: &Surroundings, direction: Vec3, irradiance: [f32; 3]) -> Self {
        Self::new(Light::Directional, NO_CONE, Vec3::ZERO, direction, irradiance, around)
    }

    /// A light at `position` that shines alike in all directions; `intensity` is in W/sr per channel, or candela.
    pub fn point(around: &Surroundings, position: DVec3, intensity: [f32; 3]) -> Self {
        let position = (position - around.origin).as_vec3();
        Self::new(Light::Point, NO_CONE, position, Vec3::NEG_Z, intensity, around)
    }

    fn new(
        kind: Light,
        [tan_half_angle, cone_scale, cone_offset]: [f32; 3],
        position: Vec3,
        direction: Vec3,
        intensity: [f32; 3],
        around: &Surroundings,
    ) -> Self {
        let origin = (around.center - around.origin).as_vec3();
        let (size, radius) = (around.map, around.radius.max(1e-6));
        // What is a unit vector to rounding stays as it is.
        let unit = (direction.length_squared() - 1.0).abs() < 1e-5;
        let forward = if unit { direction } else { direction.normalize_or(Vec3::NEG_Z) };
        let right =
            forward.cross(if forward.y.abs() < 0.99 { Vec3::Y } else { Vec3::Z }).normalize();
        let up = right.cross(forward);
        let is_directional = kind == Light::Directional;
        // A directional light's image is centred on the scene; its position is where that image's plane lies.
        let position = if is_directional { origin - forward * (1.01 * radius) } else { position };
        let away = position.distance(origin);
        let far = (away + radius) * 1.001;
        let near = (away - radius).max(far * 1e-4);
        let half_extent = radius * 1.001;
        let eye = if is_directional { (-forward).extend(0.0) } else { position.extend(1.0) };
        let face = |projection: Mat4, (forward, up): (Vec3, Vec3), tile| Face {
            clip_from_light: projection * look_to_mat4(Vec3::ZERO, forward, up),
            axes: [forward.cross(up), up, forward],
            tile,
        };
        let frustum = perspective(tan_half_angle, 1.0, near, far);
        let whole = [0.0, 0.0, 1.0, 1.0];
        // With the width at the distance of the scene's radius, and the area or solid angle, with that of empty tiles.
        let (faces, width, image) = match kind {
            Light::Directional => {
                let extent = half_extent;
                let projection = orthographic(-extent, extent, -extent, extent, near, far);
                let area = 4.0 * f64::from(half_extent).powi(2);
                (vec![face(projection, (forward, up), whole)], 2.0 * half_extent, area)
            }
            Light::Point => {
                let tile = |face| [(face % 4) as f32 * 0.25, (face / 4) as f32 * 0.5, 0.25, 0.5];
                let faces = FACES.into_iter().enumerate();
                let faces = faces.map(|(index, axes)| face(frustum, axes, tile(index)));
                (faces.collect(), 2.0 * tan_half_angle * radius, 4.0 * 8.0)
            }
            Light::Spot | Light::Camera | Light::Several => {
                let angle = 4.0 * f64::from(tan_half_angle).powi(2);
                (vec![face(frustum, (forward, up), whole)], 2.0 * tan_half_angle * radius, angle)
            }
        };
        // The largest of a texel's solid angles, in the middle of the image or of a face; or its area.
        let brightest = intensity.into_iter().map(f64::from).fold(0.0, f64::max) * image
            / f64::from(size).powi(2);
        Self {
            kind,
            map: size,
            texels: None,
            uniform: SglowLight {
                position: position.into(),
                tan_half_angle,
                right: right.into(),
                half_extent,
                up: up.into(),
                cone_scale,
                forward: forward.into(),
                cone_offset,
                intensity,
                ..bytemuck::Zeroable::zeroed()
            },
            eye,
            faces,
            lights: Vec::new(),
            origin,
            minimum_variance: host::minimum_variance(width / size as f32),
            power_unit: host::power_unit(brightest),
            least_near: host::least_near(around.radius),
            brightest,
        }
    }

    /// Several lights in one map, of kinds that may differ: a grid of equal tiles, one for each face. The lights are made for
    /// the same surroundings, each as if it were alone; [`Self::texels`] may differ.
    ///
    /// # Errors
    ///
    /// No light, none with power, more faces than a map can have, or a light that does not fit the first or its tile.
    pub fn several(lights: &[Self]) -> Result<Self, LightsError> {
        let first = lights.first().ok_or(LightsError::None)?;
        let around = |light: &Self| (light.map, light.origin, light.least_near);
        for (index, light) in lights.iter().enumerate() {
            if light.kind == Light::Several {
                return Err(LightsError::Apart { index, found: "several lights".to_owned() });
            }
            if around(light) != around(first) {
                let found = format!("for another scene, or for a map of {} texels", light.map);
                return Err(LightsError::Apart { index, found });
            }
        }
        let count = lights.len();
        if !lights.iter().any(|light| light.uniform.intensity.iter().any(|&channel| channel > 0.0))
        {
            return Err(LightsError::Dark { count });
        }
        let faces: usize = lights.iter().map(|light| light.faces.len()).sum();
        if faces > MAXIMUM_FACES {
            return Err(LightsError::TooMany { lights: count, faces });
        }
        let grid @ [columns, rows] = grid(faces as u32);
        let width = first.map / columns;
        let fits =
            |texels: u32| texels > 0 && texels <= width && (width - texels).is_multiple_of(2);
        for (index, light) in lights.iter().enumerate() {
            if let Some(texels) = light.texels.filter(|&texels| !fits(texels)) {
                return Err(LightsError::Size { index, texels, tile: width });
            }
        }
        let tile = |number: usize| {
            let [across, down] = [number as u32 % columns, number as u32 / columns];
            let [width, height] = grid.map(|side| 1.0 / side as f32);
            [across as f32 * width, down as f32 * height, width, height]
        };
        let all = lights.iter().flat_map(|light| light.faces.iter().map(move |face| (light, face)));
        let faces = all.enumerate().map(|(number, (light, face))| {
            let narrow = Vec2::splat(1.0 / light.margin(columns)).extend(1.0);
            let clip_from_light = Mat4::from_scale(narrow) * face.clip_from_light;
            Face { clip_from_light, tile: tile(number), ..*face }
        });
        // Texels are wider, and brighter, than those of a map of one light.
        let variance = |light: &Self| light.minimum_variance * light.widened(columns).powi(2);
        let brightest = |light: &Self| {
            let [own_columns, own_rows] = light.grid();
            let tiles = f64::from(columns * rows) / f64::from(own_columns * own_rows);
            light.brightest * tiles * f64::from(light.margin(columns)).powi(2)
        };
        let brightest = lights.iter().map(brightest).fold(0.0, f64::max);
        let minimum_variance = lights.iter().map(variance).fold(f32::INFINITY, f32::min);
        Ok(Self {
            kind: Light::Several,
            faces: faces.collect(),
            lights: lights.to_vec(),
            minimum_variance,
            power_unit: host::power_unit(brightest),
            brightest,
            ..first.clone()
        })
    }

    /// Columns and rows of the tiles of the map.
    pub fn grid(&self) -> [u32; 2] {
        grid(self.faces.len() as u32)
    }

    /// How many times wider a texel is than by itself, for a light among several whose map has so many columns.
    pub fn widened(&self, columns: u32) -> f32 {
        self.margin(columns) * columns as f32 / self.grid()[0] as f32
    }

    /// How many times wider the tile is than what the light has of it: the tile's image is as much wider than the light's, and
    /// dark around it.
    fn margin(&self, columns: u32) -> f32 {
        self.texels.map_or(1.0, |texels| (self.map / columns) as f32 / texels as f32)
    }

    /// Each light, one of them by itself.
    pub fn each(&self) -> &[Self] {
        if self.lights.is_empty() { slice::from_ref(self) } else { &self.lights }
    }

    /// The light of each face, with the axes and the image of the face; those of a point light have no other cone than their
    /// image, and end at 90 degrees.
    pub fn face_lights(&self) -> Vec<SglowLight> {
        let of_light = |light: &Self| {
            let half_extent =
                if light.kind == Light::Directional { light.uniform.half_extent } else { 0.0 };
            let margin = if self.lights.is_empty() { 1.0 } else { light.margin(self.grid()[0]) };
            let half_extent = half_extent * margin;
            let tan_half_angle = light.uniform.tan_half_angle * margin;
            let uniform = SglowLight { half_extent, tan_half_angle, ..light.uniform };
            let of_face = |face: &Face| {
                let [right, up, forward] = face.axes.map(|axis| axis.to_array());
                SglowLight { right, up, forward, ..uniform }
            };
            light.faces.iter().map(of_face).collect::<Vec<_>>()
        };
        self.each().iter().flat_map(of_light).collect()
    }

    /// Gives a frame the light and what follows from it.
    pub fn give(&self, inputs: &mut Inputs<'_>) {
        let faces = || self.each().iter().flat_map(|light| light.faces.iter().map(move |_| light));
        let eyes = faces().flat_map(|light| light.eye.to_array()).collect();
        let origins = faces().flat_map(|light| light.uniform.position).collect();
        let matrices = self.faces.iter().flat_map(|face| face.clip_from_light.to_cols_array());
        let mut matrices: Vec<f32> = matrices.collect();
        uniform(inputs, input::LIGHT, &self.uniform);
        if self.kind == Light::Several {
            let mut lights: Vec<f32> = self.face_lights().iter().flat_map(numbers).collect();
            lights.resize(MAXIMUM_FACES * numbers(&self.uniform).count(), 0.0);
            matrices.resize(MAXIMUM_FACES * 16, 0.0);
            inputs.set(input::FACE_LIGHTS, Input::F32(lights));
        }
        inputs
            .set(input::LIGHT_EYE, self.eye.to_array())
            .set(input::FACE_EYE, Input::F32(eyes))
            .set(input::FACE_ORIGIN, Input::F32(origins))
            .set(input::LIGHT_CLIP_FROM_VIEW, Input::F32(matrices))
            .set(input::ORIGIN, self.origin.to_array())
            .set(input::MINIMUM_VARIANCE, self.minimum_variance)
            .set(input::POWER_UNIT, self.power_unit)
            .set(input::POWER_SCALE, 1.0 / self.power_unit);
    }
}

/// Gives a frame the camera's position.
pub fn eye_at(inputs: &mut Inputs<'_>, eye: Vec3) {
    inputs.set(input::EYE, eye.to_array());
    // As a light that sends importance: its position alone counts.
    let light = SglowLight { position: eye.into(), ..bytemuck::Zeroable::zeroed() };
    uniform(inputs, input::CAMERA_LIGHT, &light);
}

/// Columns and rows of the tiles of a map of so many faces: as near to a square as powers of two allow.
#[must_use]
pub fn grid(faces: u32) -> [u32; 2] {
    let bits = faces.max(1).next_power_of_two().ilog2();
    [1 << bits.div_ceil(2), 1 << (bits / 2)]
}

/// The members of a light in their order.
fn members(light: &SglowLight) -> [(&'static str, &[f32]); 9] {
    [
        ("position", &light.position),
        ("tan_half_angle", slice::from_ref(&light.tan_half_angle)),
        ("right", &light.right),
        ("half_extent", slice::from_ref(&light.half_extent)),
        ("up", &light.up),
        ("cone_scale", slice::from_ref(&light.cone_scale)),
        ("forward", &light.forward),
        ("cone_offset", slice::from_ref(&light.cone_offset)),
        ("intensity", &light.intensity),
    ]
}

/// The numbers of a light, member by member.
fn numbers(light: &SglowLight) -> impl Iterator<Item = f32> {
    members(light).into_iter().flat_map(|(_, numbers)| numbers).copied()
}

fn uniform(inputs: &mut Inputs<'_>, name: &'static str, light: &SglowLight) {
    for (member, numbers) in members(light) {
        inputs.member(name, member, Input::F32(numbers.to_vec()));
    }
}

/// A right-handed perspective projection with depth 0 at the near plane and 1 at the far one.
///
/// `tangent`: of half the vertical angle; `aspect`: width over height.
pub fn perspective(tangent: f32, aspect: f32, near: f32, far: f32) -> Mat4 {
    Mat4::from_cols(
        Vec4::new(1.0 / (tangent * aspect), 0.0, 0.0, 0.0),
        Vec4::new(0.0, 1.0 / tangent, 0.0, 0.0),
        Vec4::new(0.0, 0.0, far / (near - far), -1.0),
        Vec4::new(0.0, 0.0, near * far / (near - far), 0.0),
    )
}
