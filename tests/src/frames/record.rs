//! The form of the snapshot: what was computed on which machine, one line for each output of each frame.

use std::collections::BTreeMap;
use std::fmt;

use sglow_renderer::device::AdapterFacts;
use sha2::{Digest, Sha256};

/// One output of one frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    key: (String, u32, String),
    /// The first 64 bits of the SHA-256 of the output's bytes.
    hash: u64,
    /// Readable numbers, in full precision.
    numbers: Vec<(String, f64)>,
}

impl Entry {
    pub(super) fn new(
        name: &str,
        frame: u32,
        output: &str,
        bytes: &[u8],
        numbers: Vec<(&str, f64)>,
    ) -> Self {
        let digest: [u8; 32] = Sha256::digest(bytes).into();
        let numbers = numbers.into_iter().map(|(name, number)| (name.to_owned(), number));
        Self {
            key: (name.to_owned(), frame, output.to_owned()),
            hash: u64::from_be_bytes(digest.as_chunks::<8>().0[0]),
            numbers: numbers.collect(),
        }
    }

    /// The entry of a line.
    fn read(line: &str) -> Option<Self> {
        let fields: Vec<&str> = line.split(" | ").collect();
        let [name, frame, output, hash, numbers] = fields.as_slice() else { return None };
        let number = |text: &str| {
            let (name, number) = text.split_once('=')?;
            Some((name.to_owned(), number.parse().ok()?))
        };
        Some(Self {
            key: ((*name).to_owned(), frame.parse().ok()?, (*output).to_owned()),
            hash: u64::from_str_radix(hash, 16).ok()?,
            numbers: numbers.split_whitespace().map(number).collect::<Option<_>>()?,
        })
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { key: (name, frame, output), hash, numbers } = self;
        write!(out, "{name} | {frame} | {output} | {hash:016x} |")?;
        // The shortest decimal that is read back as the same f64: nothing of it is lost.
        numbers.iter().try_for_each(|(name, number)| write!(out, " {name}={number:e}"))
    }
}

/// What bits depend on beside the shaders: another of these may round otherwise.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Machine {
    /// The adapter; of lavapipe the name has LLVM's version and the width of vectors.
    pub(super) adapter: String,
    /// The driver with its version.
    pub(super) driver: String,
    /// What compiles for this processor, and the C library's own functions, choose by.
    pub(super) processor: String,
}

impl Machine {
    pub(super) fn of(adapter: &AdapterFacts) -> Self {
        Self {
            adapter: adapter.name.clone(),
            driver: adapter.driver.clone(),
            processor: processor(),
        }
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { adapter, driver, processor } = self;
        write!(out, "adapter: {adapter}\ndriver: {driver}\nprocessor: {processor}")
    }
}

/// The architecture, the maker and the vector units.
fn processor() -> String {
    let maker = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("vendor_id"))?;
        Some(line.split_once(": ")?.1.to_owned())
    });
    let maker = maker.unwrap_or_else(|| "unknown".to_owned());
    format!("{}, {maker}{}", std::env::consts::ARCH, features())
}

#[cfg(target_arch = "x86_64")]
fn features() -> String {
    let known = [
        ("sse4.1", std::is_x86_feature_detected!("sse4.1")),
        ("avx", std::is_x86_feature_detected!("avx")),
        ("avx2", std::is_x86_feature_detected!("avx2")),
        ("fma", std::is_x86_feature_detected!("fma")),
        ("f16c", std::is_x86_feature_detected!("f16c")),
        ("avx512f", std::is_x86_feature_detected!("avx512f")),
    ];
    known.iter().filter(|(_, has)| *has).map(|(name, _)| format!(" {name}")).collect()
}

#[cfg(not(target_arch = "x86_64"))]
fn features() -> String {
    String::new()
}

/// All frames of one machine.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Recording {
    machine: Machine,
    entries: BTreeMap<(String, u32, String), Entry>,
}

/// How far a readable number may be off on another machine, over the largest number of its output.
///
/// Rounding moves most of them by 1e-6. More comes from what it decides: which cluster a texel goes to, what a pixel at an
/// edge shows, whether a texel of a light's map is nearer than a receiver. With the light nudged by some ten units in the
/// last place, of all outputs half move by less than 1.1e-6, 99 % by less than 1.5e-4 and one by 4.8e-3 (the configurations
/// that move most are run so by `rounding_otherwise_stays_within_the_tolerance`); this is four times that. What changes
/// numbers by less, bits alone show.
pub(super) const TOLERANCE: f64 = 0.02;

/// What two recordings differ in.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Differences {
    /// How many outputs both have.
    pub(super) compared: usize,
    /// Whether bits can be compared.
    pub(super) same_machine: bool,
    /// What only one of them has.
    pub(super) unmatched: Vec<String>,
    /// Outputs with other bits, each with the largest difference of a number over the largest number of the output.
    pub(super) other_bits: Vec<(String, f64)>,
}

impl Differences {
    /// What is wrong, if anything: any other bit on the same machine, and numbers out of tolerance on another.
    pub(super) fn faults(&self) -> Vec<String> {
        let mut faults = self.unmatched.clone();
        let counts = |off: f64| self.same_machine || off.is_nan() || off > TOLERANCE;
        let bits = self.other_bits.iter().filter(|(_, off)| counts(*off));
        faults.extend(bits.map(|(output, off)| format!("{output}: numbers are off by {off:.1e}")));
        if self.compared == 0 {
            faults.push("nothing was compared".to_owned());
        }
        faults
    }

    /// What was compared, and how.
    pub(super) fn summary(&self) -> String {
        let worst = self.other_bits.iter().map(|(_, off)| *off).fold(0.0, f64::max);
        let how = if self.same_machine {
            "this machine made the snapshot, so every bit has to be the same".to_owned()
        } else {
            format!(
                "another machine made the snapshot, so BITS CANNOT BE COMPARED HERE; numbers are compared within {TOLERANCE}"
            )
        };
        format!(
            "{how}: {} outputs compared, {} with other bits, numbers off by at most {worst:.1e}, {} without a counterpart",
            self.compared,
            self.other_bits.len(),
            self.unmatched.len()
        )
    }
}

const HEADER: &str = "\
Frames as they are: configuration | frame | output | first 64 bits of the SHA-256 of its bytes | numbers.
Of pictures the numbers are means: of each channel, of all three in the left and in the upper half over the whole
picture. Of lights: the sum of their power's luminance; by it, their mean position and standard deviation.
Of chains: the means of x, y and x y. Numbers are the shortest decimals that give the same f64.
Bits are those of this machine alone:";

impl Recording {
    pub(super) fn new(machine: Machine, entries: impl IntoIterator<Item = Entry>) -> Self {
        let mut kept = BTreeMap::new();
        for entry in entries {
            if let Some(other) = kept.insert(entry.key.clone(), entry.clone()) {
                assert_eq!(other, entry, "two different outputs have one name");
            }
        }
        Self { machine, entries: kept }
    }

    pub(super) fn machine(&self) -> &Machine {
        &self.machine
    }

    /// The same as if it came from another machine.
    pub(super) fn on(self, machine: Machine) -> Self {
        Self { machine, ..self }
    }

    /// That numbers are finite, that there is light in every picture but where it is dark, and that frames in a row
    /// differ.
    pub(super) fn assert_says_something(&self) {
        let lit = |(name, frame, _): &(String, u32, String), output: &str| {
            let entry = self.entries.get(&(name.clone(), *frame, output.to_owned()));
            entry.is_some_and(|entry| entry.numbers.iter().any(|(_, number)| *number > 0.0))
        };
        for (key, entry) in &self.entries {
            assert!(entry.numbers.iter().all(|(_, number)| number.is_finite()), "{entry}");
            let (name, frame, output) = key;
            if name.starts_with("dark") {
                assert!(!lit(key, "radiance") && !lit(key, "lights"), "{entry}");
                continue;
            }
            match output.as_str() {
                // One of the two: metal reflects nothing diffusely.
                "diffuse" | "specular" => {
                    assert!(lit(key, "diffuse") || lit(key, "specular"), "{entry}")
                }
                "violations" | "emission" | "direct" => {}
                "light map" if name.contains("light away") => assert!(!lit(key, output), "{entry}"),
                _ => assert!(lit(key, output), "{entry}"),
            }
            let next = self.entries.get(&(name.clone(), frame + 1, output.clone()));
            if let Some(next) = next.filter(|_| output != "emission" && lit(key, output)) {
                assert_ne!(entry.hash, next.hash, "{entry}: the next frame is the same");
            }
        }
    }

    /// A recording from its text.
    pub(super) fn read(text: &str) -> Option<Self> {
        let (_, text) = text.split_once(HEADER)?;
        let mut lines = text.trim().lines();
        let mut field = |name: &str| Some(lines.next()?.strip_prefix(name)?.to_owned());
        let machine = Machine {
            adapter: field("adapter: ")?,
            driver: field("driver: ")?,
            processor: field("processor: ")?,
        };
        let entries = lines.filter(|line| !line.is_empty()).map(Entry::read);
        Some(Self::new(machine, entries.collect::<Option<Vec<_>>>()?))
    }

    /// What differs from this one to another.
    pub(super) fn differences(&self, other: &Self) -> Differences {
        let mut differences =
            Differences { same_machine: self.machine == other.machine, ..Default::default() };
        let name = |(name, frame, output): &(String, u32, String)| {
            format!("{name}, frame {frame}, {output}")
        };
        for (key, entry) in &self.entries {
            let Some(found) = other.entries.get(key) else {
                differences.unmatched.push(format!("{} is missing", name(key)));
                continue;
            };
            differences.compared += 1;
            if found != entry {
                differences.other_bits.push((name(key), off(&entry.numbers, &found.numbers)));
            }
        }
        let new = other.entries.keys().filter(|key| !self.entries.contains_key(*key));
        differences.unmatched.extend(new.map(|key| format!("{} is new", name(key))));
        differences
    }
}

/// The largest difference of a number over the largest number; infinite if they are not of the same things.
fn off(expected: &[(String, f64)], found: &[(String, f64)]) -> f64 {
    if !expected.iter().map(|(name, _)| name).eq(found.iter().map(|(name, _)| name)) {
        return f64::INFINITY;
    }
    let largest = expected.iter().map(|(_, number)| number.abs()).fold(f64::MIN_POSITIVE, f64::max);
    let differences = expected.iter().zip(found).map(|((_, a), (_, b))| match (a - b).abs() {
        difference if difference.is_nan() => f64::INFINITY,
        difference => difference / largest,
    });
    differences.fold(0.0, f64::max)
}

impl fmt::Display for Recording {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "{HEADER}\n{}\n", self.machine)?;
        self.entries.values().try_for_each(|entry| writeln!(out, "{entry}"))
    }
}
