//! Buffers and buffer views: bytes from the binary chunk, data URIs, files, and compressed views.

use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::json;
use gltf::json::validation::Validate;
use percent_encoding::percent_decode_str;
use serde::Deserialize;

use super::meshopt::{self, Filter, Mode};
use crate::SceneError;
use crate::files::Files;

/// The extension of compressed buffer views.
const COMPRESSION: &str = "EXT_meshopt_compression";

/// The bytes of each buffer view. What is wrong with one is an error where it is used: a file is not refused for a
/// buffer or a view that nothing on the picture needs.
pub(super) struct Views<'a> {
    buffers: Vec<Result<Cow<'a, [u8]>, String>>,
    views: Vec<Result<View, String>>,
}

/// Where a view's bytes are: views may overlap, so that copies could take more than the file.
enum View {
    Part { buffer: usize, range: Range<usize> },
    Decoded(Vec<u8>),
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Compression {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: usize,
    count: usize,
    mode: Mode,
    #[serde(default)]
    filter: Filter,
}

impl<'a> Views<'a> {
    /// Reads the buffers and cuts them into views.
    pub(super) fn load(files: &Files<'_>, root: &json::Root, binary: Option<&'a [u8]>) -> Self {
        let buffers = root.buffers.iter().enumerate();
        let load = |(index, buffer)| load_buffer(files, index, buffer, binary);
        let buffers = buffers.map(|one| load(one).map_err(|fault| fault.to_string())).collect();
        let mut views = Self { buffers, views: Vec::with_capacity(root.buffer_views.len()) };
        let mut left = files.options.limits.file_bytes;
        for (index, view) in root.buffer_views.iter().enumerate() {
            let read = views.read(view, &mut left);
            views.views.push(read.map_err(|reason| format!("bufferViews[{index}]{reason}")));
        }
        views
    }

    /// The bytes of a view.
    pub(super) fn get(&self, index: usize) -> Result<&[u8], String> {
        match self.views.get(index) {
            Some(Ok(View::Part { buffer, range })) => self.cut(*buffer, range.clone()),
            Some(Ok(View::Decoded(bytes))) => Ok(bytes),
            Some(Err(reason)) => Err(reason.clone()),
            None => Err(format!("there is no buffer view {index}")),
        }
    }

    /// A part of a buffer.
    fn cut(&self, buffer: usize, range: Range<usize>) -> Result<&[u8], String> {
        let bytes =
            self.buffers.get(buffer).ok_or_else(|| format!("there is no buffer {buffer}"))?;
        let bytes = bytes.as_ref().map_err(String::clone)?;
        let end = range.end;
        bytes.get(range).ok_or_else(|| {
            format!("ends at byte {end} of buffer {buffer}, which has {}", bytes.len())
        })
    }

    /// Decodes a compressed view, and checks another one. `left` is what decoded ones may still take. The error comes
    /// with the place in the view.
    fn read(&self, view: &json::buffer::View, left: &mut u64) -> Result<View, String> {
        let extension = view.extensions.as_ref().and_then(|e| e.others.get(COMPRESSION));
        let length = view.byte_length.0 as usize;
        let Some(extension) = extension else {
            let offset = view.byte_offset.map_or(0, |offset| offset.0 as usize);
            let (buffer, range) = (view.buffer.value(), offset..offset.saturating_add(length));
            self.cut(buffer, range.clone()).map_err(|reason| format!(": {reason}"))?;
            return Ok(View::Part { buffer, range });
        };
        let at_extension = |reason: String| format!(".extensions.{COMPRESSION}: {reason}");
        let decoded = Compression::deserialize(extension).map_err(|error| error.to_string());
        let decoded = decoded.and_then(|c| {
            let range = c.byte_offset..c.byte_offset.saturating_add(c.byte_length);
            let data = self.cut(c.buffer, range)?;
            if c.count.checked_mul(c.byte_stride) != Some(length) {
                return Err(format!(
                    "decodes to {} elements of {} bytes, the view has {length} bytes",
                    c.count, c.byte_stride
                ));
            }
            *left = left.checked_sub(length as u64).ok_or_else(|| {
                format!("decodes to {length} bytes, of which the limit leaves {left}")
            })?;
            let decoded = meshopt::decode(data, c.mode, c.filter, c.count, c.byte_stride)?;
            if decoded.len() != length {
                return Err(format!("decodes to {} bytes, the view has {length}", decoded.len()));
            }
            Ok(View::Decoded(decoded))
        });
        decoded.map_err(at_extension)
    }
}

fn load_buffer<'a>(
    files: &Files<'_>,
    index: usize,
    buffer: &json::Buffer,
    binary: Option<&'a [u8]>,
) -> Result<Cow<'a, [u8]>, SceneError> {
    let (from, bytes) = match &buffer.uri {
        Some(uri) => read_uri(files, uri)?,
        None => match binary {
            Some(binary) if index == 0 => (files.scene.into(), Cow::Borrowed(binary)),
            // A placeholder: every view of it is compressed, or will be found out of range.
            _ => return Ok(Cow::Borrowed(&[])),
        },
    };
    let length = buffer.byte_length.0;
    if (bytes.len() as u64) < length {
        return Err(SceneError::Truncated {
            file: from,
            what: format!("buffer {index} announces {length} bytes, found {}", bytes.len()),
        });
    }
    Ok(bytes)
}

/// The bytes behind a URI, and the file they came from.
pub(super) fn read_uri(
    files: &Files<'_>,
    uri: &str,
) -> Result<(PathBuf, Cow<'static, [u8]>), SceneError> {
    let file = files.scene;
    let invalid = |reason: String| SceneError::Invalid {
        file: file.into(),
        place: format!("uri `{}`", uri.chars().take(60).collect::<String>()),
        reason,
    };
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, payload) = data
            .split_once(";base64,")
            .ok_or_else(|| invalid("a data URI must be encoded as base64".to_owned()))?;
        let bytes = STANDARD.decode(payload).map_err(|error| invalid(error.to_string()))?;
        return Ok((file.into(), Cow::Owned(bytes)));
    }
    if uri.contains("://") {
        return Err(invalid("only data URIs and relative paths are read".to_owned()));
    }
    let relative = percent_decode_str(uri).decode_utf8_lossy();
    let (path, bytes) = files.read(&relative)?;
    Ok((path, Cow::Owned(bytes)))
}

/// Checks all indices and required properties, so that nothing later meets a dangling one.
pub(super) fn validate(file: &Path, root: &json::Root) -> Result<(), SceneError> {
    let mut faults = Vec::new();
    let mut fault = |place: String, reason: &str| {
        faults.push(SceneError::Invalid { file: file.into(), place, reason: reason.to_owned() });
    };
    // Validating a primitive looks at its positions before it knows whether they are there.
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            for accessor in primitive.attributes.values() {
                if accessor.value() >= root.accessors.len() {
                    let place = format!("meshes[{m}].primitives[{p}].attributes");
                    fault(place, &format!("there is no accessor {}", accessor.value()));
                }
            }
        }
    }
    if faults.is_empty() {
        root.validate(root, json::Path::new, &mut |path, error| {
            let place = path().to_string();
            use json::validation::Error::{
                IndexOutOfBounds, Invalid, Missing, Oversize, Unsupported,
            };
            let reason = match error {
                IndexOutOfBounds => "the index is out of range",
                Invalid => "the value is not valid",
                Missing if place.ends_with(".min") || place.ends_with(".max") => return,
                // An accessor without data is one of zeros. [glTF 2.0, section 3.6.2.1]
                Missing if place.starts_with("accessors") && place.ends_with("].bufferView") => {
                    return;
                }
                Missing => "is missing",
                Oversize => "is too large for this machine",
                // Checked before, with names.
                Unsupported => return,
            };
            faults.push(SceneError::Invalid {
                file: file.into(),
                place,
                reason: reason.to_owned(),
            });
        });
    }
    if faults.is_empty() { Ok(()) } else { Err(SceneError::of(faults)) }
}
