//! Compiling in child processes: each has one family, and a driver that crashes takes no more than its process along.
//!
//! A child reads a [`Request`] as JSON from its input and writes a message as JSON to each line of its output.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::cost::Costs;
use crate::error::Error;
use crate::here::{FAMILY, compile_here};
use crate::request::Request;

/// Where Debian's `mesa-vulkan-drivers` describes RADV to Vulkan's loader.
pub const RADEON_ICD: &str = "/usr/share/vulkan/icd.d/radeon_icd.x86_64.json";

/// What of the parent's environment would change figures, or load something else into the process.
const REMOVED: [&str; 9] = [
    "ACO_DEBUG",
    "AMD_DEBUG",
    "RADV_DEBUG",
    "RADV_PERFTEST",
    "RADV_TEX_ANISO",
    "VK_ADD_DRIVER_FILES",
    "VK_INSTANCE_LAYERS",
    "VK_LOADER_LAYERS_ENABLE",
    "LD_PRELOAD",
];

/// The program that calls [`serve`], and how to run it.
#[derive(Clone, Debug)]
pub struct Program {
    /// Its path.
    pub path: PathBuf,
    /// Arguments that make it call [`serve`].
    pub arguments: Vec<String>,
    /// The description of RADV for Vulkan's loader, for example [`RADEON_ICD`].
    pub icd: PathBuf,
    /// Processes at once, at least 1. Figures do not depend on it.
    pub jobs: usize,
    /// The longest that one variant may take.
    pub limit: Duration,
}

#[derive(Serialize, Deserialize)]
enum Message {
    /// This variant is compiled next.
    Next(String),
    Done(Costs),
    Failed(String),
}

/// The child's end: reads a request from standard input, compiles it in this process, and writes what it finds to
/// standard output, errors as well.
///
/// # Errors
///
/// When the request cannot be read or nothing can be written.
pub fn serve() -> Result<(), Error> {
    let pipe = |error: &dyn std::fmt::Display| Error::Pipe(error.to_string());
    let request: Request =
        serde_json::from_reader(std::io::stdin().lock()).map_err(|error| pipe(&error))?;
    let last = match compile_here(&request, |id| drop(say(&Message::Next(id.to_owned())))) {
        Ok(costs) => Message::Done(costs),
        Err(error) => Message::Failed(error.to_string()),
    };
    say(&last).map_err(|error| pipe(&error))
}

fn say(message: &Message) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    serde_json::to_writer(&mut out, message)?;
    out.write_all(b"\n")?;
    out.flush()
}

/// Compiles shaders in child processes.
///
/// # Errors
///
/// When the driver is missing, a module cannot be read, or a child fails, takes too long or ends early.
pub fn compile(program: &Program, request: &Request) -> Result<Costs, Error> {
    if !program.icd.is_file() {
        return Err(Error::Icd(program.icd.clone()));
    }
    // Neighbours take about as long as each other, so they are dealt out in turn.
    let jobs = program.jobs.clamp(1, request.shaders.len().max(1));
    let mut shares = vec![Request { shaders: Vec::new(), ..request.clone() }; jobs];
    for (shader, job) in request.shaders.iter().zip((0..jobs).cycle()) {
        shares[job].shaders.push(shader.clone());
    }
    let results: Vec<Result<Costs, Error>> = thread::scope(|scope| {
        let started: Vec<_> =
            shares.iter().map(|share| scope.spawn(|| one(program, share))).collect();
        started.into_iter().map(|thread| thread.join().unwrap_or_else(|_| Err(lost()))).collect()
    });
    let mut whole: Option<Costs> = None;
    for result in results {
        let costs = result?;
        match &mut whole {
            None => whole = Some(costs),
            Some(whole) if whole.compiler == costs.compiler => {
                whole.costs.extend(costs.costs);
                whole.skipped.extend(costs.skipped);
            }
            Some(_) => return Err(Error::Mixed(request.family.clone())),
        }
    }
    let mut whole = whole.ok_or_else(lost)?;
    whole.sort();
    Ok(whole)
}

fn lost() -> Error {
    Error::Pipe("a thread that reads from it is gone".to_owned())
}

/// Kills the process if it still runs, so that none outlives an error.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        // It may have ended already; then there is nothing to kill.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

/// Runs one child.
fn one(program: &Program, request: &Request) -> Result<Costs, Error> {
    let failed = |source| Error::Child { program: program.path.clone(), source };
    let mut command = Command::new(&program.path);
    command.args(&program.arguments);
    for name in REMOVED {
        command.env_remove(name);
    }
    command
        .env(FAMILY, &request.family)
        .env("VK_ICD_FILENAMES", &program.icd)
        .env("VK_DRIVER_FILES", &program.icd)
        // Figures from a cache could be those of another state of the machine.
        .env("MESA_SHADER_CACHE_DISABLE", "true")
        // Mesa's layer that picks a device would ask a display server.
        .env("NODEVICE_SELECT", "1")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = Killed(command.spawn().map_err(failed)?);
    let (sender, lines) = channel();
    if let Some(out) = child.0.stdout.take() {
        thread::spawn(move || {
            for line in BufReader::new(out).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
    }
    let said = child.0.stderr.take().map(|mut err| {
        thread::spawn(move || {
            let mut all = Vec::new();
            drop(err.read_to_end(&mut all));
            String::from_utf8_lossy(&all).into_owned()
        })
    });
    if let Some(input) = child.0.stdin.take() {
        // A child that has already ended closes the pipe; its own message says more than that.
        drop(serde_json::to_writer(input, request));
    }
    match messages(program, request, &lines)? {
        Ok(costs) => Ok(costs),
        Err(place) => {
            let status = child.0.wait().map_err(failed)?.to_string();
            let said = said.and_then(|thread| thread.join().ok()).unwrap_or_default();
            let said = said.lines().rev().take(3).collect::<Vec<_>>().join(" / ");
            Err(Error::Ended { family: request.family.clone(), status, place, said })
        }
    }
}

/// Reads until the end; the inner error is the place where the child stopped without a last message.
fn messages(
    program: &Program,
    request: &Request,
    lines: &Receiver<String>,
) -> Result<Result<Costs, String>, Error> {
    let mut place = "before the first variant".to_owned();
    loop {
        let line = match lines.recv_timeout(program.limit) {
            Ok(line) => line,
            Err(RecvTimeoutError::Disconnected) => return Ok(Err(place)),
            Err(RecvTimeoutError::Timeout) => {
                let family = request.family.clone();
                return Err(Error::TooLong { family, place, limit: program.limit });
            }
        };
        match serde_json::from_str(&line) {
            Ok(Message::Next(id)) => place = format!("at variant `{id}`"),
            Ok(Message::Done(costs)) => return Ok(Ok(costs)),
            Ok(Message::Failed(error)) => return Err(Error::Reported(error)),
            Err(_) => return Err(Error::Message { program: program.path.clone(), line }),
        }
    }
}
