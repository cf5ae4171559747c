//! What a reproduction of the papers' tables and figures found.

use serde::Serialize;

use crate::check::{Check, Relation};
use crate::display::Exposure;
use crate::kernels::Square;
use crate::picture_error::{PictureError, Radiance};
use crate::rivals::flicker::Flickers;
use crate::rivals::method::Method;
use crate::rivals::stages::{Code, Stages};
use crate::rivals::survey::{Row, Survey};

/// What must not be concluded.
pub const DOES_NOT_SHOW: [&str; 5] = [
    "The paper's scenes cannot be had: the atrium stands in for them by its number of triangles. Its geometry, textures \
     and lights are others, so that only orders and ratios can be compared.",
    "On a software driver times compare variants within one run and do not predict those of GPUs: a texture load costs as \
     much as arithmetic, nothing is hidden behind anything, and two cores take the place of thousands of lanes.",
    "Flicker and its reference are without and with visibility: the reference sees shadows, the methods here do not. Both \
     stand still but for the light, so that the difference in change is small beside the flicker of what is drawn anew.",
    "Markov chains are our own construction after the method's description; their speed of mixing is not the paper's.",
    "Pictures are smaller than the paper's 1920 x 1088, for the references are computed on the CPU.",
];

/// A number that was requested, and how it came out.
#[derive(Clone, Debug, Serialize)]
pub struct Requested {
    /// What.
    pub name: String,
    /// What was measured.
    pub value: f64,
    /// How it should lie.
    pub relation: Relation,
    /// To what.
    pub bound: f64,
    /// Whether it does.
    pub met: bool,
    /// On what, and where the difference comes from.
    pub note: String,
}

impl Requested {
    /// A number beside its bound.
    #[must_use]
    pub fn new(
        name: &str,
        value: f64,
        relation: Relation,
        bound: f64,
        note: impl Into<String>,
    ) -> Self {
        let met = relation.holds(value, bound);
        Self { name: name.to_owned(), value, relation, bound, met, note: note.into() }
    }
}

/// A picture of a figure.
#[derive(Clone, Debug, Serialize)]
pub struct Shown {
    /// The method, or what else is shown.
    pub name: String,
    /// The file, beside the page.
    pub file: String,
    /// How far it is from the reference; none of the reference itself.
    pub error: Option<PictureError>,
}

/// A picture beside the page.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Its file.
    pub file: String,
    /// What it shows.
    pub drawn: Drawn,
}

/// What a picture shows.
#[derive(Clone, Debug)]
pub enum Drawn {
    /// What the camera sees.
    Radiance {
        /// Width and height.
        size: [u32; 2],
        /// Linear radiance.
        pixels: Radiance,
        /// The exposure that all pictures of the figure share.
        exposure: Exposure,
    },
    /// Kernels over a density.
    Kernels {
        /// Width and height of the density.
        side: usize,
        /// Its texels.
        density: Vec<f32>,
        /// The kernels.
        squares: Vec<Square>,
    },
}

/// A figure.
#[derive(Clone, Debug, Serialize)]
pub struct Figure {
    /// As the paper counts, or the scene's name.
    pub name: String,
    /// What it shows.
    pub about: String,
    /// The reference's own standard error over its mean.
    pub standard_error: Option<f64>,
    /// Its pictures.
    pub pictures: Vec<Shown>,
}

/// A table of times on one scene and density.
#[derive(Clone, Debug, Serialize)]
pub struct TimeTable {
    /// As the paper counts.
    pub name: &'static str,
    /// The scene.
    pub scene: String,
    /// The density.
    pub density: &'static str,
    /// Each method.
    pub methods: Vec<Stages>,
}

/// A survey of one scene and density.
#[derive(Clone, Debug, Serialize)]
pub struct Surveyed {
    /// The scene.
    pub scene: String,
    /// The density.
    pub density: &'static str,
    /// What was found.
    pub found: Survey,
}

/// A mip chain against a copy.
#[derive(Clone, Debug, Serialize)]
pub struct MipRow {
    /// What it is a chain of.
    pub name: &'static str,
    /// Milliseconds.
    pub mips: f64,
    /// Milliseconds.
    pub copy: f64,
    /// Median of the ratios of each round.
    pub ratio: f64,
}

/// Everything.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Findings {
    /// Numbers that were requested.
    pub requested: Vec<Requested>,
    /// Tables 1 and 2.
    pub times: Vec<TimeTable>,
    /// Table 3.
    pub code: Vec<Code>,
    /// Dispatches of each method on one map, without those of mips, and those of mips.
    pub dispatches: Vec<(Method, usize, usize)>,
    /// Times of the sampling pass, by bisection and by the bracketed solver, over those of previous kernels, by density.
    pub sampling: Vec<(String, [f64; 2])>,
    /// Mip chains.
    pub mips: Vec<MipRow>,
    /// Every method on one frame.
    pub surveys: Vec<Surveyed>,
    /// Flicker under a moving light, by scene.
    pub flickers: Vec<(String, Flickers)>,
    /// Figures.
    pub figures: Vec<Figure>,
}

/// What holds whatever the device.
#[must_use]
pub fn checks(found: &Findings) -> Vec<Check> {
    let mut checks = Vec::new();
    let not_finite: usize = found
        .surveys
        .iter()
        .flat_map(|survey| &survey.found.rows)
        .map(|row| row.not_finite)
        .chain(found.flickers.iter().flat_map(|one| &one.1.contenders).map(|one| one.not_finite))
        .sum();
    checks.push(Check::new(
        "numbers that are not finite, all methods and scenes",
        not_finite as f64,
        "numbers",
        Relation::Equal,
        0.0,
    ));
    for surveyed in &found.surveys {
        let of = |method| surveyed.found.rows.iter().find(|row| row.method == method);
        if let (Some(ours), Some(theirs), false) =
            (of(Method::Bracketed), of(Method::Previous), surveyed.found.dark)
        {
            let name = format!(
                "{}, {}: variation of the density within kernels, modified over previous",
                surveyed.scene, surveyed.density
            );
            let ratio = ours.overlap.variation / theirs.overlap.variation.max(f64::MIN_POSITIVE);
            checks.push(Check::new(name, ratio, "", Relation::AtMost, 1.0));
        }
        // Eq. (5) divides by the density that the kernel's own weights sum.
        let sized_by_integral = |row: &&Row| row.method == Method::Bracketed;
        let unbalanced = surveyed.found.rows.iter().filter(sized_by_integral);
        let unbalanced = unbalanced.map(|row| (row.weighted.excess - row.weighted.gaps).abs());
        let name = format!(
            "{}, {}: density counted twice less density not counted, by the filter's weights, at any K",
            surveyed.scene, surveyed.density
        );
        let most = if surveyed.found.dark { 0.0 } else { unbalanced.fold(0.0, f64::max) };
        checks.push(Check::new(name, most, "of the density", Relation::AtMost, 1e-3));
    }
    checks
}

/// The numbers that were requested of methods, beside what was measured of them.
#[must_use]
pub fn requested(found: &Findings) -> Vec<Requested> {
    let mut all = Vec::new();
    let worst = |index: usize| {
        let scenes = found.sampling.iter().filter(|one| one.0.starts_with("atrium"));
        scenes.map(|one| one.1[index]).fold(f64::NEG_INFINITY, f64::max)
    };
    let note = "the largest over the scenes of the table below, median of turns in one run";
    let most = Relation::AtMost;
    all.push(Requested::new(
        "sampling pass, 12 bisections over previous",
        worst(0),
        most,
        1.05,
        note,
    ));
    all.push(Requested::new("sampling pass, bracketed over previous", worst(1), most, 1.0, note));
    for times in &found.times {
        let total = |method| {
            let one = times.methods.iter().find(|one| one.method == method);
            one.map_or(f64::NAN, |one| one.total(None))
        };
        let ratio = total(Method::Image) / total(Method::Bracketed);
        let name = format!("{}: making of lights, k-means 2D over modified", times.name);
        let note = "both maps; the paper has 7.1 and 9.1";
        all.push(Requested::new(&name, ratio, Relation::AtLeast, 9.0, note));
    }
    for row in &found.mips {
        let name = format!("mip chain over a copy of the same bytes, {}", row.name);
        all.push(Requested::new(&name, row.ratio, most, 2.0, "one run, median of rounds"));
    }
    for (scene, flickers) in &found.flickers {
        let of = |name: &str| {
            let one = flickers.contenders.iter().find(|one| one.name.starts_with(name));
            one.map_or(f64::NAN, |one| one.flicker)
        };
        let ratio = of("modified, bracketed, K = 1") / of("previous");
        let name = format!("{scene}: flicker, modified (K = 1) over previous");
        all.push(Requested::new(&name, ratio, most, 0.5, "bidirectional density"));
    }
    for surveyed in &found.surveys {
        let of = |method| {
            let one = surveyed.found.rows.iter().find(|row| row.method == method);
            one.map_or(f64::NAN, |row| row.error)
        };
        let ratio = of(Method::Bracketed) / of(Method::Image);
        let name = format!(
            "{}, {}: picture error, modified over k-means 2D",
            surveyed.scene, surveyed.density
        );
        let note = "against the facets of the map, on a sample of pixels";
        all.push(Requested::new(&name, ratio, most, 1.0, note));
    }
    all
}
