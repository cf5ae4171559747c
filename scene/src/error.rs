//! Why a scene cannot be loaded.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Why a scene cannot be loaded: the file, the thing in it that is at fault, and what would do.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Neither a file nor a built-in scene has this name.
    #[error("no built-in scene and no file is named `{name}`; the built-in scenes are {known}")]
    UnknownBuiltin {
        /// The name as given.
        name: String,
        /// The known names.
        known: String,
    },
    /// The number behind a built-in scene's name cannot be met.
    #[error("built-in scene `{name}`: {reason}")]
    Detail {
        /// The name as given.
        name: String,
        /// What is wrong with its number.
        reason: String,
    },
    /// There is no such file.
    #[error("{}: no such file", .file.display())]
    Missing {
        /// The path as given, or as the referring file has it.
        file: PathBuf,
    },
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}", .file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A device, a pipe or a folder.
    #[error("{}: is not a regular file", .file.display())]
    NotRegular {
        /// The file.
        file: PathBuf,
    },
    /// A file is larger than it may be.
    #[error("{}: has {bytes} bytes, more than the limit of {limit}", .file.display())]
    TooLarge {
        /// The file.
        file: PathBuf,
        /// Its length, or what was read of it.
        bytes: u64,
        /// [`super::Limits::file_bytes`].
        limit: u64,
    },
    /// A scene takes more than it may.
    #[error("{}: the scene has {needed} {what}, more than the limit of {limit}", .file.display())]
    TooMuch {
        /// The file.
        file: PathBuf,
        /// What there is too much of.
        what: &'static str,
        /// How much the scene takes, as far as it was counted.
        needed: usize,
        /// One of [`super::Limits`].
        limit: usize,
    },
    /// A scene refers to a file outside of its folder.
    #[error("{}: `{name}` lies outside of the scene's folder; move it there, or allow it (`--allow-outside`)", .file.display())]
    Outside {
        /// The file.
        file: PathBuf,
        /// The name of what it refers to.
        name: String,
    },
    /// No reader for files of this kind.
    #[error("{}: unsupported file extension `{found}`; supported are {known}", .file.display())]
    Extension {
        /// The file.
        file: PathBuf,
        /// Its extension in lower case.
        found: String,
        /// The known extensions.
        known: String,
    },
    /// The file ends before what it announces.
    #[error("{}: truncated: {what}", .file.display())]
    Truncated {
        /// The file, or the buffer's file.
        file: PathBuf,
        /// What is too short, with expected and found length.
        what: String,
    },
    /// A glTF version other than 2.
    #[error("{}: glTF version {found} is not supported; supported is 2.0", .file.display())]
    Version {
        /// The file.
        file: PathBuf,
        /// The version found.
        found: String,
    },
    /// The JSON of a glTF file is malformed.
    #[error("{}:{line}:{column}: {message}", .file.display())]
    Json {
        /// The file.
        file: PathBuf,
        /// One-based, within the JSON.
        line: usize,
        /// One-based, within the JSON.
        column: usize,
        /// What is wrong.
        message: String,
    },
    /// The file requires extensions that are not supported.
    #[error("{}: required extension {names} is not supported; supported are {known}", .file.display())]
    RequiredExtension {
        /// The file.
        file: PathBuf,
        /// The unsupported ones.
        names: String,
        /// The supported ones.
        known: String,
    },
    /// The structure of a glTF file is not valid.
    #[error("{}: {place}: {reason}", .file.display())]
    Invalid {
        /// The file.
        file: PathBuf,
        /// Where in the JSON, such as `meshes[0].primitives[1]`.
        place: String,
        /// What is wrong.
        reason: String,
    },
    /// The data of an accessor cannot be used.
    #[error("{}: {mesh}: accessor {accessor} ({semantic}): {reason}", .file.display())]
    Accessor {
        /// The file.
        file: PathBuf,
        /// The mesh that uses it.
        mesh: String,
        /// The accessor's index.
        accessor: usize,
        /// What the mesh uses it for.
        semantic: String,
        /// What is wrong.
        reason: String,
    },
    /// An image does not decode.
    #[error("{}: image `{image}`: {reason}", .file.display())]
    Image {
        /// The file that uses the image.
        file: PathBuf,
        /// The image's file name, name or index.
        image: String,
        /// What is wrong.
        reason: String,
    },
    /// A line of an OBJ or MTL file cannot be read.
    #[error("{}:{line}:{column}: {message}", .file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// One-based.
        line: usize,
        /// One-based, in characters.
        column: usize,
        /// What is wrong, and what would be right.
        message: String,
    },
    /// A position is NaN or infinite.
    #[error("{}: mesh `{mesh}`: vertex {vertex} has the position {position:?}; positions must be finite, in 32 bits as well", .file.display())]
    NonFinite {
        /// The file.
        file: PathBuf,
        /// The mesh.
        mesh: String,
        /// The vertex's index within the mesh.
        vertex: usize,
        /// The position in the file's space.
        position: [f64; 3],
    },
    /// Nothing to draw.
    #[error("{}: the scene has no triangles", .file.display())]
    NoTriangles {
        /// The file.
        file: PathBuf,
    },
    /// A light that lights nothing.
    #[error("{}: light `{light}` has zero power; give it a positive colour and intensity, or remove it", .file.display())]
    ZeroPower {
        /// The file.
        file: PathBuf,
        /// The light.
        light: String,
    },
    /// A light out of range.
    #[error("{}: light `{light}`: {reason}", .file.display())]
    Light {
        /// The file.
        file: PathBuf,
        /// The light.
        light: String,
        /// What is wrong.
        reason: String,
    },
    /// A camera out of range.
    #[error("{}: camera: {reason}", .file.display())]
    Camera {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A sidecar is malformed.
    #[error("{}:{line}:{column}: {message}", .file.display())]
    Sidecar {
        /// The sidecar.
        file: PathBuf,
        /// One-based.
        line: usize,
        /// One-based.
        column: usize,
        /// What is wrong, with the known keys where a key is unknown.
        message: String,
    },
    /// Several faults at once, each on its line.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Several(Vec<SceneError>),
}

impl SceneError {
    /// What is wrong, without the file.
    pub(super) fn reason(&self) -> String {
        match self {
            Self::ZeroPower { light, .. } => format!("light `{light}` has zero power"),
            Self::Light { light, reason, .. } => format!("light `{light}`: {reason}"),
            Self::Camera { reason, .. } => format!("camera: {reason}"),
            other => other.to_string(),
        }
    }

    /// One fault as itself, several as [`SceneError::Several`].
    pub(super) fn of(mut faults: Vec<Self>) -> Self {
        if faults.len() == 1 { faults.remove(0) } else { Self::Several(faults) }
    }
}
