//! The foreign library broken on purpose: every error says what, where, and what would be right.

use sglow_shader_gen::functions::functions;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::validate::Validated;
use sglow_shader_gen::{frame, generate, manifest};

use crate::edited;

/// What is said of the foreign library after `edits`: in the file, the one text for the other.
fn report(edits: &[(&str, &str, &str)]) -> String {
    let folder = edited(edits);
    let result = Library::load(folder.path()).and_then(|library| {
        let variants = generate::variants(&library, &library.variants())?;
        let reflected = |one: &Validated| {
            let reflection = manifest::reflect(&one.text, &one.module, &one.info).unwrap();
            manifest::variant(&library, one, &reflection, Vec::new())
        };
        frame::check(&library, &variants.iter().map(reflected).collect::<Vec<_>>())?;
        functions(&library)
    });
    match result {
        Ok(_) => "nothing is wrong".to_owned(),
        Err(report) => report.to_string(),
    }
}

macro_rules! errors {
    ($($name:ident: $($edit:expr),+;)+) => {
        $(
            #[test]
            fn $name() {
                insta::with_settings!({ omit_expression => true }, {
                    insta::assert_snapshot!(stringify!($name), report(&[$($edit),+]));
                });
            }
        )+
    };
}

const COUNT: &str = "src/image/count.wesl";
const CHANNEL: &str = "src/image/channel.wesl";
const BIN: &str = "src/image/bin.wesl";
const SCAN: &str = "src/sum/scan.wesl";
const TOML: &str = "library.toml";
const FRAME: &str = "frame.toml";

#[test]
fn nothing_is_wrong_with_the_library_itself() {
    assert_eq!(report(&[(TOML, "", "")]), "nothing is wrong");
}

errors! {
    a_frame_that_is_no_toml: (FRAME, "[template.frame.let]", "[template.frame.let");
    a_frame_that_says_what_the_language_does_not: (FRAME, "external = true", "extern = true");
    formulas_that_are_none:
        (FRAME, "size = [\"width\", \"height\"]", "size = [\"width *\", \"3 heights\"]"),
        (FRAME, "bins = 256", "bins = \"256 +\""),
        (FRAME, "div_ceil(width, 256)", "div_ceil(width)"),
        (FRAME, "counter == 'workgroup', 1, height", "counter == 'workgruop', 1, height");
    a_let_that_depends_on_itself: (FRAME, "bins = 256", "bins = \"bars + 1\"\nbars = \"bins - 1\"");
    aliases_and_templates_that_stand_for_themselves:
        (FRAME, "[template.frame.uniform.settings]", "[template.frame.alias]\nfirst = \"second\"\nsecond = \"first\"\n[template.again]\n[[template.again.step]]\nuse = \"again\"\n[template.frame.uniform.settings]"),
        (FRAME, "tally_image = \"image\"", "tally_image = \"first\""),
        (FRAME, "[[template.frame.step]]\nclear = \"counted\"", "[[template.frame.step]]\nuse = \"again\"\n[[template.frame.step]]\nclear = \"counted\"");
    resources_and_steps_that_are_nothing_or_two_things:
        (FRAME, "texture = { format = \"rgba8unorm\", size = [\"bins\", 64] }", ""),
        (FRAME, "flip = true\n", "flip = true\nsampler = \"linear\"\n"),
        (FRAME, "label = \"count\"\n", "label = \"count\"\nclear = \"counted\"\n");
    parameters_that_are_not_known_or_cannot_be:
        (FRAME, "rounds = \"height\"", "rounds = \"heights\""),
        (FRAME, "repeat = \"again\"", "repeat = \"agian\""),
        (FRAME, "default = 0\nmaximum = 4", "default = 5\nmaximum = 4"),
        (FRAME, "default = 360\nminimum = 1", "default = 360\nminimum = 400");
    numbers_that_do_not_exist:
        (FRAME, "\"width\", \"height\"", "\"width / again\", \"height - 2\""),
        (FRAME, "[\"bins\", 64]", "[\"bins << 60\", 64]");
    names_in_a_frame_that_nothing_declares:
        (FRAME, "size = [\"width\"", "size = [\"widht\""),
        (FRAME, "input = \"first_column\"", "input = \"column\""),
        (FRAME, "pass = \"show\"", "pass = \"showing\""),
        (FRAME, "tally_image = \"image\"", "tally_image = \"images\""),
        (FRAME, "flip = [\"sums\"]", "flip = [\"counted\"]"),
        (FRAME, "tally_heights = \"sums.front\"", "tally_heights = \"sums\""),
        (FRAME, "uniforms = { tally_settings = \"settings\" }", "uniforms = { tally_settings = \"settings\", more = \"setting\" }");
    what_is_read_before_it_is_written:
        (FRAME, "tally_heights = \"sums.front\"", "tally_heights = \"sums.back\""),
        (FRAME, ", initial = [6, 256, 0, 0]", "");
    what_does_not_fit_its_binding:
        (FRAME, "value = \"r8unorm\"", "value = \"r8uint\""),
        (FRAME, "kept = true\nbuffer = { length = \"bins\", stride = 4 }", "kept = true\nbuffer = { length = \"bins\", stride = 8 }"),
        (FRAME, "tally_sums = \"sums.front\"", "tally_sums = \"picture\"");
    bindings_without_a_resource_and_resources_without_a_binding:
        (FRAME, "tally_image = \"image\", ", ""),
        (FRAME, "rounds = \"height\"\n", ""),
        (FRAME, "tally_input = \"counted\"", "tally_inputs = \"counted\"");
    an_unknown_flag: (CHANNEL, "@if(channel_red)", "@if(channel_read)");
    a_name_that_is_declared_twice: (CHANNEL, "fn tally_smallest(", "fn tally_largest(");
    a_name_that_two_files_declare: (CHANNEL, "fn tally_smallest(", "fn tally_bin(");
    a_name_without_the_prefix:
        (BIN, "fn tally_middle(", "fn middle("),
        (BIN, "TALLY_LAST = ", "tally_last = "),
        (BIN, ", TALLY_LAST)", ", tally_last)"),
        (COUNT, "struct TallySettings", "struct tally_settings_type"),
        (COUNT, ": TallySettings", ": tally_settings_type");
    an_import_that_is_missing: (COUNT, "import package::image::channel::tally_channel;", "");
    an_import_of_what_is_not_there:
        (COUNT, "{TALLY_BINS, tally_bin}", "{TALLY_BINS, tally_bin, tally_box}"),
        (SCAN, "package::image::bin", "package::image::bins");
    an_import_under_a_condition: (COUNT, "import package::image::channel", "@if(channel_mean) import package::image::channel");
    an_import_that_renames: (COUNT, "tally_bin}", "tally_bin as bin}");
    a_declaration_that_conditions_leave_out: (CHANNEL, "@else\n", "@elif(channel_largest && counter_workgroup)\n");
    an_else_without_an_if: (SCAN, "@if(!inclusive) tally_sums", "let x = 1; @else tally_sums");
    a_condition_that_does_not_end: (CHANNEL, "@if(channel_red)", "@if(channel_red || (inclusive)");
    a_condition_in_the_middle: (CHANNEL, "fn tally_largest(colour", "fn tally_largest(@if(inclusive) colour");
    a_block_that_does_not_end: (SCAN, "tally_sums[0] = 1u;\n}", "tally_sums[0] = 1u;\n");
    a_statement_that_does_not_end: (SCAN, "= 0u;", "= 0u");
    a_comment_that_does_not_end: (CHANNEL, "nest. */ */", "nest. */");
    a_hexadecimal_float: (BIN, "+ 0.5)", "+ 0x1p-1)");
    a_path_in_an_expression: (COUNT, "tally_bin(tally_channel(pixel))], 1u);\n            }", "package::image::bin::tally_bin(0.0)], 1u);\n            }");
    an_entry_point_that_conditions_leave_out: (SCAN, "/// Sets all sums to zero.\n", "@if(inclusive)\n");
    an_import_behind_a_declaration: (SCAN, "/// Sets all sums to zero.", "import package::image::bin::{TALLY_LAST};");
    what_naga_cannot_read: (CHANNEL, "return pixel.r;", "return pixel.r + missing;");
    what_naga_finds_invalid: (CHANNEL, "return pixel.r;", "return vec2<f32>(pixel.r);");
    two_bindings_in_one_place: (SCAN, "@binding(1)", "@binding(0)");
    an_override_that_is_not_declared: (TOML, "name = \"tally_gain\"", "name = \"tally_loss\"");
    a_function_library_with_bindings: (TOML, "[\"image/bin.wesl\"]", "[\"sum/scan.wesl\"]");
    functions_that_no_library_has: (TOML, "[\"image/bin.wesl\"]", "[\"image/channel.wesl\"]");
    a_pass_with_the_name_of_the_library: (TOML, "name = \"scan\"\nde", "name = \"tally\"\nde");
    a_contract_of_what_is_not_known:
        (TOML, "contract = [\"image", "contract = [{ text = \"rounds: 1\", when = { counter = [\"group\"], order = [\"exclusive\"] } }, \"image");
    a_contract_that_is_no_line: (TOML, "contract = [\"image", "contract = [{ text = \"rounds: 1\" }, \"image");
    a_field_that_is_not_known: (TOML, "default = \"mean\"", "defualt = \"mean\"");
    a_presence_that_leaves_nothing_out:
        (TOML, "only_with = [{ channel = [\"mean\"], counter = [\"workgroup\"] }, { channel = [\"largest\"] }]", "only_with = [{}]"),
        (TOML, "passes = [\"scan\"]", "passes = []");
    a_presence_of_what_is_not_known:
        (TOML, "passes = [\"scan\"]", "passes = [\"scan\", \"sort\", \"count\"]"),
        (TOML, "when = { order = [\"exclusive\"] }", "when = { order = [\"both\"] }"),
        (TOML, "{ channel = [\"largest\"] }", "{ colour = [\"largest\"] }"),
        (TOML, "counter = [\"workgroup\"] }, {", "counter = [\"group\"] }, {");
    an_implied_axis_that_is_not_the_last: (TOML, "default = \"mean\"\n", "default = \"mean\"\nimplied = true\n");
    many_at_once:
        (TOML, "axes = [\"channel\", \"counter\"]", "axes = [\"channel\", \"place\"]"),
        (TOML, "default = \"inclusive\"", "default = \"both\""),
        (TOML, "entry_points = [\"tally_scan\", \"tally_clear\"]", "entry_points = [\"tally_scan\", \"tally_clean\"]"),
        (TOML, "when = { coloured = false }", "when = { colored = false }"),
        (TOML, "set = { counter = [\"direct\"] }", "set = { counter = [\"indirect\"] }"),
        (TOML, "source = \"sum/scan.wesl\"", "source = \"sum/sort.wesl\""),
        (TOML, "description = \"it does not\"", "description = \"it does not\"\nrequires = [\"ray-tracing\"]"),
        (TOML, "{ pass = \"scan\"", "{ pass = \"sort\""),
        (CHANNEL, "@elif(channel_mean)", "@elif(channel_mien)");
}

/// The foreign library with presets and defaults by class.
fn with_presets(text: &str) -> String {
    report(&[(TOML, "[package]", &format!("{text}\n[package]"))])
}

#[test]
fn presets_and_defaults_name_axes_parameters_and_values() {
    let preset = |set: &str| {
        let preset = "[[preset]]\nname = \"quick\"\ndescription = \"rough\"";
        with_presets(&format!("{preset}\nset = {{ {set} }}\n"))
    };
    assert_eq!(preset("channel = \"mean\", again = 4"), "nothing is wrong");
    for (set, wanted) in [
        ("channel = \"meen\"", "meen"),
        ("colour = \"red\"", "axis or parameter"),
        ("again = \"often\"", "parameter `again` is often; expected a whole number, at most 4"),
        ("again = 5", "parameter `again` is 5; expected a whole number, at most 4"),
        ("again = -1", "parameter `again` is -1; expected a whole number"),
    ] {
        let text = preset(set);
        assert!(text.contains(wanted) && text.contains("library.toml"), "{text}");
    }
    let default = |when: &str| {
        with_presets(&format!(
            "[[default]]\nname = \"grey\"\nwhen = {{ {when} }}\nset = {{ channel = \"mean\" }}\nreason = \"why\"\n"
        ))
    };
    assert_eq!(default("coloured = false"), "nothing is wrong");
    assert!(default("colored = false").contains("colored"));
    assert_eq!(default("channel = [\"mean\"]"), "nothing is wrong");
    assert!(default("channel = [\"meen\"]").contains("meen"));
    assert!(default("canal = [\"mean\"]").contains("canal"));
    assert!(default("channel = \"mean\"").contains("list of values"));
    let unless = |name: &str| {
        with_presets(&format!(
            "[[default]]\nname = \"grey\"\nwhen = {{}}\nset = {{}}\nunless = [\"{name}\"]\nreason = \"why\"\n"
        ))
    };
    assert_eq!(unless("channel"), "nothing is wrong");
    assert_eq!(unless("again"), "nothing is wrong");
    assert!(unless("agein").contains("axis or parameter"), "{}", unless("agein"));
    let twice = "[[preset]]\nname = \"quick\"\ndescription = \"rough\"\nset = {}\n".repeat(2);
    assert!(with_presets(&twice).contains("declared twice"));
}

#[test]
fn presets_that_a_program_wrote_are_read_and_those_that_are_none_refused() {
    use sglow_shader_gen::library::{Measurement, Preset, PresetFile, Setting};
    let header = [(TOML, "source = \"src\"", "source = \"src\"\npresets = \"more.toml\"")];
    let folder = edited(&header);
    let load = || Library::load(folder.path());
    assert!(load().unwrap().preset.is_empty(), "the file need not exist");
    let measured = Measurement {
        input: "scene".to_owned(),
        device: "none".to_owned(),
        milliseconds: 1.5,
        errors: [("rmse".to_owned(), 0.25)].into(),
    };
    let preset = Preset {
        name: "quick".to_owned(),
        description: "rough".to_owned(),
        set: [("channel".to_owned(), Setting::read("mean"))].into(),
        measured: vec![measured],
    };
    let file = PresetFile { preset: vec![preset.clone()] };
    let path = folder.path().join("more.toml");
    std::fs::write(&path, file.text().unwrap()).unwrap();
    let library = load().unwrap();
    assert_eq!(library.find_preset("quick").unwrap(), &preset);
    let text = library.find_preset("slow").unwrap_err().to_string();
    assert!(text.contains("slow") && text.contains("quick"), "{text}");
    std::fs::write(&path, "preset = 3").unwrap();
    assert!(load().unwrap_err().to_string().contains("more.toml"));
}

#[test]
fn chains_of_declarations_are_bounded() {
    let chain = |length: usize| {
        let import = "import package::image::bin::{TALLY_BINS};\n";
        let link = |n: usize| format!("const TALLY_C{} = TALLY_C{n} + 1;\n", n + 1);
        let links: String = (0..length).map(link).collect();
        let text = format!("{import}const TALLY_C0 = 1;\n{links}");
        report(&[("src/sum/scan.wesl", import, &text)])
    };
    let limit = "more than 200 declarations";
    let (longest, longer) = (chain(200), chain(201));
    assert!(!longest.contains(limit), "{longest}");
    assert!(longer.contains(limit), "{longer}");
}
