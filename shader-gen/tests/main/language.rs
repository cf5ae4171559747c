//! The language of frames by itself: formulas, a frame that has nothing to do with light, and what errors say.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::json;
use sglow_graph::description::{Number, Setting};
use sglow_graph::frame::{Action, Binding, Geometry, Size, Value};
use sglow_graph::{Configuration, Description, Frame};
use sglow_shader_gen::frame::Text;
use sglow_shader_gen::frame::authored::Authored;

/// Sparks: they are made, move in rounds between two buffers, last from frame to frame, and are drawn as many as there are.
const SPARKS: &str = r#"
[parameter.sparks]
description = "number of sparks"
type = "whole"
default = 100
minimum = 1
maximum = 4096
per = "resize"
[parameter.rounds]
description = "moves in a frame"
type = "whole"
default = 3
per = "resize"
[parameter.speed]
description = "in pixels a frame"
type = "real"
default = 0.5
above = 0.0
per = "resize"
[input.eye]
description = "where one looks from"
type = "vec3<f32>"
per = "frame"
[choose]
wind = [{ when = "windy", value = "strong" }]
[[require]]
that = "rounds < 9"
reason = "rounds: below 9"
[template.frame.resource]
seeds = { kept = true, buffer = { length = "sparks", stride = 16 } }
arguments = { buffer = { length = 4, stride = 4, initial = [6, 0, 0, 0] } }
picture = { part = "picture", texture = { format = "rgba8unorm", size = [32, "sparks"] } }
[template.frame.uniform]
step = { speed = "speed", round = "round", age = { age = "seeds" }, eye = [{ input = "eye" }, 1] }
[[template.frame.step]]
pass = "born"
new = "seeds"
dispatch = ["div_ceil(sparks, 64)", 1, 1]
bind = { seeds = "seeds" }
[[template.frame.step]]
use = "motion"
prefix = "slow_"
label = "motion"
let = { rounds = "rounds" }
names = { input = "seeds" }
[[template.frame.step]]
use = "motion"
prefix = "fast_"
label = "motion"
let = { rounds = 0 }
axes = { wind = "strong" }
names = { input = "slow_output" }
[[template.frame.step]]
clear = "arguments"
bytes = "2 * 4"
[[template.frame.step]]
label = "draw"
part = "picture"
pass = "draw"
bind = { moved = "fast_output" }
indirect = { buffer = "arguments", offset = 0 }
draw = { vertex = "vertex", fragment = "fragment", color = [{ target = "picture", clear = [0, 0, 0, 1] }] }
[template.motion.resource]
places = { flip = true, buffer = { length = "sparks", stride = 16 } }
[template.motion.alias]
output = [{ when = "rounds == 0", value = "input" }, { value = "places.front" }]
[[template.motion.step]]
repeat = "rounds"
index = "round"
flip = ["places"]
[[template.motion.step.steps]]
pass = "move"
dispatch = ["div_ceil(sparks, 64)", 1, 1]
bind = { from = [{ when = "round == 0", value = "input" }, { value = "places.front" }], to = "places.back" }
uniforms = { step = "step" }
"#;

/// What a library declares beside its frame.
fn library() -> Description {
    let no_disc = json!({ "is": ["shape", "disc"] });
    let library = json!({
        "passes": { "born": [], "move": ["wind"], "draw": ["shape"] },
        "axes": {
            "wind": { "default": "none", "values": ["none", "strong"] },
            "shape": { "default": "dot", "values": ["dot", "disc"] },
        },
        "facts": ["windy"],
        "preset": { "storm": {
            "description": "sparks in a storm", "set": { "wind": "strong", "rounds": 8, "speed": 20.0 },
        } },
        "default": [ {
            "name": "slow-in-calm", "when": { "!": [{ "name": "windy" }] }, "set": { "speed": 0.25, "sparks": 50 },
            "unless": ["rounds"], "reason": "nothing drives them",
        } ],
        "exclusion": [ {
            "name": "dot-is-drawn-alone", "passes": ["draw"], "when": no_disc,
            "reason": "discs are not drawn yet",
        } ],
    });
    serde_json::from_value(library).unwrap()
}

fn authored() -> Authored {
    toml::from_str(SPARKS).unwrap()
}

fn sparks() -> Description {
    authored().description(library()).unwrap()
}

fn evaluate(description: &Description, numbers: &[(&str, u64)]) -> Frame {
    let parameters = numbers.iter().map(|(name, n)| ((*name).to_owned(), Number::Whole(*n)));
    let parameters = parameters.collect();
    description.evaluate(&Configuration { parameters, ..Configuration::default() }).unwrap()
}

/// What each dispatch or draw binds by a name.
fn bound(frame: &Frame, name: &str) -> Vec<String> {
    let group = |action: &Action| match action {
        Action::Clear(..) => None,
        Action::Dispatch(dispatch) => Some(dispatch.group),
        Action::Draw(draw) => Some(draw.calls[0].group),
    };
    let groups = frame.steps.iter().filter_map(|step| group(&step.action));
    let bound = groups.filter_map(|group| match frame.groups[group].get(name)? {
        Binding::View(view) => Some(frame.resources[view.resource].name.clone()),
        Binding::Uniform(_) => None,
    });
    bound.collect()
}

#[test]
fn formulas_are_of_whole_numbers_and_checked() {
    for (text, result) in [
        ("1 + 2 * 3 - 4 / 2 % 5", Ok(5)),
        ("1 << 2 + 1 == 8 && !(2 > 3) || 0 / 0", Ok(1)),
        ("sparks >> 2 < 26 && sparks << 1 > 199 && sparks > 3 == 1", Ok(1)),
        ("min(3, 2) * max(3, 2) + div_ceil(7, 2)", Ok(10)),
        ("log2(pow2_ceil(1000)) * 100 + bits(8) * 10 + bits(0)", Ok(1040)),
        ("select(sparks >= 100, 7, 1 / 0) >> 1", Ok(3)),
        ("wind == 'none' && shape != 'disc'", Ok(1)),
        ("18446744073709551615 + 1", Err("the result exceeds 64 bits")),
        ("1 << 64", Err("the result exceeds 64 bits")),
        ("sparks - 101", Err("a negative difference")),
        ("7 % (sparks - 100)", Err("division by zero")),
        ("log2(0)", Err("the logarithm of 0")),
        ("speed + 1", Err("`speed` is real")),
        ("1 +", Err("not a formula: expected a number, a name or a bracket at character 4")),
        ("1 2", Err("not a formula: expected an operator or the end at character 3, found `2`")),
        ("max(1)", Err("not a formula: `max` takes 2 arguments, not 1")),
        ("root(4)", Err("not a formula: `root` is no function")),
        ("99999999999999999999", Err("not a formula")),
        ("wind + 'none'", Err("not a formula")),
        ("nothing", Err("unknown name `nothing`")),
        ("wind == 'weak'", Err("unknown value `weak`; expected one of none, strong")),
        ("tide == 'low'", Err("unknown axis `tide`")),
        ("circle + 1", Err("depends on itself")),
    ] {
        let mut authored = authored();
        let frame = authored.template.get_mut("frame").unwrap();
        frame.lets.insert("circle".into(), Text("wheel".into()));
        frame.lets.insert("wheel".into(), Text("circle".into()));
        if !text.contains("circle") {
            frame.lets.clear();
        }
        frame.step[3].bytes = Some(Text(text.into()));
        let description = authored.description(library()).map_err(|faults| faults.to_string());
        let evaluated = description.and_then(|description| {
            let evaluated = description.evaluate(&Configuration::default());
            evaluated.map_err(|errors| errors.to_string())
        });
        match (evaluated, result) {
            (Ok(frame), Ok(number)) => {
                let clear = frame.steps.iter().find_map(|step| match step.action {
                    Action::Clear(_, bytes) => bytes,
                    _ => None,
                });
                assert_eq!(clear, Some(number), "{text}");
            }
            (Err(errors), Err(message)) => {
                assert!(errors.contains(message), "{text}: {errors}");
            }
            (found, _) => panic!("{text}: {found:?}"),
        }
    }
}

#[test]
fn pairs_change_places_and_no_round_leaves_the_input() {
    let description = sparks();
    let moved = |rounds| {
        let frame = evaluate(&description, &[("rounds", rounds)]);
        (bound(&frame, "from"), bound(&frame, "to"), bound(&frame, "moved"))
    };
    let name = |name: &str| name.to_owned();
    let (a, b) = (name("slow_places.0"), name("slow_places.1"));
    assert_eq!(moved(0), (vec![], vec![], vec![name("seeds")]));
    assert_eq!(moved(1), (vec![name("seeds")], vec![b.clone()], vec![b.clone()]));
    let from = vec![name("seeds"), b.clone(), a.clone()];
    assert_eq!(moved(3), (from, vec![b.clone(), a, b.clone()], vec![b]));
}

#[test]
fn a_frame_says_what_runs_on_what() {
    let frame = evaluate(&sparks(), &[]);
    let seeds = frame.resource("seeds").unwrap();
    assert_eq!(frame.steps[0].new, Some(seeds));
    let labels: Vec<_> = frame.steps.iter().map(|step| step.label.as_str()).collect();
    assert_eq!(labels, ["", "motion", "motion", "motion", "", "draw"]);
    let Action::Dispatch(dispatch) = &frame.steps[1].action else { panic!("no dispatch") };
    assert_eq!(
        (&dispatch.size, dispatch.variant.id.clone()),
        (&Size::Groups([2, 1, 1]), "move-none".into())
    );
    let Some(Binding::Uniform(uniform)) = frame.groups[dispatch.group].get("step") else {
        panic!("no uniform")
    };
    let uniform = &frame.uniforms[*uniform];
    assert_eq!(uniform["speed"], Value::Number(Number::Real(0.5)));
    assert_eq!(uniform["round"], Value::Number(Number::Whole(0)));
    assert_eq!(uniform["age"], Value::Age(seeds));
    let one = Value::Number(Number::Whole(1));
    assert_eq!(uniform["eye"], Value::List(vec![Value::Input("eye".into(), None), one]));
    let Action::Draw(draw) = &frame.steps[5].action else { panic!("no draw") };
    let arguments = frame.resource("arguments").unwrap();
    assert_eq!(draw.calls[0].geometry, Geometry::Indirect(arguments, 0));
    let bytes = |name: &str| frame.resources[frame.resource(name).unwrap()].bytes;
    assert_eq!(["arguments", "picture", "seeds"].map(bytes), [16, 32 * 100 * 4, 1600]);
}

#[test]
fn facts_and_uses_set_axes_and_the_host_takes_parts_over() {
    let mut authored = authored();
    let uses = &mut authored.template.get_mut("frame").unwrap().step;
    uses[2].lets.insert("rounds".into(), Text("1".into()));
    let description = authored.description(library()).unwrap();
    let names = |configuration: &Configuration| -> BTreeSet<String> {
        let frame = description.evaluate(configuration).unwrap();
        frame.variants().iter().map(|variant| variant.id.clone()).collect()
    };
    let set =
        |names: &[&str]| -> BTreeSet<String> { names.iter().map(|&name| name.into()).collect() };
    let mut configuration = Configuration::default();
    assert_eq!(names(&configuration), set(&["born", "draw-dot", "move-none", "move-strong"]));
    configuration.facts.insert("windy".into(), true);
    assert_eq!(names(&configuration), set(&["born", "draw-dot", "move-strong"]));
    configuration.parts = Some([String::new()].into());
    assert_eq!(names(&configuration), set(&["born", "move-strong"]));
    let frame = description.evaluate(&configuration).unwrap();
    assert!(frame.resources[frame.resource("picture").unwrap()].external);
}

#[test]
fn a_configuration_is_made_of_the_class_a_preset_and_what_is_set() {
    let description = sparks();
    let set = |list: &[(&str, &str)]| -> BTreeMap<String, Setting> {
        list.iter().map(|(name, text)| ((*name).to_owned(), Setting::read(text))).collect()
    };
    let calm = [("windy".to_owned(), false)].into();
    let made = |preset, list: &[(&str, &str)]| {
        let made = description.configure(&calm, preset, &set(list)).unwrap();
        description.evaluate(&made).unwrap();
        (made.axes, made.parameters)
    };
    let axis = |value: &str| [("wind".to_owned(), value.to_owned())].into();
    let numbers = |list: &[(&str, Number)]| -> BTreeMap<String, Number> {
        list.iter().map(|(name, number)| ((*name).to_owned(), *number)).collect()
    };
    let slow = numbers(&[("speed", Number::Real(0.25)), ("sparks", Number::Whole(50))]);
    assert_eq!(made(None, &[]), (BTreeMap::new(), slow));
    // What is set by hand may make the default meaningless.
    assert_eq!(made(None, &[("rounds", "2")]).1, numbers(&[("rounds", Number::Whole(2))]));
    let (axes, parameters) = made(Some("storm"), &[("speed", "30"), ("wind", "none")]);
    assert_eq!(axes, axis("none"));
    let storm = [("speed", Number::Whole(30)), ("rounds", Number::Whole(8))];
    assert_eq!(parameters, numbers(&[&storm[..], &[("sparks", Number::Whole(50))]].concat()));
    let unknown = description.configure(&calm, Some("rain"), &set(&[])).unwrap_err();
    assert!(unknown.to_string().contains("unknown preset `rain`; expected one of storm"));
    for (name, text, wanted) in [
        ("wind", "7", "unknown value `7`"),
        ("colour", "7", "parameter `colour`"),
        ("colour", "red", "axis `colour`"),
    ] {
        let made = description.configure(&calm, None, &set(&[(name, text)])).unwrap();
        let errors = description.evaluate(&made).unwrap_err().to_string();
        assert!(errors.contains(wanted), "{errors}");
    }
}

#[test]
fn an_excluded_variant_is_an_error_that_names_the_rule() {
    let mut configuration = Configuration::default();
    configuration.axes.insert("shape".into(), "disc".into());
    let errors = sparks().evaluate(&configuration).unwrap_err();
    let text = "step.4: invalid configuration: `draw-disc` is excluded by `dot-is-drawn-alone`: discs \
                are not drawn yet";
    assert_eq!(errors.to_string(), text);
    assert!(errors.is_illegal());
    // Of a pass that lacks one of its axes no rule says anything.
    configuration.axes.insert("shape".into(), "dot".into());
    configuration.axes.insert("wind".into(), "strong".into());
    assert!(sparks().evaluate(&configuration).is_ok());
}

#[test]
fn json_says_the_same() {
    let description = sparks();
    let text = serde_json::to_string(&description).unwrap();
    assert!(text.contains(r#""dispatch":[{"div_ceil":[{"name":"sparks"},64]},1,1]"#), "{text}");
    assert_eq!(serde_json::from_str::<Description>(&text).unwrap(), description);
}

/// Whatever is wrong, as texts.
fn wrong(edits: &[(&str, &str)], configuration: &Configuration) -> Vec<String> {
    let mut text = SPARKS.to_owned();
    for (from, to) in edits {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let authored: Authored = toml::from_str(&text).unwrap();
    match authored.description(library()) {
        Err(faults) => faults.0,
        Ok(description) => {
            let errors = description.evaluate(configuration).unwrap_err();
            errors.0.iter().map(ToString::to_string).collect()
        }
    }
}

#[test]
fn all_that_is_wrong_in_any_configuration_comes_at_once_with_its_place() {
    let found = wrong(
        &[
            ("\"2 * 4\"", "\"2 *\""),
            ("[32, \"sparks\"]", "[32, \"spark\"]"),
            ("value = \"places.front\" }], to", "value = \"places\" }], to"),
            ("input = \"seeds\"", "input = \"seats\""),
            ("eye = [{ input = \"eye\" }, 1]", "eye = [{ input = \"ear\" }, \"shape == 'dots'\"]"),
        ],
        &Configuration::default(),
    );
    let used = ", used by template.frame.step";
    let expected = [
        "template.frame.resource.picture.texture.size.1: unknown name `spark`".to_owned(),
        "template.frame.step.1.names.input: unknown resource `seats`".to_owned(),
        "template.frame.step.3.bytes: not a formula: expected a number, a name or a bracket at character 4, found the end".to_owned(),
        "template.frame.uniform.step.eye.0.input: unknown input `ear`; expected one of eye".to_owned(),
        "template.frame.uniform.step.eye.1: unknown value `dots`; expected one of dot, disc".to_owned(),
        format!("template.motion.step.0.steps.0.bind.from.1.value: of a pair, say `.front` or `.back`{used}.1"),
        format!("template.motion.step.0.steps.0.bind.from.1.value: of a pair, say `.front` or `.back`{used}.2"),
    ];
    assert_eq!(found, expected);
}

#[test]
fn all_that_is_wrong_in_a_configuration_comes_at_once_with_its_place() {
    let mut configuration = Configuration::default();
    configuration.parameters.insert("rounds".into(), Number::Whole(9));
    configuration.parameters.insert("speed".into(), Number::Real(0.0));
    configuration.parameters.insert("colour".into(), Number::Whole(1));
    configuration.axes.insert("wind".into(), "weak".into());
    let edits = [
        ("new = \"seeds\"", "new = \"picture\""),
        ("\"rgba8unorm\"", "\"rgb\""),
        ("\"2 * 4\"", "\"2 / (sparks - 100)\""),
        ("pass = \"draw\"", "pass = \"drew\""),
    ];
    let expected = [
        "axes.wind: unknown value `weak`; expected one of none, strong",
        "exclusion.1: invalid configuration: rounds: below 9",
        "parameters.colour: unknown parameter `colour`; expected one of rounds, sparks, speed",
        "parameters.speed: parameter `speed` is 0; expected a number, above 0",
        "resource.picture: unknown format `rgb`",
        "step.0: `picture` is not kept, so it is never new",
        "step.1.steps.0: unknown value `weak`; expected one of none, strong",
        "step.3: division by zero: `/` of 2, 0",
        "step.4: unknown pass `drew`; expected one of born, draw, move",
    ];
    assert_eq!(wrong(&edits, &configuration), expected);
}

#[test]
fn a_pair_changes_places_as_often_in_every_round() {
    let found = wrong(
        &[(
            "index = \"round\"\nflip = [\"places\"]\n",
            "index = \"round\"\n[[template.motion.step.steps]]\nrepeat = \"round\"\nflip = [\"places\"]\nsteps = [{ clear = \"places.front\" }]\n",
        )],
        &Configuration::default(),
    );
    assert!(
        found[0].contains(
            "template.motion.step.0.flip: `slow_places` changes places in some rounds alone"
        ),
        "{found:?}"
    );
}
