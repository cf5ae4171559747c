//! Mutations of inputs with a fixed seed, for tests that nothing panics, runs long or takes much memory: on a stable compiler,
//! in the test suite, for a number of mutations, or for the duration of `cargo xtask fuzz`.
//!
//! A target is a test of the crate that reads the input: it has a corpus, a dictionary of its format, and a function that
//! takes an input. It caps its own allocations. An input that fails stays in a file, also where it ends the process, and
//! becomes part of the corpus or a test of its own.

mod mutate;

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

pub use mutate::{Random, mutated};

/// The maximum time for one input, in a debug build on a busy machine.
pub const MAXIMUM_TIME: Duration = Duration::from_secs(10);

/// The maximum memory in bytes while one input is read.
pub const MAXIMUM_MEMORY: usize = 2 << 30;

/// The maximum size of an input in bytes: longer mutations are left out.
pub const MAXIMUM_SIZE: usize = 64 << 10;

/// An input without a mutation.
#[derive(Clone, Debug)]
pub struct Case {
    /// The name of its file.
    pub name: String,
    /// What it is.
    pub bytes: Vec<u8>,
}

/// The files of a folder by name; those in folders below it too, with the folder in their name.
#[must_use]
pub fn corpus(folder: &Path) -> Vec<Case> {
    let mut found = Vec::new();
    let mut pending = vec![folder.to_owned()];
    while let Some(next) = pending.pop() {
        for path in fs::read_dir(next).into_iter().flatten().flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                pending.push(path);
            } else if let (Ok(bytes), Ok(name)) = (fs::read(&path), path.strip_prefix(folder)) {
                found.push(Case { name: name.to_string_lossy().replace('\\', "/"), bytes });
            }
        }
    }
    found.sort_by(|a, b| a.name.cmp(&b.name));
    found
}

/// What was tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tried {
    /// Inputs that were refused.
    pub refused: u64,
    /// Inputs that were taken.
    pub taken: u64,
}

/// A target: how often and how long inputs are mutated.
#[derive(Clone, Debug)]
pub struct Target {
    name: &'static str,
    mutations: u64,
    seed: u64,
    until: Option<Instant>,
}

fn setting(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

impl Target {
    /// A target that mutates each of its inputs so many times. `SGLOW_MUTATIONS` is another number, `SGLOW_SEED` another
    /// start, and with `SGLOW_FUZZ_SECONDS` it goes on for so long instead.
    #[must_use]
    pub fn new(name: &'static str, mutations: u64) -> Self {
        let seconds = setting("SGLOW_FUZZ_SECONDS").map(Duration::from_secs);
        Self {
            name,
            mutations: setting("SGLOW_MUTATIONS").unwrap_or(mutations),
            seed: setting("SGLOW_SEED").unwrap_or(1),
            until: seconds.map(|seconds| Instant::now() + seconds),
        }
    }

    /// The folder for inputs that fail.
    fn folder() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/fuzz")
    }

    /// Runs `work` on each case, as it is and mutated; `work` returns whether it accepted the input.
    ///
    /// # Panics
    ///
    /// When `work` panics, or takes longer than [`MAXIMUM_TIME`]; the message names the file that has the input then.
    pub fn run(&self, cases: &[Case], words: &[&[u8]], work: impl Fn(&Case) -> bool) -> Tried {
        let file = Self::folder().join(format!("{}.input", self.name));
        let _ = fs::create_dir_all(Self::folder());
        let started = Mutex::new(Instant::now());
        let done = AtomicBool::new(false);
        let start = || started.lock().map_or_else(|error| *error.into_inner(), |start| *start);
        thread::scope(|scope| {
            // A hang cannot be unwound.
            scope.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    thread::sleep(Duration::from_millis(20));
                    if start().elapsed() > 6 * MAXIMUM_TIME {
                        eprintln!("{}: does not end: {}", self.name, file.display());
                        std::process::abort();
                    }
                }
            });
            let all =
                catch_unwind(AssertUnwindSafe(|| self.all(cases, words, &work, &file, &started)));
            done.store(true, Ordering::Relaxed);
            match all {
                Ok(tried) => {
                    let _ = fs::remove_file(&file);
                    tried
                }
                Err(panic) => std::panic::resume_unwind(panic),
            }
        })
    }

    /// The same with the lines of a text that begin with `cargo`, as cases.
    ///
    /// # Panics
    ///
    /// As [`Self::run`].
    pub fn lines(&self, text: &str, work: impl Fn(&str) -> bool) -> Tried {
        let lines = text.lines().map(str::trim).filter(|line| line.starts_with("cargo "));
        let case = |line: &str| Case { name: line.to_owned(), bytes: line.as_bytes().to_vec() };
        let words: [&[u8]; 7] = [b" --", b"=", b" - ", b"x", b"--set ", b"--size ", b"--json "];
        let cases: Vec<Case> = lines.map(case).collect();
        self.run(&cases, &words, |case| work(&String::from_utf8_lossy(&case.bytes)))
    }

    fn all(
        &self,
        cases: &[Case],
        words: &[&[u8]],
        work: &impl Fn(&Case) -> bool,
        file: &Path,
        started: &Mutex<Instant>,
    ) -> Tried {
        let mut tried = Tried::default();
        assert!(!cases.is_empty(), "{}: there is no corpus", self.name);
        for mutation in 0.. {
            for (number, case) in cases.iter().enumerate() {
                let over =
                    self.until.map_or(mutation > self.mutations, |end| Instant::now() >= end);
                if over {
                    println!("{}: {} refused, {} taken", self.name, tried.refused, tried.taken);
                    return tried;
                }
                // An odd factor keeps all bits of the seed.
                let stream = self.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)
                    ^ ((number as u64) << 32)
                    ^ mutation;
                let bytes = match mutation {
                    0 => case.bytes.clone(),
                    _ => mutated(&case.bytes, words, &mut Random(stream)),
                };
                if bytes.len() > MAXIMUM_SIZE {
                    continue;
                }
                // A file that is written over is flushed by some systems; a new one is not.
                let _ = fs::remove_file(file);
                let _ = fs::write(file, &bytes);
                let input = Case { name: case.name.clone(), bytes };
                if let Ok(mut started) = started.lock() {
                    *started = Instant::now();
                }
                let begin = Instant::now();
                let taken = catch_unwind(AssertUnwindSafe(|| work(&input)));
                let time = begin.elapsed();
                let at = || {
                    let (name, seed) = (&case.name, self.seed);
                    format!(
                        "{}: {name}, mutation {mutation} of seed {seed}: {}",
                        self.name,
                        file.display()
                    )
                };
                assert!(taken.is_ok(), "panics: {}", at());
                assert!(time < MAXIMUM_TIME, "runs long: {}", at());
                let taken = taken.unwrap_or_default();
                *(if taken { &mut tried.taken } else { &mut tried.refused }) += 1;
            }
        }
        tried
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cases() -> Vec<Case> {
        vec![Case { name: "a".to_owned(), bytes: b"[1, 2, 3]".to_vec() }]
    }

    fn target(name: &'static str) -> Target {
        Target { name, mutations: 200, seed: 1, until: None }
    }

    #[test]
    fn every_input_is_tried_as_it_is_and_mutated_and_the_same_each_time() {
        let seen = |name| {
            let all = Mutex::new(Vec::new());
            let tried = target(name).run(&cases(), &[b"999"], |case| {
                all.lock().unwrap().push(case.bytes.clone());
                case.bytes.starts_with(b"[")
            });
            (tried, all.into_inner().unwrap())
        };
        let (tried, all) = seen("same");
        assert_eq!(tried.refused + tried.taken, 201);
        assert!(tried.refused > 10 && tried.taken > 10, "{tried:?}");
        assert_eq!(all[0], b"[1, 2, 3]");
        assert!(all.iter().any(|bytes| bytes.windows(3).any(|part| part == b"999")));
        assert_eq!(seen("again").1, all);
    }

    #[test]
    fn what_panics_is_kept() {
        let failed = catch_unwind(|| {
            target("kept").run(&cases(), &[], |case| {
                assert!(!case.bytes.is_empty(), "empty");
                true
            })
        });
        let text = *failed.unwrap_err().downcast::<String>().unwrap();
        assert!(text.contains("panics: kept: a, mutation"), "{text}");
        assert_eq!(fs::read(Target::folder().join("kept.input")).unwrap(), b"");
    }
}
