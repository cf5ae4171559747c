//! What generation costs beside what naga costs: the whole matrix of a library, made from its sources, against naga's
//! own parsing, validation and SPIR-V writing of the finished texts, both on all cores, alternately, in one run.
//!
//! `SGLOW_LIBRARY` names the library, `SGLOW_BENCH_OUT` the JSON that is written.

use std::collections::BTreeSet;
use std::error::Error;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use std::{env, fs, process};

use naga::back::{pipeline_constants::process_overrides, spv};
use naga::valid::ModuleInfo;
use rayon::prelude::*;
use serde_json::json;
use sglow_shader_gen::generate;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::matrix::Variant;
use sglow_shader_gen::prune::Whole;
use sglow_shader_gen::validate::validator;

/// Generation may cost this many times what naga costs.
const BOUND: f64 = 1.5;
const ROUNDS: usize = 11;

fn main() {
    match run() {
        Ok(true) => {}
        Ok(false) => process::exit(1),
        Err(error) => {
            eprintln!("{error}");
            process::exit(2);
        }
    }
}

fn run() -> Result<bool, Box<dyn Error>> {
    let root = library_path();
    let library = Library::load(&root)?;
    let variants = library.variants();
    let finished: Vec<(String, BTreeSet<&str>)> = generate::variants(&library, &variants)?
        .into_iter()
        .map(|one| (one.text, library.requires(&one.variant)))
        .collect();
    let mut generation = Vec::new();
    let mut modules = Vec::new();
    let mut naga_alone = Vec::new();
    for round in 0..=ROUNDS {
        let ours = time(|| generate_all(&library, &variants, Whole::Imports));
        let whole = time(|| generate_all(&library, &variants, Whole::Modules));
        let floor = time(|| {
            finished.par_iter().for_each(|(text, requires)| read_and_write(text, requires))
        });
        // The first round warms up.
        if round > 0 {
            generation.push(ours);
            modules.push(whole);
            naga_alone.push(floor);
        }
    }
    let (ours, floor) = (median(&mut generation), median(&mut naga_alone));
    let against_modules = median(&mut modules) / floor;
    let ratio = ours / floor;
    let holds = ratio <= BOUND;
    println!(
        "{}: {} variants on {} threads",
        root.display(),
        variants.len(),
        rayon::current_num_threads()
    );
    println!("generation  {:8.2} ms (median of {ROUNDS}, {})", ours * 1e3, spread(&generation));
    println!("naga alone  {:8.2} ms (median of {ROUNDS}, {})", floor * 1e3, spread(&naga_alone));
    println!(
        "ratio       {ratio:8.3}    (bound {BOUND}: {})",
        if holds { "holds" } else { "does not hold" }
    );
    println!("ratio       {against_modules:8.3}    (compared with whole modules; no bound)");
    let report = json!({
        "adapter": null,
        "driver": null,
        "versions": { "sglow-shader-gen": env!("CARGO_PKG_VERSION") },
        "date": date(),
        "checks": [{
            "name": "generation of the whole matrix over naga's parse, validate and SPIR-V write of the finished texts",
            "value": ratio,
            "unit": "ratio of medians",
            "bound": BOUND,
            "holds": holds,
            "command": "cargo bench -p sglow-shader-gen --bench generation",
            "note": format!(
                "{} variants, {} threads, {ROUNDS} rounds; generation {:.3} ms, naga alone {:.3} ms; reading the files is not in it; compared with whole modules the ratio is {against_modules:.3}",
                variants.len(), rayon::current_num_threads(), ours * 1e3, floor * 1e3,
            ),
        }],
    });
    let out = env::var_os("SGLOW_BENCH_OUT").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../out/generation.json"),
        PathBuf::from,
    );
    if let Some(folder) = out.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(&out, serde_json::to_string_pretty(&report)? + "\n")?;
    Ok(holds)
}

/// `SGLOW_LIBRARY`, the repository's own library, or the small one of the tests.
fn library_path() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let own = here.join("../shaders");
    env::var_os("SGLOW_LIBRARY").map_or_else(
        || if own.join("library.toml").exists() { own } else { here.join("tests/foreign") },
        PathBuf::from,
    )
}

fn generate_all(library: &Library, variants: &[Variant], whole: Whole) {
    let generated = generate::variants_against(library, variants, whole);
    if let Ok(generated) = generated {
        generated.par_iter().for_each(|one| write(&one.module, &one.info));
    }
}

fn read_and_write(text: &str, requires: &BTreeSet<&str>) {
    if let Ok(module) = naga::front::wgsl::parse_str(text)
        && let Ok(info) = validator(requires).validate(&module)
    {
        write(&module, &info);
    }
}

fn write(module: &naga::Module, info: &ModuleInfo) {
    if let Ok((module, info)) = process_overrides(module, info, None, &Default::default()) {
        let _ = black_box(spv::write_vec(&module, &info, &spv::Options::default(), None));
    }
}

fn time(work: impl FnOnce()) -> Duration {
    let start = Instant::now();
    work();
    start.elapsed()
}

/// Sorts and returns the one in the middle, in seconds.
fn median(times: &mut [Duration]) -> f64 {
    times.sort_unstable();
    times[times.len() / 2].as_secs_f64()
}

fn spread(sorted: &[Duration]) -> String {
    let milliseconds = |time: Option<&Duration>| time.map_or(0.0, |time| time.as_secs_f64() * 1e3);
    format!("{:.2} to {:.2}", milliseconds(sorted.first()), milliseconds(sorted.last()))
}

/// Seconds since 1970.
fn date() -> u64 {
    std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0, |since| since.as_secs())
}
