//! What can go wrong.

use std::path::PathBuf;
use std::time::Duration;

/// Errors of compiling.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A module that is not well-formed. Drivers do not check it and may crash.
    #[error("{}: invalid SPIR-V: {what}", path.display())]
    Spirv {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        what: String,
    },
    /// A module without the requested entry point.
    #[error("{}: no compute entry point `{name}`; it has: {}", path.display(), there.join(", "))]
    NoEntryPoint {
        /// The file.
        path: PathBuf,
        /// The requested one.
        name: String,
        /// Those of the module.
        there: Vec<String>,
    },
    /// A capability for which no device feature is known here.
    #[error("{}: capability {number} is unknown to `capability.rs`", path.display())]
    Capability {
        /// The file.
        path: PathBuf,
        /// Its number in SPIR-V.
        number: u32,
    },
    /// An environment in which this driver cannot compile for the family.
    #[error("{variable} is {found}; it has to be `{right}` when this process starts")]
    Environment {
        /// The variable.
        variable: String,
        /// What it is.
        found: String,
        /// What it has to be.
        right: String,
    },
    /// Vulkan's loader is missing.
    #[error("Vulkan's loader does not load: {0}; Debian has it in `libvulkan1`")]
    Loader(String),
    /// RADV's description is missing.
    #[error("{}: no such file; Debian has it in `mesa-vulkan-drivers`", .0.display())]
    Icd(PathBuf),
    /// A call of Vulkan that failed.
    #[error("{subject}: {call}: {result}")]
    Vulkan {
        /// The variant, or the family.
        subject: String,
        /// The function's name.
        call: &'static str,
        /// Vulkan's result.
        result: ash::vk::Result,
    },
    /// No device of RADV, or one that is not without hardware.
    #[error("family `{family}`: no RADV device without hardware; there are: {}", there.join(", "))]
    NoDevice {
        /// The family.
        family: String,
        /// Names of the devices there are.
        there: Vec<String>,
    },
    /// A compiled pipeline that has not exactly one executable.
    #[error(
        "variant `{id}`: the driver reports {count} executables for a compute pipeline instead of 1"
    )]
    Executables {
        /// The variant.
        id: String,
        /// How many there are.
        count: usize,
    },
    /// Statistics other than those known.
    #[error("variant `{id}`: the driver's statistics {what}; there are: {}", there.join(", "))]
    Statistics {
        /// The variant.
        id: String,
        /// Which one is missing, unknown or no whole number.
        what: String,
        /// Names of all that are there.
        there: Vec<String>,
    },
    /// A driver that does not give its machine code as text.
    #[error("variant `{id}`: no text `Assembly`; there are: {}", there.join(", "))]
    NoAssembly {
        /// The variant.
        id: String,
        /// Names of all that are there.
        there: Vec<String>,
    },
    /// Machine code that is not understood.
    #[error("variant `{id}`: assembly, line {line}: {what}")]
    Assembly {
        /// The variant.
        id: String,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// Machine code of which another number of instructions is read than the compiler counts.
    #[error(
        "variant `{id}`: `assembly.rs` reads {text} instructions, the compiler counts {compiler}"
    )]
    Count {
        /// The variant.
        id: String,
        /// As read.
        text: u64,
        /// As the compiler counts.
        compiler: u64,
    },
    /// A child process that could not be run.
    #[error("{}: {source}", program.display())]
    Child {
        /// The program.
        program: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A line of a child process that is no message.
    #[error("{}: not a message: {line:?}", program.display())]
    Message {
        /// The program.
        program: PathBuf,
        /// The line.
        line: String,
    },
    /// A child process that ended before it was done.
    #[error("family `{family}`: the compiler's process ended ({status}) {place}: {said}")]
    Ended {
        /// The family.
        family: String,
        /// Its exit status.
        status: String,
        /// At which variant.
        place: String,
        /// The end of what it wrote to stderr.
        said: String,
    },
    /// A variant that takes too long.
    #[error("family `{family}`: {place}: not compiled within {limit:?}")]
    TooLong {
        /// The family.
        family: String,
        /// At which variant.
        place: String,
        /// The limit for one variant.
        limit: Duration,
    },
    /// What a child process found wrong.
    #[error("{0}")]
    Reported(String),
    /// Children that use different drivers, which a change of the installation in between can cause.
    #[error("family `{0}`: the processes used different drivers; run it again")]
    Mixed(String),
    /// Input or output of the child's own end.
    #[error("the request's pipe: {0}")]
    Pipe(String),
}
