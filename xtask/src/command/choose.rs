//! `choose`: the configuration of a scene's indirect light that a budget buys, and the package of just that.

use std::path::PathBuf;

use clap::{ArgGroup, Args};
use sglow_measure::frontier::buy::buy;
use sglow_measure::frontier::offer::{self, Offer};
use sglow_measure::frontier::subject::Subject;
use sglow_measure::frontier::{RUNS, configuration, screening};
use sglow_report::failure::{Failure, Result};
use sglow_report::json::Report;
use sglow_report::{failure, json, parse, terminal, write};
use sglow_results::frontier::choose::{Budget, kept};
use sglow_results::frontier::document::{Configuration, Metric};
use sglow_shader_gen::package::Target;

use crate::command::gen_shaders;
use crate::command::report::{Choice, case};
use crate::options::Numbers;
use crate::progress::Bars;
use crate::{options, say};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask choose --scene cornell --max-ms 100 --out out/cornell
  cargo xtask choose --scene cornell --max-error 0.05 --size 320x180 --out out/cornell
  cargo xtask choose --scene cornell --max-error 30% --metric rmse --out out/cornell
  cargo xtask choose --scene columns --max-error 0.05 --metric flip --only visibility=none --target wgsl,spirv --out out/columns

Configurations are screened as `report` does, one axis at a time and then what stays crossed, or taken from what was
measured before. With --max-error the cheapest one wins whose error is at most that, with --max-ms the most accurate one that
takes at most that long; those that come close are measured again as whole frames, in turns. A budget of time is one of all passes of
indirect light at the size of the picture that is given.";

/// Options of `choose`.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("budget").required(true)))]
pub(crate) struct Arguments {
    /// A built-in scene, or a file: .gltf, .glb, .obj
    #[arg(long, value_name = "FILE|NAME")]
    scene: String,
    /// The maximum error: a number, or a percentage
    #[arg(long, value_name = "E", value_parser = parse::share, allow_negative_numbers = true, group = "budget")]
    max_error: Option<f64>,
    /// The maximum time of indirect light in a frame, in milliseconds
    #[arg(long, value_name = "T", value_parser = parse::milliseconds, allow_negative_numbers = true, group = "budget")]
    max_ms: Option<f64>,
    /// The metric of the error: relative_mse, rmse, median, q95, flip, bias
    #[arg(long, value_name = "METRIC", default_value_t)]
    metric: Metric,
    /// Pixels of the picture
    #[arg(long, value_name = "WxH", default_value = "112x63", value_parser = parse::size)]
    size: [u32; 2],
    /// The folder that receives the package
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Languages beside WGSL: spirv, rust
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    target: Vec<Target>,
    /// Also write what was found as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    choice: Choice,
    #[command(flatten)]
    numbers: Numbers,
}

/// Chooses, and writes the package.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let budget = match (arguments.max_error, arguments.max_ms) {
        (Some(error), _) => Budget::Error(error),
        (None, Some(time)) => Budget::Milliseconds(time),
        (None, None) => return Err(Failure::new("give --max-error or --max-ms")),
    };
    let metric = arguments.metric;
    let library = arguments.numbers.over.library()?;
    let only = offer::only(&arguments.choice.only, &library).map_err(Failure::from);
    let cache = arguments.choice.cache();
    let case = case(&arguments.scene, arguments.size, &arguments.numbers);
    let places = failure::both(cache, write::probe_package(&arguments.out));
    let ((only, (cache, ())), case) = failure::both(failure::both(only, places), case)?;
    let package = arguments.numbers.over.whole_space()?;
    let gpu = arguments.numbers.gpu()?;
    let offer =
        Offer { package: &package, all: arguments.choice.all, filters: gpu.filters_float32() };
    let bars = Bars::default();
    let cases = [case];
    let planned = screening::plan(&gpu, &offer, &cases, &only, &cache, &bars)?;
    let [case] = cases;
    let configurations =
        planned.into_iter().next().map(|one| one.configurations).unwrap_or_default();
    let subject = Subject::new(&gpu, &package, &case.scene, case.derivation.settings.clone());
    let bought = buy(&subject, &configurations, metric, budget, &cache, &bars);
    bars.clear();
    let purchase = bought?;
    let find = |name: &String| purchase.configurations.iter().find(|one| one.name == *name);
    let order: Vec<&Configuration> = purchase.order.iter().filter_map(find).collect();
    let Some((winner, others)) = order.split_first() else {
        return Err(terminal::choose::nothing(&purchase, metric, budget));
    };
    say::line(terminal::choose::show(&order, metric, &purchase, RUNS));
    let lost =
        others.first().map(|runner_up| terminal::choose::margin(winner, runner_up, metric, budget));
    say::line(lost.as_deref().unwrap_or("There is no runner-up: nothing else meets the budget."));

    let name =
        |settings: &&_| configuration::name(settings, &case.derivation.settings) == winner.name;
    let chosen = configurations.iter().find(name);
    let missing = || Failure::new(format!("{}: not among what was measured", winner.name));
    let set = case.set(chosen.ok_or_else(missing)?).map_err(Failure::from)?;
    gen_shaders::run(&gen_shaders::Arguments {
        choice: options::Choice {
            over: arguments.numbers.over.clone(),
            scene: Some(arguments.scene.clone()),
            set: set.clone(),
            preset: arguments.numbers.preset.clone(),
            all: false,
            light: arguments.numbers.light,
            reading: arguments.numbers.reading,
        },
        out: Some(arguments.out.clone()),
        target: arguments.target.clone(),
        check: false,
        json: None,
    })?;
    say::line(format!("{} shows it", again(arguments, &set)));
    let Some(path) = &arguments.json else { return Ok(()) };
    let mut report = Report::on(&gpu.adapter.name, &gpu.adapter.driver);
    report.check(kept(winner, metric, budget));
    report.detail("scene", &case.scene.name)?;
    report.detail("chosen", winner)?;
    report.detail("came_next", others)?;
    report.detail("reference", &purchase.reference)?;
    report.detail("clock", &purchase.clock)?;
    report.detail("set", set)?;
    report.detail("variants", sglow_consumers::subject::identifiers(&arguments.out)?)?;
    report.write(path)
}

/// The line that renders what was chosen, which has the numbers that it was measured with.
fn again(arguments: &Arguments, set: &[String]) -> String {
    let Arguments { scene, size: [width, height], out, numbers, .. } = arguments;
    let Numbers { over, preset, light, .. } = numbers;
    let options = [
        ("--scene", Some(scene.clone())),
        ("--preset", preset.clone()),
        ("--set", (!set.is_empty()).then(|| set.join(","))),
        ("--size", Some(format!("{width}x{height}"))),
        ("--light", light.map(|light| light.to_string())),
        ("--package", Some(out.display().to_string())),
        ("--out", Some("out/chosen.png".to_owned())),
    ];
    let folders =
        over.library.iter().map(|folder| ("--library", Some(folder.display().to_string())));
    let given = options.into_iter().chain(folders).filter(|option| option.1.is_some());
    let words = given.flat_map(|(name, value)| [Some(name.to_owned()), value]).flatten();
    json::command_line(std::iter::once("render".to_owned()).chain(words))
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn line(words: &[&str]) -> Result<Arguments, String> {
        let always = ["choose", "--scene", "cornell", "--out", "out/it's"];
        let parsed = Line::try_parse_from(always.iter().chain(words));
        parsed.map(|line| line.arguments).map_err(|error| error.to_string())
    }

    #[test]
    fn there_is_one_budget_and_it_is_a_number() {
        let none = line(&[]).unwrap_err();
        assert!(none.contains("--max-error") && none.contains("--max-ms"), "{none}");
        assert!(line(&["--max-error", "1", "--max-ms", "1"]).is_err());
        let negative = line(&["--max-error", "-1"]).unwrap_err();
        assert!(negative.contains("'-1' is not a share"), "{negative}");
        assert!(line(&["--max-ms", "2"]).is_ok());
    }

    #[test]
    fn what_was_measured_is_what_the_line_shows() {
        let arguments =
            line(&["--max-ms", "2", "--lights", "16", "--rsm", "32", "--size", "8x4"]).unwrap();
        // Numbers that were given are among what is set.
        let set = ["kernel=previous", "lights=16", "map=32"].map(str::to_owned);
        let text = again(&arguments, &set);
        let start = "cargo xtask render --scene cornell --set kernel=previous,lights=16,map=32 --size 8x4 --package ";
        assert!(text.starts_with(start) && text.contains(r"'out/it'\''s'"), "{text}");
    }

    #[test]
    fn the_metric_is_one_of_those_that_are_known() {
        assert_eq!(line(&["--max-ms", "2"]).unwrap().metric, Metric::RelativeMse);
        let wrong = line(&["--max-ms", "2", "--metric", "mean"]).unwrap_err();
        assert!(wrong.contains("unknown metric 'mean'") && wrong.contains("q95"), "{wrong}");
    }
}
