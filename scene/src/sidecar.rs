//! The sidecar `<file>.sglow.toml`: a camera and lights for a file that has none.
//!
//! ```toml
//! [camera]
//! position = [0.0, 1.0, 3.0]
//! target = [0.0, 1.0, 0.0]
//! vertical_fov_degrees = 40.0
//!
//! [[light]]
//! kind = "spot"
//! position = [0.0, 3.0, 0.0]
//! target = [0.0, 0.0, 0.0]
//! inner_cone_degrees = 30.0
//! outer_cone_degrees = 45.0
//! intensity = [30.0, 29.0, 27.0]
//! # With several lights: the share of its tile's width that the light's map has.
//! map_share = 0.5
//! ```

use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use serde::Deserialize;
use toml::Spanned;

use super::{Camera, Light, LightKind, Limits, SceneError, files};
use crate::draft::Draft;
use crate::origin::Placed;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sidecar {
    camera: Option<Spanned<CameraEntry>>,
    #[serde(default)]
    light: Vec<Spanned<LightEntry>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraEntry {
    position: [f64; 3],
    target: [f64; 3],
    #[serde(default = "up")]
    up: [f32; 3],
    #[serde(default = "vertical_fov_degrees")]
    vertical_fov_degrees: f32,
}

fn up() -> [f32; 3] {
    [0.0, 1.0, 0.0]
}

fn vertical_fov_degrees() -> f32 {
    45.0
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LightEntry {
    name: Option<String>,
    kind: Kind,
    position: Option<[f64; 3]>,
    target: Option<[f64; 3]>,
    direction: Option<[f32; 3]>,
    inner_cone_degrees: Option<f32>,
    outer_cone_degrees: Option<f32>,
    intensity: [f32; 3],
    range: Option<f32>,
    map_share: Option<f32>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Spot,
    Directional,
    Point,
}

/// Reads the sidecar of `file`, if there is one, into the draft.
pub(super) fn apply(file: &Path, limits: &Limits, draft: &mut Draft) -> Result<(), SceneError> {
    let sidecar = path_of(file);
    if !sidecar.exists() {
        return Ok(());
    }
    let text = String::from_utf8_lossy(&files::read(&sidecar, limits.file_bytes)?).into_owned();
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let fault = |span: Option<Range<usize>>, message: String| {
        let (line, column) = place(text, span.map_or(0, |span| span.start));
        SceneError::Sidecar { file: sidecar.clone(), line, column, message }
    };
    let parsed: Sidecar =
        toml::from_str(text).map_err(|e| fault(e.span(), e.message().to_owned()))?;
    let mut faults = Vec::new();
    if let Some(entry) = parsed.camera {
        let (span, entry) = (entry.span(), entry.into_inner());
        let position = DVec3::from(entry.position);
        let forward = (DVec3::from(entry.target) - position).normalize_or(DVec3::NEG_Z).as_vec3();
        let angle = entry.vertical_fov_degrees.to_radians();
        let camera = Camera::along([0.0; 3], forward, entry.up.into(), angle);
        let camera = Placed::at(position, camera);
        faults.extend(camera.what.fault(&sidecar).map(|f| fault(Some(span.clone()), f.reason())));
        if entry.position == entry.target {
            let message = "camera: position and target are the same point".to_owned();
            faults.push(fault(Some(span), message));
        }
        draft.camera = Some(camera);
    }
    if !parsed.light.is_empty() {
        draft.lights.clear();
    }
    for (index, entry) in parsed.light.into_iter().enumerate() {
        let (span, entry) = (entry.span(), entry.into_inner());
        match entry.into_light(index) {
            Ok(light) => {
                faults.extend(light.what.fault(&sidecar).map(|f| fault(Some(span), f.reason())));
                draft.lights.push(light);
            }
            Err(message) => faults.push(fault(Some(span), message)),
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(SceneError::of(faults)) }
}

impl LightEntry {
    fn into_light(self, index: usize) -> Result<Placed<Light>, String> {
        let name = self.name.unwrap_or_else(|| format!("light {index}"));
        let missing = |key: &str, kind: &str| format!("light `{name}`: a {kind} needs `{key}`");
        let position = match (self.kind, self.position) {
            (Kind::Directional, _) => [0.0; 3],
            (_, Some(position)) => position,
            (Kind::Spot, None) => return Err(missing("position", "spot light")),
            (Kind::Point, None) => return Err(missing("position", "point light")),
        };
        let direction = match (self.kind, self.direction, self.target) {
            (Kind::Point, ..) => [0.0, -1.0, 0.0],
            (_, Some(_), Some(_)) => {
                return Err(format!("light `{name}`: give `direction` or `target`, not both"));
            }
            (_, Some(direction), None) => direction,
            (_, None, Some(target)) => {
                let position = DVec3::from(self.position.unwrap_or_default());
                (DVec3::from(target) - position).normalize_or_zero().as_vec3().into()
            }
            (Kind::Spot, ..) => return Err(missing("target` or `direction", "spot light")),
            (Kind::Directional, ..) => {
                return Err(missing("direction` or `target", "directional light"));
            }
        };
        let kind = match (self.kind, self.inner_cone_degrees, self.outer_cone_degrees) {
            (Kind::Spot, inner, outer) => LightKind::Spot {
                inner: inner.unwrap_or(0.0).to_radians(),
                outer: outer
                    .ok_or_else(|| missing("outer_cone_degrees", "spot light"))?
                    .to_radians(),
            },
            (_, Some(_), _) | (_, _, Some(_)) => {
                return Err(format!("light `{name}`: only a spot light has a cone"));
            }
            (Kind::Directional, ..) => LightKind::Directional,
            (Kind::Point, ..) => LightKind::Point,
        };
        let light = Light {
            name,
            kind,
            position: [0.0; 3],
            direction: Vec3::from(direction).normalize_or_zero().into(),
            intensity: self.intensity,
            range: self.range,
            map_share: self.map_share.unwrap_or(1.0),
        };
        Ok(Placed::at(position.into(), light))
    }
}

/// `scene.glb` -> `scene.glb.sglow.toml`.
fn path_of(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(".sglow.toml");
    name.into()
}

/// One-based line and column of a byte offset.
fn place(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    (line, column)
}
