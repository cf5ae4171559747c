//! The statements of an OBJ file: vertices, faces, groups, and which materials the faces are made of.
//!
//! [Wavefront, Appendix B1, Object Files (.obj), version 3.0]

use std::collections::HashMap;
use std::path::Path;

use super::text::{Faults, Line, Lines, Token};
use crate::note::{NoteKind, Notes};
use crate::{Limits, SceneError};

/// A corner's texture coordinates or normal that are not given.
pub(super) const NONE: u32 = u32::MAX;

/// What a corner is made of: position, texture coordinates, normal.
pub(super) type Corner = [u32; 3];

/// A name, which may end where something like a comment begins, or not.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Name {
    pub(super) cut: String,
    pub(super) whole: String,
}

impl Name {
    pub(super) fn of(line: &Line<'_>) -> Self {
        Self { cut: line.rest(), whole: line.rest_with_comment() }
    }
}

/// A polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// Where its corners start, and how many there are.
    pub(super) first: usize,
    pub(super) count: usize,
    /// Index into [`Geometry::groups`].
    pub(super) group: usize,
    /// Index into [`Geometry::materials`].
    pub(super) material: Option<usize>,
    /// The smoothing group, 0 for none.
    pub(super) smoothing: u32,
    /// Its line and column.
    pub(super) place: (usize, usize),
}

/// What a file holds.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    /// NaN where a line cannot be read, so that the others keep their numbers.
    pub(super) positions: Vec<[f64; 3]>,
    /// As long as `positions`, or empty.
    pub(super) colors: Vec<[f32; 3]>,
    /// v pointing up.
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) corners: Vec<Corner>,
    pub(super) faces: Vec<Face>,
    /// Names of groups and objects; the first is that of what is in none.
    pub(super) groups: Vec<String>,
    /// The materials that faces name.
    pub(super) materials: Vec<Name>,
    /// The lines that name material libraries, with their arguments.
    pub(super) libraries: Vec<Library>,
}

/// A line that names material libraries.
#[derive(Clone, Debug)]
pub(super) struct Library {
    pub(super) place: (usize, usize),
    /// All of its text.
    pub(super) whole: String,
    /// Its words.
    pub(super) words: Vec<String>,
}

/// What holds until it is set again.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    group: usize,
    material: Option<usize>,
    smoothing: u32,
}

struct Reader<'a> {
    file: &'a Path,
    limits: &'a Limits,
    geometry: Geometry,
    state: State,
    known_groups: HashMap<String, usize>,
    known_materials: HashMap<Name, usize>,
    ahead: Vec<Ahead>,
}

/// A corner beyond what was there when it was read.
struct Ahead {
    face: usize,
    corner: usize,
    place: (usize, usize),
}

/// Reads all lines; what is wrong with one is added to the faults.
pub(super) fn read(
    file: &Path,
    bytes: &[u8],
    limits: &Limits,
    faults: &mut Faults,
    notes: &mut Notes,
) -> Result<Geometry, SceneError> {
    let mut reader = Reader {
        file,
        limits,
        geometry: Geometry { groups: vec!["unnamed_object".to_owned()], ..Geometry::default() },
        state: State::default(),
        known_groups: HashMap::new(),
        known_materials: HashMap::new(),
        ahead: Vec::new(),
    };
    for line in Lines::new(bytes) {
        reader.line(&line, faults, notes)?;
    }
    reader.check_ahead(faults);
    Ok(reader.geometry)
}

impl Reader<'_> {
    fn line(
        &mut self,
        line: &Line<'_>,
        faults: &mut Faults,
        notes: &mut Notes,
    ) -> Result<(), SceneError> {
        let keyword = line.keyword();
        match keyword.as_str() {
            "v" => self.vertex(line, faults),
            "vt" => {
                let [u, v] =
                    numbers(line, 1, "texture coordinates need u", faults).unwrap_or_default();
                self.geometry.uvs.push([u as f32, v as f32]);
            }
            "vn" => {
                let normal: [f64; 3] =
                    numbers(line, 3, "a normal needs x, y and z", faults).unwrap_or_default();
                self.geometry.normals.push(normal.map(|component| component as f32));
            }
            "f" | "fo" => self.face(line, faults),
            "o" | "g" => self.state.group = self.group(line.rest()),
            "usemtl" => {
                let name = Name::of(line);
                let materials = &mut self.geometry.materials;
                let known = self.known_materials.entry(name.clone()).or_insert_with(|| {
                    materials.push(name);
                    materials.len() - 1
                });
                self.state.material = Some(*known);
            }
            "mtllib" => {
                let words = line.arguments().iter().map(Token::text).collect();
                let library =
                    Library { place: line.place(), whole: line.rest_with_comment(), words };
                self.geometry.libraries.push(library);
            }
            "s" => match smoothing(line.arguments().first()) {
                Ok(smoothing) => self.state.smoothing = smoothing,
                Err(message) => faults.add(line.place_of(0), message),
            },
            "p" | "l" => notes.add(NoteKind::Ignored, "points and lines", ""),
            "vp" | "cstype" | "deg" | "bmat" | "step" | "curv" | "curv2" | "surf" | "parm"
            | "trim" | "hole" | "scrv" | "sp" | "end" | "con" | "mg" | "ctech" | "stech"
            | "bzp" | "bsp" | "cdc" | "cdp" | "res" => {
                notes.add(NoteKind::Ignored, "free-form curves and surfaces", "");
            }
            "bevel" | "c_interp" | "d_interp" | "lod" | "shadow_obj" | "trace_obj" | "maplib"
            | "usemap" | "call" | "csh" => {
                notes.add(NoteKind::Ignored, "OBJ statement without an effect here", keyword);
            }
            _ => {
                let shown = line.tokens.first().map(Token::shown).unwrap_or_default();
                faults.add(line.place(), format!("`{shown}` is not a statement of OBJ"));
            }
        }
        let Geometry { positions, corners, .. } = &self.geometry;
        for (what, needed, limit) in [
            ("vertices", positions.len(), self.limits.vertices),
            ("corners of faces", corners.len(), self.limits.triangles.saturating_mul(3)),
        ] {
            if needed > limit {
                return Err(SceneError::TooMuch { file: self.file.into(), what, needed, limit });
            }
        }
        Ok(())
    }

    /// `v x y z [w]`, `v x y z r g b`; a weight w counts for curves alone.
    fn vertex(&mut self, line: &Line<'_>, faults: &mut Faults) {
        let Geometry { positions, colors, .. } = &mut self.geometry;
        let position = numbers(line, 3, "a vertex needs x, y and z", faults);
        let position: Option<[f64; 3]> = position;
        let color = match line.arguments().len() {
            6 | 7 if position.is_some() => numbers_from(line, 3, faults),
            _ => None,
        };
        if let Some(color) = color {
            colors.resize(positions.len(), [1.0; 3]);
            colors.push(color.map(|channel| channel as f32));
        } else if !colors.is_empty() {
            colors.push([1.0; 3]);
        }
        positions.push(position.unwrap_or([f64::NAN; 3]));
    }

    fn face(&mut self, line: &Line<'_>, faults: &mut Faults) {
        let arguments = line.arguments();
        if arguments.len() < 3 {
            let found = arguments.len();
            return faults.add(line.place(), format!("a face needs 3 corners, this has {found}"));
        }
        let Geometry { positions, uvs, normals, corners, faces, .. } = &mut self.geometry;
        let counts = [positions.len(), uvs.len(), normals.len()];
        let first = corners.len();
        let ahead = self.ahead.len();
        for (at, token) in arguments.iter().enumerate() {
            match corner(token, counts) {
                Ok(corner) => {
                    let there =
                        |(&index, count): (&u32, usize)| index == NONE || (index as usize) < count;
                    if !corner.iter().zip(counts).all(there) {
                        let (face, corner) = (faces.len(), corners.len());
                        self.ahead.push(Ahead { face, corner, place: line.place_of(at) });
                    }
                    corners.push(corner);
                }
                Err(message) => {
                    corners.truncate(first);
                    self.ahead.truncate(ahead);
                    return faults.add(line.place_of(at), message);
                }
            }
        }
        faces.push(Face {
            first,
            count: corners.len() - first,
            group: self.state.group,
            material: self.state.material,
            smoothing: self.state.smoothing,
            place: line.place(),
        });
    }

    fn group(&mut self, name: String) -> usize {
        if name.is_empty() {
            return 0;
        }
        let groups = &mut self.geometry.groups;
        *self.known_groups.entry(name.clone()).or_insert_with(|| {
            groups.push(name);
            groups.len() - 1
        })
    }

    /// Faces may come before their vertices; those whose vertices never come are dropped.
    fn check_ahead(&mut self, faults: &mut Faults) {
        let Geometry { positions, uvs, normals, corners, faces, .. } = &mut self.geometry;
        let kinds = [
            ("vertex", positions.len()),
            ("vertex of texture coordinates", uvs.len()),
            ("normal", normals.len()),
        ];
        for Ahead { face, corner, place } in std::mem::take(&mut self.ahead) {
            let missing = corners[corner]
                .iter()
                .zip(kinds)
                .find(|&(&index, (_, count))| index != NONE && index as usize >= count);
            let Some((&index, (kind, count))) = missing else { continue };
            let number = u64::from(index) + 1;
            faults.add(place, format!("there is no {kind} {number}; the file has {count}"));
            // A face without corners is none.
            faces[face].count = 0;
        }
        faces.retain(|face| face.count > 0);
    }
}

/// `s off`, `s 0`, `s 3`.
fn smoothing(token: Option<&Token<'_>>) -> Result<u32, String> {
    match token.map(Token::text).as_deref() {
        None | Some("off" | "Off" | "OFF" | "null") => Ok(0),
        Some("on" | "On" | "ON") => Ok(1),
        Some(text) => text.parse().map_err(|_| {
            let shown = token.map(Token::shown).unwrap_or_default();
            format!("`{shown}` is not a smoothing group; expected a number or `off`")
        }),
    }
}

/// `v`, `v/vt`, `v//vn`, `v/vt/vn`, each counted from 1, or from the last one if it is negative.
fn corner(token: &Token<'_>, counts: [usize; 3]) -> Result<Corner, String> {
    let mut corner = [NONE; 3];
    let mut parts = token.bytes.split(|&byte| byte == b'/');
    // In this order, so that a fourth part is left over.
    for ((index, count), part) in corner.iter_mut().zip(counts).zip(parts.by_ref()) {
        if !part.is_empty() {
            *index =
                reference(part, count).map_err(|reason| match token.bytes.contains(&b'/') {
                    true => format!("corner `{}`: {reason}", token.shown()),
                    false => reason,
                })?;
        }
    }
    if parts.next().is_some() || corner[0] == NONE {
        let shown = token.shown();
        return Err(format!(
            "`{shown}` is not a corner; expected `v`, `v/vt`, `v//vn` or `v/vt/vn`"
        ));
    }
    Ok(corner)
}

fn reference(part: &[u8], count: usize) -> Result<u32, String> {
    let shown = || super::text::text(part).chars().take(20).collect::<String>();
    let number = std::str::from_utf8(part).ok().and_then(|text| text.parse::<i64>().ok());
    let number = number.ok_or_else(|| format!("`{}` is not a whole number", shown()))?;
    let index = match number {
        0 => return Err("numbers start at 1; -1 is the last one".to_owned()),
        1.. => number - 1,
        // Relative to what was there so far.
        _ => (count as i64).saturating_add(number),
    };
    if index < 0 {
        return Err(format!("`{}` reaches before the first of {count}", shown()));
    }
    // Indices of the device have 32 bits, of which the last is none.
    u32::try_from(index)
        .ok()
        .filter(|&index| index != NONE)
        .ok_or_else(|| format!("`{}` is out of range", shown()))
}

/// The first `N` arguments as numbers, of which `needed` have to be there; others are 0.
fn numbers<const N: usize>(
    line: &Line<'_>,
    needed: usize,
    rule: &str,
    faults: &mut Faults,
) -> Option<[f64; N]> {
    let found = line.arguments().len();
    if found < needed {
        faults.add(line.place_of(found), format!("{rule}, this has {found} of them"));
        return None;
    }
    numbers_from(line, 0, faults)
}

/// `N` arguments from number `first` on as numbers, 0 where there are no more.
fn numbers_from<const N: usize>(
    line: &Line<'_>,
    first: usize,
    faults: &mut Faults,
) -> Option<[f64; N]> {
    let mut numbers = [0.0; N];
    for (at, number) in numbers.iter_mut().enumerate() {
        let Some(token) = line.arguments().get(first + at) else { break };
        match token.number() {
            Ok(found) => *number = found,
            Err(message) => {
                faults.add(line.place_of(first + at), message);
                return None;
            }
        }
    }
    Some(numbers)
}
