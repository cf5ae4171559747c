//! The two containers of glTF: JSON on its own, and the binary one that also holds a buffer.

use std::path::Path;

use serde::Deserialize;

use crate::SceneError;

/// The extensions that change what we read, all of them read.
const SUPPORTED: [&str; 10] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// What a picture lacks without an extension that is not read.
const LACKS: [(&str, &str); 16] = [
    ("EXT_lights_image_based", "there is no light from around"),
    ("KHR_animation_pointer", "nothing moves"),
    ("KHR_draco_mesh_compression", "meshes without uncompressed data are missing"),
    ("KHR_materials_anisotropy", "highlights are round"),
    ("KHR_materials_clearcoat", "there is no second highlight"),
    ("KHR_materials_diffuse_transmission", "no light is transmitted"),
    ("KHR_materials_dispersion", "nothing is refracted"),
    ("KHR_materials_iridescence", "reflections have no colours of thin films"),
    ("KHR_materials_sheen", "cloth has no sheen"),
    ("KHR_materials_transmission", "no light is transmitted"),
    ("KHR_materials_unlit", "the surface is lit like any other"),
    ("KHR_materials_variants", "the default variant is shown"),
    ("KHR_materials_volume", "nothing is refracted or absorbed"),
    ("KHR_node_visibility", "hidden nodes are shown"),
    ("KHR_texture_basisu", "textures without another image are missing"),
    ("MSFT_lod", "the finest level is shown"),
];

/// The JSON of a file and its binary chunk.
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    pub(super) binary: Option<&'a [u8]>,
}

/// The type of a chunk, its data, and what follows it.
type Chunk<'a> = ([u8; 4], &'a [u8], &'a [u8]);

/// The part of the JSON that says whether the rest can be understood.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Head {
    asset: Asset,
    #[serde(default)]
    extensions_used: Vec<String>,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Asset {
    version: String,
    min_version: Option<String>,
}

/// Splits a file: the binary container by its first bytes, JSON otherwise.
pub(super) fn split<'a>(file: &Path, bytes: &'a [u8]) -> Result<Container<'a>, SceneError> {
    let Some(after_magic) = bytes.strip_prefix(b"glTF") else {
        // A byte order mark is not allowed there, and written nevertheless.
        let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return Ok(Container { json, binary: None });
    };
    let truncated = |what: String| SceneError::Truncated { file: file.into(), what };
    let short = || truncated(format!("the header is 12 bytes, found {}", bytes.len()));
    let (version, rest) = number(after_magic).ok_or_else(short)?;
    if version != 2 {
        return Err(SceneError::Version { file: file.into(), found: version.to_string() });
    }
    let (length, _) = number(rest).ok_or_else(short)?;
    let contents = bytes.get(12..length as usize).ok_or_else(|| {
        truncated(format!("the header announces {length} bytes, found {}", bytes.len()))
    })?;
    let chunk = |rest: &'a [u8], kind: &str| -> Result<Chunk<'a>, SceneError> {
        let found = number(rest).and_then(|(length, rest)| {
            let (tag, rest) = rest.split_first_chunk::<4>()?;
            Some((length as usize, *tag, rest))
        });
        let (length, tag, rest) =
            found.ok_or_else(|| truncated(format!("the header of the {kind} chunk is cut")))?;
        let (data, rest) = rest.split_at_checked(length).ok_or_else(|| {
            truncated(format!("the {kind} chunk announces {length} bytes, found {}", rest.len()))
        })?;
        Ok((tag, data, rest))
    };
    let (tag, json, mut rest) = chunk(contents, "JSON")?;
    if &tag != b"JSON" {
        return Err(SceneError::Invalid {
            file: file.into(),
            place: "first chunk".to_owned(),
            reason: format!("its type is `{}`, not `JSON`", tag.escape_ascii()),
        });
    }
    // Chunks of other kinds are to be skipped.
    while !rest.is_empty() {
        let (tag, data, after) = chunk(rest, "binary")?;
        if &tag == b"BIN\0" {
            return Ok(Container { json, binary: Some(data) });
        }
        rest = after;
    }
    Ok(Container { json, binary: None })
}

/// A little-endian number, and what follows it.
fn number(bytes: &[u8]) -> Option<(u32, &[u8])> {
    let (number, rest) = bytes.split_first_chunk::<4>()?;
    Some((u32::from_le_bytes(*number), rest))
}

/// Parses JSON, with the place of what is wrong.
pub(super) fn parse<'a, T: Deserialize<'a>>(file: &Path, json: &'a [u8]) -> Result<T, SceneError> {
    serde_json::from_slice(json).map_err(|error| {
        if error.is_eof() {
            let what = format!("the JSON ends after {} bytes", json.len());
            return SceneError::Truncated { file: file.into(), what };
        }
        SceneError::Json {
            file: file.into(),
            line: error.line(),
            column: error.column(),
            message: error.to_string(),
        }
    })
}

impl Head {
    /// Refuses versions and required extensions that we do not know.
    pub(super) fn check(&self, file: &Path) -> Result<(), SceneError> {
        let version = self.asset.min_version.as_ref().unwrap_or(&self.asset.version);
        let known = match &self.asset.min_version {
            Some(minimum) => minimum == "2.0",
            None => version.starts_with("2."),
        };
        if !known {
            return Err(SceneError::Version { file: file.into(), found: version.clone() });
        }
        let unknown = unsupported(&self.extensions_required);
        if !unknown.is_empty() {
            return Err(SceneError::RequiredExtension {
                file: file.into(),
                names: unknown.join(", "),
                known: SUPPORTED.join(", "),
            });
        }
        Ok(())
    }

    /// The extensions used that are ignored, each with what the picture lacks, where that is known.
    pub(super) fn ignored(&self) -> Vec<String> {
        let mut names = unsupported(&self.extensions_used);
        for name in &mut names {
            if let Some((_, lacks)) = LACKS.iter().find(|(known, _)| known == name) {
                *name = format!("{name}: {lacks}");
            }
        }
        names
    }
}

fn unsupported(names: &[String]) -> Vec<String> {
    names.iter().filter(|name| !SUPPORTED.contains(&name.as_str())).cloned().collect()
}
