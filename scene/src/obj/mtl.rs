//! The statements of an MTL file: materials with their numbers and maps.
//!
//! [Wavefront, MTL material format, version 4.2], with what renderers have added for physically based materials.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{Mat3, Vec3};

use super::geometry::Name;
use super::text::{Faults, Line, Lines, Token};
use crate::note::{NoteKind, Notes};

/// A material as a library defines it.
#[derive(Clone, Debug)]
pub(super) struct Definition {
    pub(super) name: Name,
    /// The library's file, and the line that begins the material.
    pub(super) file: PathBuf,
    /// `Kd`, `Ks`, `Ka`, `Ke`, `Tf` by their keywords in lower case.
    pub(super) colors: BTreeMap<&'static str, [f32; 3]>,
    /// `Ns`, `d`, `Tr`, `Ni`, `Pr`, `Pm`, `illum`, likewise.
    pub(super) numbers: BTreeMap<&'static str, f32>,
    /// The maps by their statements without `map_`; `norm` and `bump` have other names as well.
    pub(super) maps: BTreeMap<&'static str, Map>,
}

/// A map of a material.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// The file's name as given.
    pub(super) name: String,
    pub(super) place: (usize, usize),
    /// Of texture coordinates with v pointing up.
    pub(super) scale: [f32; 2],
    pub(super) offset: [f32; 2],
    pub(super) clamp: bool,
    /// Which channel a number is read from.
    pub(super) channel: Option<char>,
    /// `-bm`: what heights, or the slopes of a normal map, are multiplied with.
    pub(super) multiplier: f32,
}

const COLORS: [&str; 5] = ["ka", "kd", "ke", "ks", "tf"];
const NUMBERS: [&str; 7] = ["d", "illum", "ni", "ns", "pm", "pr", "tr"];
/// The maps that are read.
const MAPS: [&str; 6] = ["d", "kd", "ke", "ks", "pm", "pr"];
/// Those that have other names as well.
const OTHERS: [(&str, &str); 6] = [
    ("bump", "bump"),
    ("map_bump", "bump"),
    ("map_kn", "norm"),
    ("map_norm", "norm"),
    ("map_normal", "norm"),
    ("norm", "norm"),
];

/// Statements that the picture is drawn without, and what it then lacks.
const IGNORED: [(&str, &str); 20] = [
    ("aniso", "anisotropy: highlights are round"),
    ("anisor", "anisotropy: highlights are round"),
    ("decal", "decal: it is not shown"),
    ("disp", "displacement map: the surface stays as it is"),
    ("map_aat", "antialiasing of textures"),
    ("map_disp", "displacement map: the surface stays as it is"),
    ("map_ka", "map_Ka: ambient light is what is computed"),
    ("map_ns", "map_Ns: the roughness is that of Ns everywhere"),
    ("map_pc", "clearcoat: there is no second highlight"),
    ("map_ps", "sheen: there is none"),
    ("map_refl", "reflection map: reflections are those of the scene's lights"),
    ("map_rma", "map of roughness, metallic and occlusion in one: use map_Pr and map_Pm"),
    ("map_tr", "map_Tr: use map_d"),
    ("pc", "clearcoat: there is no second highlight"),
    ("pcr", "clearcoat: there is no second highlight"),
    ("ps", "sheen: there is none"),
    ("refl", "reflection map: reflections are those of the scene's lights"),
    ("sharpness", "sharpness of reflection maps"),
    ("map_orm", "map of occlusion, roughness and metallic in one: use map_Pr and map_Pm"),
    ("map_opacity", "map_opacity: use map_d"),
];

/// Reads a library; what is wrong with a line is added to the faults.
pub(super) fn read(
    file: &Path,
    bytes: &[u8],
    faults: &mut Faults,
    notes: &mut Notes,
) -> Vec<Definition> {
    let mut definitions: Vec<Definition> = Vec::new();
    for line in Lines::new(bytes) {
        if line.keyword() == "newmtl" {
            definitions.push(Definition {
                name: Name::of(&line),
                file: file.into(),
                colors: BTreeMap::new(),
                numbers: BTreeMap::new(),
                maps: BTreeMap::new(),
            });
            continue;
        }
        let Some(definition) = definitions.last_mut() else {
            faults.add(line.place(), "stands before the first `newmtl`");
            continue;
        };
        definition.line(&line, faults, notes);
    }
    definitions
}

impl Definition {
    fn line(&mut self, line: &Line<'_>, faults: &mut Faults, notes: &mut Notes) {
        let keyword = line.keyword();
        let keyword = keyword.as_str();
        let same = |known: &&&str| **known == keyword;
        if let Some(&known) = COLORS.iter().find(same) {
            if let Some(color) = color(line, faults) {
                self.colors.insert(known, color);
            }
        } else if let Some(&known) = NUMBERS.iter().find(same) {
            match line.arguments() {
                [only, ..] => match only.number() {
                    Ok(number) => drop(self.numbers.insert(known, number as f32)),
                    Err(_) if only.bytes == b"-halo" => {
                        let message = "`-halo` is not read: opacity does not depend on the angle";
                        faults.add(line.place_of(0), message);
                    }
                    Err(message) => faults.add(line.place_of(0), message),
                },
                [] => faults.add(line.place_of(0), "a number is missing"),
            }
        } else if let Some(known) = map_of(keyword) {
            if let Some(map) = map(line, faults, notes) {
                self.maps.insert(known, map);
            }
        } else if let Some((_, text)) = IGNORED.iter().find(|(known, _)| *known == keyword) {
            notes.add(NoteKind::Ignored, *text, &self.name.cut);
        } else {
            let shown = line.tokens.first().map(Token::shown).unwrap_or_default();
            faults.add(line.place(), format!("`{shown}` is not a statement of MTL that is known"));
        }
    }
}

/// Which map a statement is about.
fn map_of(keyword: &str) -> Option<&'static str> {
    let plain = MAPS.iter().copied().find(|&map| keyword.strip_prefix("map_") == Some(map));
    let other = || OTHERS.iter().find(|(name, _)| *name == keyword).map(|(_, map)| *map);
    plain.or_else(other)
}

/// `r [g [b]]`, where missing ones are the last one given, or `xyz x [y z]`.
fn color(line: &Line<'_>, faults: &mut Faults) -> Option<[f32; 3]> {
    // [IEC 61966-2-1: linear Rec. 709 of CIE XYZ]
    const FROM_XYZ: Mat3 = Mat3::from_cols(
        Vec3::new(3.240_97, -0.969_244, 0.055_63),
        Vec3::new(-1.537_383, 1.875_968, -0.203_977),
        Vec3::new(-0.498_611, 0.041_555, 1.056_972),
    );
    let words = line.arguments();
    let xyz = words.first().is_some_and(|word| word.bytes == b"xyz");
    let first = usize::from(xyz);
    if words.first().is_some_and(|word| word.bytes == b"spectral") {
        faults.add(line.place_of(0), "`spectral` is not read; give red, green and blue");
        return None;
    }
    let mut color = [0.0; 3];
    let mut last = None;
    for (at, channel) in color.iter_mut().enumerate() {
        match words.get(first + at).map(Token::number) {
            Some(Ok(number)) => last = Some(number as f32),
            Some(Err(message)) => {
                faults.add(line.place_of(first + at), message);
                return None;
            }
            None => {}
        }
        let Some(last) = last else {
            faults.add(line.place_of(first), "a colour needs one to three numbers");
            return None;
        };
        *channel = last;
    }
    Some(if xyz { (FROM_XYZ * Vec3::from(color)).max(Vec3::ZERO).into() } else { color })
}

/// `map_Kd [-options arguments] file name`.
fn map(line: &Line<'_>, faults: &mut Faults, notes: &mut Notes) -> Option<Map> {
    let words = line.arguments();
    let mut map = Map {
        name: String::new(),
        place: line.place(),
        scale: [1.0; 2],
        offset: [0.0; 2],
        clamp: false,
        channel: None,
        multiplier: 1.0,
    };
    let mut at = 0;
    while let Some(option) = words.get(at) {
        let name = option.text().to_lowercase();
        let Some(most) = arguments_of(&name) else { break };
        at += 1;
        let first = at;
        // Numbers may be left out from behind; the file's name is never one of them.
        let is_argument = |word: &Token<'_>| match name.as_str() {
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-imfchan" | "-type" => true,
            _ => word.number().is_ok(),
        };
        while at < first + most && at + 1 < words.len() && is_argument(&words[at]) {
            at += 1;
        }
        let given = &words[first..at];
        let number = |index: usize| given.get(index).and_then(|word| word.number().ok());
        match name.as_str() {
            "-s" | "-o" => {
                let default = if name == "-s" { 1.0 } else { 0.0 };
                let pair = [0, 1].map(|index| number(index).unwrap_or(default) as f32);
                *(if name == "-s" { &mut map.scale } else { &mut map.offset }) = pair;
            }
            "-clamp" => map.clamp = given.first().is_some_and(|word| word.bytes == b"on"),
            "-imfchan" => map.channel = given.first().and_then(|word| word.text().chars().next()),
            "-bm" => map.multiplier = number(0).map_or(1.0, |number| number as f32),
            // Filters and the size of a map in memory are ours to choose.
            "-blendu" | "-blendv" | "-texres" => {}
            _ => {
                let text = format!("option `{name}` of {}", line.tokens[0].text());
                notes.add(NoteKind::Ignored, text, "");
            }
        }
    }
    if at >= words.len() {
        faults.add(line.place_of(words.len()), "the name of an image is missing");
        return None;
    }
    map.name = line.span(at, words.len() - 1);
    Some(map)
}

/// The most arguments that an option of a map takes.
fn arguments_of(option: &str) -> Option<usize> {
    match option {
        "-blendu" | "-blendv" | "-boost" | "-bm" | "-cc" | "-clamp" | "-imfchan" | "-texres"
        | "-type" => Some(1),
        "-mm" => Some(2),
        "-o" | "-s" | "-t" => Some(3),
        _ => None,
    }
}
