//! Made-up scenes with everything that a page can have; nothing in them was measured.

use std::collections::{BTreeMap, BTreeSet};

use sglow_oracle::fis::stress::Random;
use sglow_report::json::Report;
use sglow_report::page::report::{Decision, Fact, Input, LeftOut, Scene, page};
use sglow_results::check::{Check, Relation};
use sglow_results::frontier::document::{
    Configuration, Pass, PictureError, Pictures, Pruned, Radiance, Reference, Rounding,
    SceneReport, Series, Side, Straddling, Sweep, SweepOver, SweepPoint, Uncertainty, Worst,
};
use sglow_results::frontier::rank;
use sglow_results::static_cost::StaticCost;
use sglow_results::tile_lists::TileLists;
use sglow_results::time::Time;

/// A scene and all that goes with it.
pub(crate) struct MadeUp {
    /// What was measured of it.
    pub(crate) measured: SceneReport,
    /// Its pictures.
    pub(crate) pictures: Pictures,
    /// FLIP maps.
    pub(crate) flip: BTreeMap<String, Vec<f32>>,
    facts: Vec<Fact>,
    decisions: Vec<Decision>,
    left_out: Vec<LeftOut>,
}

impl MadeUp {
    /// As the page takes it.
    pub(crate) fn scene(&self) -> Scene<'_> {
        Scene {
            measured: &self.measured,
            pictures: &self.pictures,
            flip: &self.flip,
            facts: &self.facts,
            decisions: &self.decisions,
            left_out: &self.left_out,
        }
    }
}

/// Pixels of the pictures.
const SIZE: [u32; 2] = [160, 90];
/// Axes, their values, and what each value does to error and time.
type Axis = (&'static str, &'static [(&'static str, f64, f64)]);
const AXES: [Axis; 6] = [
    ("kernel", &[("modified", 1.0, 1.0), ("previous", 1.35, 0.97)]),
    ("filter", &[("hardware", 1.02, 0.8), ("exact", 1.0, 1.0)]),
    ("density", &[("power", 1.0, 1.0), ("reflectance", 1.2, 0.98), ("bidirectional", 0.93, 1.9)]),
    (
        "cosine",
        &[
            ("fitted", 1.0, 1.0),
            ("erf", 1.01, 1.12),
            ("gaussian", 1.1, 0.9),
            ("constant", 1.5, 0.8),
        ],
    ),
    ("specular", &[("ndf_filtered", 1.0, 1.0), ("asg", 1.3, 1.2), ("sg", 1.25, 0.85)]),
    ("precision", &[("f32", 1.0, 1.0), ("f16", 1.000_5, 1.01)]),
];
/// Passes and their share of the time.
const PASSES: [(&str, f64); 6] = [
    ("density", 0.05),
    ("mip density", 0.04),
    ("moments", 0.14),
    ("mip moments", 0.12),
    ("sample", 0.05),
    ("shade", 0.6),
];

/// The page of all of them.
pub(crate) fn whole() -> String {
    of(&scenes())
}

/// The page of one of them alone.
pub(crate) fn one() -> String {
    of(&[cut(scene("court", 1, 0.12, 0.02))])
}

fn of(scenes: &[MadeUp]) -> String {
    let scenes: Vec<Scene<'_>> = scenes.iter().map(MadeUp::scene).collect();
    page(&Input {
        report: &report(),
        scenes: &scenes,
        within: 0.05,
        minutes: 8.5,
        does_not_show: &[
            "Anything at all: every number on this page is made up, to see how the page looks.",
            "How fast a GPU is: <made up> & \"quoted\".",
        ],
        static_costs: &static_costs(&scenes),
    })
}

/// What a compiler might make of every other configuration's shading.
fn static_costs(scenes: &[Scene<'_>]) -> Vec<StaticCost> {
    let configurations = scenes.iter().flat_map(|scene| &scene.measured.configurations);
    let shades = configurations.step_by(2).flat_map(|one| &one.variants);
    let shades: BTreeSet<&String> = shades.filter(|id| id.starts_with("shade")).collect();
    let compiled = shades.into_iter().zip(0..).map(|(variant, at)| StaticCost {
        variant: variant.clone(),
        family: "a family".to_owned(),
        driver: "a compiler 1.2.3".to_owned(),
        instructions: 1500 + 37 * at,
        loop_issue_cycles: (at % 3 > 0).then_some(900 + 11 * at),
        vgprs: 64,
        subgroups_per_simd: 16,
    });
    compiled.collect()
}

/// One with everything, one without specular reflection, one that no light reaches.
pub(crate) fn scenes() -> Vec<MadeUp> {
    vec![
        cut(scene("court", 1, 0.12, 0.02)),
        plain(scene("chalk", 2, 0.06, 0.08)),
        dark(scene("<night> & \"shade\"", 3, 0.0, 0.0)),
    ]
}

/// What was checked.
pub(crate) fn report() -> Report {
    let mut report = Report::new();
    report.date = "2000-01-01T00:00:00Z".to_owned();
    report.command = "cargo xtask report --scene court --out out/report".to_owned();
    report.adapter = "an adapter <made up>".to_owned();
    report.driver = "a driver 1.2.3".to_owned();
    report.check(Check::new(
        "chalk: texture bytes left out",
        0.44,
        "of all",
        Relation::AtLeast,
        0.4,
    ));
    report.check(
        Check::new(
            "chalk: shading, everything over what it needs",
            1.7,
            "times",
            Relation::AtLeast,
            1.8,
        )
        .note("made up, so that one promise is broken"),
    );
    report
}

fn scene(name: &str, seed: u64, error: f64, noise: f64) -> MadeUp {
    let mut random = Random::new(seed);
    let mut configurations = configurations(&mut random, error);
    let made_of = reference(noise);
    rank::mark(&mut configurations);
    let shown = |configuration: &&Configuration| configuration.is_shown();
    for configuration in
        configurations.iter_mut().filter(|configuration| !configuration.frontiers.is_empty())
    {
        configuration.flicker = Some(configuration.picture.rmse_over_mean * 0.2);
        configuration.whole = Some(around(configuration.time.median * 0.93));
    }
    let reference = picture(&mut random, 0.0);
    let mut pictures = Pictures { reference, ..Pictures::default() };
    let mut flip = BTreeMap::new();
    for configuration in configurations.iter().filter(shown) {
        let noise = if configuration.picture.rmse_over_mean.is_finite() {
            configuration.picture.rmse_over_mean
        } else {
            1.0
        };
        pictures.configurations.insert(configuration.name.clone(), picture(&mut random, noise));
        flip.insert(configuration.name.clone(), map(&mut random, noise));
    }
    MadeUp {
        measured: SceneReport {
            scene: name.to_owned(),
            triangles: 26_556,
            light: "directional".to_owned(),
            size: SIZE,
            rsm_size: 256,
            lights: 1024,
            iterations: 12,
            size_factor: 1.0,
            clock: "time stamps".to_owned(),
            runs: 7,
            reference: made_of,
            configurations,
            sweeps: sweeps(error),
            lists: None,
            straddling: Straddling {
                size_factor: 1.0,
                lights_relative_mse: error * error,
                lights_median: 0.3 * error,
                texels_relative_mse: 0.2 * error * error,
                texels_median: 0.05 * error,
            },
            screening: None,
            pruned: None,
            not_finite: 0,
        },
        pictures,
        flip,
        facts: vec![
            fact("specular", true, "material `ring` is metallic (1)"),
            fact("cutout", false, "no texture falls below its material's cutoff"),
        ],
        decisions: vec![Decision {
            what: "virtual lights".to_owned(),
            value: "1024".to_owned(),
            reason: "as in the paper; the map has 65,536 texels".to_owned(),
            changed: true,
        }],
        left_out: Vec::new(),
    }
}

fn reference(noise: f64) -> Reference {
    Reference { samples: 256, mean: 0.25, noise_over_mean: noise, dark: false }
}

fn fact(name: &str, holds: bool, evidence: &str) -> Fact {
    Fact { name: name.to_owned(), holds, evidence: evidence.to_owned() }
}

/// Every combination of values; the first is the default.
fn configurations(random: &mut Random, error: f64) -> Vec<Configuration> {
    let count: usize = AXES.iter().map(|axis| axis.1.len()).product();
    let mut configurations: Vec<Configuration> =
        (0..count).map(|index| configuration(index, random, error)).collect();
    configurations.extend((0..12).map(|index| clusters(index, random, error)));
    if let Some(odd) = configurations.get_mut(count / 2) {
        let nan = f64::NAN;
        let (rmse_over_mean, relative_mse, median, q95, flip) = (nan, nan, nan, nan, nan);
        let old = odd.picture;
        odd.picture = PictureError { rmse_over_mean, relative_mse, median, q95, flip, ..old };
    }
    if let Some(odd) = configurations.get_mut(count / 3) {
        odd.picture.rmse_over_mean = f64::INFINITY;
        odd.picture.relative_mse = f64::INFINITY;
        odd.picture.bias = f64::INFINITY;
    }
    configurations
}

fn configuration(index: usize, random: &mut Random, error: f64) -> Configuration {
    let mut rest = index;
    let mut axes = BTreeMap::new();
    let (mut error, mut time) = (error, 6.0);
    for (axis, values) in AXES {
        let (value, worse, slower) = values[rest % values.len()];
        rest /= values.len();
        axes.insert(axis.to_owned(), value.to_owned());
        error *= worse;
        time *= slower;
    }
    let names: Vec<&str> = axes.values().map(String::as_str).collect();
    let name = names.join("-");
    let jitter = |random: &mut Random| 1.0 + 0.04 * (random.uniform() - 0.5);
    measured(name, axes, error * jitter(random), time * jitter(random), index == 0)
}

fn clusters(index: usize, random: &mut Random, error: f64) -> Configuration {
    let space = if index.is_multiple_of(2) { "image" } else { "world" };
    let axes = BTreeMap::from([
        ("kernel".to_owned(), "none".to_owned()),
        ("density".to_owned(), "power <&\"".to_owned()),
        ("space".to_owned(), space.to_owned()),
    ]);
    let error = error * (1.0 + 0.4 * random.uniform());
    let mut configuration = measured(
        format!("clusters-<&\"{space}\"-{index}"),
        axes,
        error,
        30.0 + random.uniform(),
        false,
    );
    configuration.complete = !index.is_multiple_of(3);
    configuration
}

fn around(median: f64) -> Time {
    Time { median, minimum: median * 0.97, maximum: median * 1.05 }
}

fn measured(
    name: String,
    axes: BTreeMap<String, String>,
    error: f64,
    time: f64,
    default: bool,
) -> Configuration {
    let half = axes.get("precision").is_some_and(|value| value == "f16");
    let scale = if half { 1 } else { 2 };
    let bytes = [
        ("moments", 1_747_632),
        ("density", 349_524),
        ("lights", 98_304),
        ("diffuse", 115_200),
        ("specular", 115_200),
    ];
    let visible = axes.get("density").is_some_and(|value| value == "bidirectional");
    Configuration {
        name,
        parameters: BTreeMap::from([("lights".to_owned(), "1024".to_owned())]),
        variants: vec!["sample".to_owned(), "shade".to_owned()],
        default,
        complete: true,
        passes: PASSES
            .iter()
            .map(|(name, share)| Pass { name: (*name).to_owned(), time: around(time * share) })
            .collect(),
        time: around(time),
        whole: None,
        bytes: bytes.into_iter().map(|(name, bytes)| (name.to_owned(), bytes * scale)).collect(),
        picture: PictureError {
            rmse_over_mean: error,
            relative_mse: error * error,
            // Half precision looks better by one metric and worse by another, so that metrics disagree.
            median: if half { 0.2 } else { 0.25 } * error,
            q95: if half { 3.5 } else { 3.0 } * error,
            bias: -error / 3.0,
            flip: error / 4.0,
            uncertainty: Uncertainty {
                relative_mse: 0.03 * error * error,
                rmse_over_mean: 0.015 * error,
                median: 0.01 * error,
                ..Uncertainty::default()
            },
            reference_mean: 0.25,
            pixels: 14_400,
            not_finite: 0,
        },
        unshadowed: (!visible).then(|| PictureError {
            rmse_over_mean: 0.5 * error,
            relative_mse: 0.25 * error * error,
            reference_mean: 0.3,
            ..PictureError::default()
        }),
        worst: worst(error),
        model_rms_over_mean: (!visible).then_some(error * 0.4),
        rounding: (!visible).then(|| Rounding { rms_over_mean: 3e-7, worst: worst(3e-7) }),
        flicker: None,
        frontiers: BTreeSet::new(),
        dominated: BTreeMap::new(),
        axes,
    }
}

fn worst(error: f64) -> Worst {
    let texel = |bits: &str| [bits, "0x3f000000", "0xbe99999a", "0x3f800000"].map(str::to_owned);
    Worst {
        pixel: [12, 34],
        found: [0.25 * (1.0 + error), 0.2, 0.1],
        expected: [0.25, 0.2, 0.1],
        surface: ["0x42b20000", "0x00000000", "0x3f4ccccd"].map(texel),
    }
}

/// A ball over a floor, with an error of its indirect light.
fn picture(random: &mut Random, error: f64) -> Radiance {
    let [width, height] = SIZE;
    let mut pixels = Vec::with_capacity((width * height) as usize);
    for row in 0..height {
        for column in 0..width {
            let (x, y) =
                (f64::from(column) / f64::from(height), f64::from(row) / f64::from(height));
            let (dx, dy) = (x - 0.9, y - 0.5);
            let inside = dx * dx + dy * dy < 0.09;
            let light = if inside { 1.2 - 2.0 * (dx + dy) } else { 0.15 + 0.5 * y };
            let noise = 1.0 + error * (2.0 * random.uniform() - 1.0);
            let tint = if inside { [1.0, 0.6, 0.35] } else { [0.5, 0.6, 0.8] };
            pixels.push(tint.map(|channel| (light * noise * channel) as f32));
        }
    }
    pixels
}

fn map(random: &mut Random, error: f64) -> Vec<f32> {
    let [width, height] = SIZE;
    (0..width * height).map(|_| (error.min(1.0) * random.uniform()) as f32).collect()
}

fn sweeps(error: f64) -> Vec<Sweep> {
    let sweep = |over, limit: &str, series| Sweep { over, limit: limit.to_owned(), series };
    let halved = |at: f64| 0.5_f64.powf(at);
    let grown = |at: f64| 0.02 * (at.ln().abs() + 0.1);
    let fewer = |at: f64| 1.5 / at.sqrt();
    let steps: Vec<f64> = (1..=24).map(f64::from).collect();
    let factors = [0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];
    let lights = [64.0, 128.0, 256.0, 512.0, 1024.0, 2048.0, 4096.0];
    let maps = [64.0, 128.0, 256.0, 512.0, 1024.0, 2048.0];
    let flat = |at: f64| 0.4 + 0.01 * at;
    vec![
        sweep(
            SweepOver::Iterations,
            "24 exact steps",
            vec![
                series("exact", error, &steps, &halved, Some(&flat), Some(6.0)),
                series(
                    "hardware",
                    error,
                    &steps,
                    &|at| halved(at) + 2e-5,
                    Some(&|at| 0.3 + 0.005 * at),
                    Some(6.0),
                ),
                series(
                    "hardware, 8-bit weights modelled",
                    error,
                    &steps,
                    &|at| halved(at) + 2e-3,
                    None,
                    None,
                ),
            ],
        ),
        sweep(
            SweepOver::SizeFactor,
            "K = 1",
            vec![series("modified, bracketed", error, &factors, &grown, Some(&|_| 0.5), Some(1.0))],
        ),
        sweep(
            SweepOver::Lights,
            "65,536 lights",
            vec![series(
                "modified, bracketed",
                error,
                &lights,
                &fewer,
                Some(&|at| 0.004 * at),
                Some(1024.0),
            )],
        ),
        sweep(
            SweepOver::Map,
            "",
            vec![
                series("1024 clusters", error, &maps, &fewer, Some(&|at| 0.1 * at), None),
                series("cut", error, &maps, &|at| 0.5 * fewer(at), Some(&flat), Some(512.0)),
            ],
        ),
    ]
}

fn series(
    name: &str,
    error: f64,
    at: &[f64],
    own: &dyn Fn(f64) -> f64,
    time: Option<&dyn Fn(f64) -> f64>,
    pays_until: Option<f64>,
) -> Series {
    let points = at
        .iter()
        .map(|&at| SweepPoint {
            at,
            time: time.map(|time| around(time(at))),
            picture: time.map(|_| PictureError {
                rmse_over_mean: error.hypot(own(at)),
                ..PictureError::default()
            }),
            own_rms_over_mean: Some(own(at)),
            flicker: (pays_until == Some(1.0)).then(|| 0.02 / at),
        })
        .collect();
    Series { name: name.to_owned(), points, pays_until }
}

/// With a cut for each tile, whose lists are longer to the right.
fn cut(mut scene: MadeUp) -> MadeUp {
    let [width, height] = SIZE.map(|side| side as usize);
    let columns = width.div_ceil(8);
    let lengths: Vec<usize> =
        (0..columns * height.div_ceil(8)).map(|at| 20 * (at % columns)).collect();
    scene.pictures.nodes = (0..width * height).map(|at| 2.0 * (at % width) as f32).collect();
    let (mean, below_95, maximum) = (width as f64, 19 * width / 10, 2 * width - 2);
    scene.measured.lists =
        Some(TileLists { columns, lengths, mean, below_95, maximum, limit: 1152, stopped: 0 });
    scene
}

/// Without specular reflection, and with what that saves.
fn plain(mut scene: MadeUp) -> MadeUp {
    let side = |shade: &str, texture_bytes, ms| Side {
        shade: shade.to_owned(),
        texture_bytes,
        buffer_bytes: 98_304,
        shade_time: around(ms),
        time: around(ms + 1.4),
        passes: Vec::new(),
    };
    scene.measured.pruned = Some(Pruned {
        full: side("shade-both", 7_420_000, 4.1),
        needed: side("shade-diffuse", 4_160_000, 2.4),
        size: SIZE,
        differing: 0,
        axes: BTreeMap::new(),
    });
    scene.facts[0] = fact("specular", false, "all 13 materials have no specular reflectance");
    let saved = |names: &[(&str, f64)]| {
        names.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
    };
    scene.left_out = vec![
        LeftOut {
            what: "lobes=both".to_owned(),
            rule: "no-specular-surface".to_owned(),
            reason:
                "nothing reflects specular light, so its moments, their mips and its lobes are 0"
                    .to_owned(),
            saved: saved(&[
                ("static_operations", 412.0),
                ("texture_bytes", 2_100_000.0),
                ("shader_bytes", 9_321.0),
                ("milliseconds", 1.7),
            ]),
        },
        LeftOut {
            what: "the pass emission".to_owned(),
            rule: "nothing-emits".to_owned(),
            reason: "no material emits <light> & none is \"lit\"".to_owned(),
            saved: saved(&[("bindings", 3.0), ("shader_bytes", 1_204.0)]),
        },
    ];
    scene
}

/// Without indirect light: every error is an absolute number, here mostly 0.
fn dark(mut scene: MadeUp) -> MadeUp {
    scene.measured.reference.dark = true;
    scene.measured.reference.mean = 0.0;
    scene.measured.sweeps.clear();
    scene.pictures.reference.fill([0.0; 3]);
    scene.pictures.configurations.values_mut().for_each(|picture| picture.fill([0.0; 3]));
    scene
}
