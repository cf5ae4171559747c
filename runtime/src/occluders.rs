//! The triangles that occlude virtual lights, on a device.

use sglow_shaders::frame::resource;
use sglow_shaders::{SglowShadowPoint, Visibility};
use wgpu::util::DeviceExt as _;

use crate::execute::{Faults, Inputs};
use crate::points::{Geometry, GeometryError};
use crate::settings::Settings;

/// Sets of points; lights that are neighbours see different ones, so that their errors average out.
pub const SUBSETS: u32 = 16;

/// What the maps of virtual lights are drawn from: triangles, or points on them. All of them count as opaque, those with
/// alpha test as well, and from both sides.
#[derive(Clone, Debug, Default)]
pub struct Occluders {
    buffers: Vec<(&'static str, wgpu::Buffer)>,
    counts: [u32; 2],
    /// What they were made for: the visibility, and the points of each light's map.
    made_for: Option<(Visibility, u32)>,
}

impl Occluders {
    /// Uploads what the visibility of the settings needs of the triangles; nothing with visibility `none`.
    ///
    /// # Errors
    ///
    /// The first index or position at fault.
    pub fn new(
        device: &wgpu::Device,
        settings: &Settings,
        geometry: Geometry<'_>,
    ) -> Result<Self, GeometryError> {
        geometry.check()?;
        let make = |name: &'static str, contents: &[u8], usage| {
            let descriptor = wgpu::util::BufferInitDescriptor {
                label: Some(name),
                // A buffer of no bytes cannot be bound; nothing is drawn of these.
                contents: if contents.is_empty() { &[0; 12] } else { contents },
                usage: usage | wgpu::BufferUsages::COPY_SRC,
            };
            (name, device.create_buffer_init(&descriptor))
        };
        let Geometry { positions, indices } = geometry;
        let mut counts = [positions.len() as u32, indices.len() as u32];
        let buffers = match settings.visibility {
            Visibility::None => Vec::new(),
            Visibility::ShadowMap => {
                vec![
                    make(
                        resource::OCCLUDER_POSITIONS,
                        bytemuck::cast_slice(positions),
                        wgpu::BufferUsages::VERTEX,
                    ),
                    make(
                        resource::OCCLUDER_INDICES,
                        bytemuck::cast_slice(indices),
                        wgpu::BufferUsages::INDEX,
                    ),
                ]
            }
            Visibility::Imperfect => {
                let mut points = geometry.points(settings.shadow_points, SUBSETS);
                if points.is_empty() {
                    counts[1] = 0;
                    let count = settings.shadow_points as usize * SUBSETS as usize;
                    points.resize(count, SglowShadowPoint::default());
                }
                let bytes = bytemuck::cast_slice(&points);
                vec![make(resource::POINTS, bytes, wgpu::BufferUsages::STORAGE)]
            }
        };
        let made_for = Some((settings.visibility, settings.shadow_points));
        Ok(Self { buffers, counts, made_for })
    }

    /// Whether they serve these settings: other numbers of points lie elsewhere in their buffer.
    pub(crate) fn check(&self, settings: &Settings) -> Result<(), Faults> {
        let called = |(visibility, points): (Visibility, u32)| match visibility {
            Visibility::Imperfect => format!("visibility={visibility},shadow_points={points}"),
            _ => format!("visibility={visibility}"),
        };
        let requested = called((settings.visibility, settings.shadow_points));
        let made_for = self.made_for.map(called);
        if settings.visibility == Visibility::None || made_for.as_ref() == Some(&requested) {
            return Ok(());
        }
        let found = made_for.map_or("left out".to_owned(), |made_for| format!("for {made_for}"));
        let expected = format!(
            "for {requested}: made by Occluders::new of the settings and given by Indirect::occlude"
        );
        Err(Faults::of("the geometry that occludes", found, expected))
    }

    /// Numbers of vertices and of indices.
    pub fn counts(&self) -> [u32; 2] {
        self.counts
    }

    /// The buffers by the names of the frame's resources.
    pub fn buffers(&self) -> impl Iterator<Item = (&'static str, &wgpu::Buffer)> {
        self.buffers.iter().map(|(name, buffer)| (*name, buffer))
    }

    /// Supplies the buffers for a frame.
    pub fn supply(&self, inputs: &mut Inputs<'_>) {
        for (name, buffer) in self.buffers() {
            inputs.buffer(name, buffer);
        }
    }
}
