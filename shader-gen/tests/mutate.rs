//! Libraries with seeded mutations of their sources, declarations and frames: none may panic, overflow the stack, run long
//! or take much memory, and what is taken becomes a whole package.

#![allow(clippy::panic, clippy::unwrap_used, reason = "helpers of tests are tests, too")]

use std::alloc::System;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use cap::Cap;
use sglow_fuzz::{Case, MAXIMUM_MEMORY, MAXIMUM_SIZE, MAXIMUM_TIME, Target, corpus};
use sglow_shader_gen::functions::functions;
use sglow_shader_gen::generate;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::package::{self, Parts};

/// Beyond this limit allocation fails, and the process ends.
#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MAXIMUM_MEMORY);

const WORDS: [&[u8]; 72] = [
    b"@if(",
    b"@if(inclusive) ",
    b"@elif(channel_mean) ",
    b"@else ",
    b"@if(!inclusive || channel_red && true) {",
    b"((((((((",
    b"))))))))",
    b"!!!!!!!!",
    b"{",
    b"}",
    b"/*",
    b"*/",
    b"//",
    b";",
    b"import package::image::bin::{",
    b"import package::sum::scan::tally_scan;",
    b"package::",
    b"fn tally_x() {",
    b"struct TallyX {",
    b"array<",
    b"vec4<f32>(",
    b"override ",
    b"const TALLY_X = ",
    b"alias TallyX = ",
    b"var<workgroup> ",
    b"@group(0) @binding(0) ",
    b"@group(4294967296)",
    b"@workgroup_size(1, 1, 1)",
    b"@compute ",
    b"const_assert ",
    b"enable f16;",
    b"0x1p-1",
    b"1e999",
    b"else if (true) {",
    b"for (var i = 0u; i < 4u; i++) {",
    b"switch 1 { default: {",
    b"loop {",
    b"continuing {",
    b"return",
    b"tally_",
    b"tally_channel(",
    b"TallySettings",
    b"\xe2\x80\x8b",
    b"[[pass]]\n",
    b"[[axis.channel.value]]\n",
    b"[[exclusion]]\n",
    b"[package]\n",
    b"[library]\n",
    b"[[preset]]\nname = \"x\"\n",
    b"../../",
    b"source = \"../..\"",
    b"when = { ",
    b"select = [",
    b"axes = [\"channel\", ",
    b"default = ",
    b"implied = true\n",
    b"replace = true\n",
    b"minimum = nan\n",
    b"[template.x]\n",
    b"[[template.frame.step]]\n",
    b"repeat = \"",
    b"size = [\"",
    b"bins << 63",
    b"div_ceil(width, 0)",
    b"select(1, 2, 3)",
    b"pow2_ceil(",
    b"18446744073709551615",
    b"height - width",
    b"use = \"frame\"\n",
    b"flip = true\n",
    b"when = \"channel == 'mean'\"\n",
    b"a.a.a.a.a.a.a.a",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")
}

/// Writes files into a folder.
fn write(folder: &Path, cases: &[Case]) {
    for case in cases {
        let path = folder.join(&case.name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, &case.bytes).unwrap();
    }
}

/// Reads a library and makes its package in memory, as far as there is one.
fn made(folder: &Path, over: &[PathBuf]) -> bool {
    let library = match Library::load_with(folder, over) {
        Ok(library) => library,
        Err(report) => {
            assert!(!report.to_string().is_empty());
            return false;
        }
    };
    let variants = library.selected();
    let (validated, functions) =
        match (generate::variants(&library, &variants), functions(&library)) {
            (Ok(validated), Ok(functions)) => (validated, functions),
            (validated, functions) => {
                for report in validated.err().iter().chain(functions.err().iter()) {
                    assert!(!report.to_string().is_empty());
                }
                return false;
            }
        };
    let parts = Parts {
        library: &library,
        variants: &validated,
        functions: functions.as_ref(),
        changelog: None,
        source_hash: "",
        purpose: None,
    };
    match package::build(&parts, &BTreeSet::from(package::Target::ALL)) {
        Err(error) => {
            assert!(!error.to_string().is_empty());
            false
        }
        Ok(files) => {
            assert!(files.keys().all(|path| sglow_seal::is_inside(path)));
            true
        }
    }
}

#[test]
fn no_mutated_library_panics_runs_long_or_takes_much_memory() {
    let (foreign, over) = (corpus(&root().join("foreign")), corpus(&root().join("over")));
    let folder = tempfile::tempdir().unwrap();
    let [below, above] = ["foreign", "over"].map(|name| folder.path().join(name));
    write(&below, &foreign);
    write(&above, &over);
    let tried = Target::new("library", 40).run(&foreign, &WORDS, |case| {
        let file = below.join(&case.name);
        let whole = fs::read(&file).unwrap();
        fs::write(&file, &case.bytes).unwrap();
        let made = made(&below, &[]);
        fs::write(&file, whole).unwrap();
        made
    });
    // Both happen, or the mutations are no test.
    assert!(tried.refused > 10 && tried.taken > 10, "{tried:?}");
    let tried = Target::new("overlay", 60).run(&over, &WORDS, |case| {
        let file = above.join(&case.name);
        let whole = fs::read(&file).unwrap();
        fs::write(&file, &case.bytes).unwrap();
        let made = made(&below, std::slice::from_ref(&above));
        fs::write(&file, whole).unwrap();
        made
    });
    assert!(tried.refused > 10 && tried.taken > 10, "{tried:?}");
}

/// Sources of at most 64 KB that nest, repeat or refer to each other as far as that goes.
#[test]
fn no_crafted_library_panics_runs_long_or_takes_much_memory() {
    let fill = |piece: &str| piece.repeat(MAXIMUM_SIZE / piece.len());
    let many = |of: &dyn Fn(usize) -> String| {
        let mut text = String::new();
        for number in 0.. {
            let next = of(number);
            if text.len() + next.len() > MAXIMUM_SIZE {
                break;
            }
            text += &next;
        }
        text
    };
    let body = |text: &str| format!("fn tally_x() {{\n    var x = 1.0;\n    {text}\n}}\n");
    let wesl = [
        body(&fill("{")),
        body(&format!("x = {}x;", fill("("))),
        body(&format!("x = {}x;", fill("-"))),
        body(&format!("x = {}x;", fill("x + "))),
        body(&format!("x = {};", fill("abs("))),
        body(&format!("x = x{};", fill(".x"))),
        body(&format!("x = x{};", fill("[0]"))),
        body(&fill("if (x > 0.0) { x = 1.0; } else ")),
        body(&fill("if (x > 0.0) { x = 1.0; }\n")),
        body(&fill("loop { break; }\n")),
        body(&fill("@if(inclusive) { x = 1.0; } @else { x = 2.0; }\n")),
        body(&fill("@if(inclusive) ")),
        body(&format!("@if({}inclusive) x = 1.0;", fill("!"))),
        body(&format!("@if({}inclusive) x = 1.0;", fill("inclusive || "))),
        many(&|n| format!("@elif(inclusive) const TALLY_{n} = 1;\n")),
        format!(
            "@if(inclusive) const TALLY = 1;\n{}",
            many(&|n| format!("@elif(inclusive) const TALLY_{n} = 1;\n"))
        ),
        format!(
            "fn tally_f0() {{}}\n{}",
            many(&|n| format!("fn tally_f{}() {{ tally_f{n}(); }}\n", n + 1))
        ),
        format!(
            "const TALLY_C0 = 1;\n{}",
            many(&|n| format!("const TALLY_C{} = TALLY_C{n} + 1;\n", n + 1))
        ),
        format!(
            "alias TallyA0 = f32;\n{}",
            many(&|n| format!("alias TallyA{} = TallyA{n};\n", n + 1))
        ),
        format!(
            "struct TallyS0 {{ a: f32 }}\n{}",
            many(&|n| format!("struct TallyS{} {{ a: TallyS{n}, b: TallyS{n} }}\n", n + 1))
        ),
        "fn tally_a() { tally_b(); }\nfn tally_b() { tally_a(); }\n".to_owned(),
        format!("var<private> tally_v: {}f32{};\n", "array<".repeat(5000), ", 2>".repeat(5000)),
        "var<private> tally_v: array<array<array<array<f32, 60000>, 60000>, 60000>, 60000>;\n"
            .to_owned(),
        "const TALLY_C = array<f32, 4000000000>();\n".to_owned(),
        "const TALLY_C = 1u << 40u;\nconst TALLY_D = 1 / 0;\nconst TALLY_E = -2147483648 / -1;\n"
            .to_owned(),
        fill("/*"),
        fill("@"),
        fill("import package::a::{"),
        fill("struct "),
        fill("\u{feff}"),
    ];
    let declared = [
        fill("["),
        fill("a."),
        fill("[[pass]]\n"),
        fill("a = [\n"),
        fill("a = {a = "),
        format!("a = {}", fill("[")),
        format!("x = \"{}", fill("\\")),
        format!("x = {}", fill("9")),
        format!("[library]\nname = \"{}\"", fill("x")),
        many(&|n| format!("[axis.a{n}]\ndefault = \"x\"\n")),
        "\u{feff}[library]\n".to_owned(),
        "[library]\r[library]\r".to_owned(),
    ];
    let (foreign, folder) = (corpus(&root().join("foreign")), tempfile::tempdir().unwrap());
    let text = |name: &str| {
        let case = foreign.iter().find(|case| case.name == name).unwrap();
        String::from_utf8(case.bytes.clone()).unwrap()
    };
    let place = ["src/sum/scan.wesl", "library.toml", "frame.toml"];
    let [scan, library, frame] = place.map(text);
    let formula = |of: String| {
        (place[2], frame.replacen("\"div_ceil(width, 256)\"", &format!("\"{of}\""), 1))
    };
    let mut inputs: Vec<(&str, String)> = Vec::new();
    for wesl in &wesl {
        inputs.push((place[0], format!("{scan}\n{wesl}")));
    }
    for text in &declared {
        inputs.extend([(place[1], text.clone()), (place[2], text.clone())]);
        inputs.extend([
            (place[1], format!("{library}\n{text}")),
            (place[2], format!("{frame}\n{text}")),
        ]);
    }
    inputs.extend([
        formula(fill("(")),
        formula(fill("!")),
        formula(format!("{}1", fill("1 + "))),
        formula(format!("{}1{}", "max(1, ".repeat(60), ")".repeat(60))),
        formula("18446744073709551615 * width".to_owned()),
        formula("1 << width".to_owned()),
        formula("width / (height - height)".to_owned()),
    ]);
    write(folder.path(), &foreign);
    let mut refused = 0;
    for (number, (name, input)) in inputs.iter().enumerate() {
        let file = folder.path().join(name);
        let whole = fs::read(&file).unwrap();
        fs::write(&file, input).unwrap();
        let start = std::time::Instant::now();
        let shown = &input[input.len().saturating_sub(60)..];
        println!("{number}: {name}: …{shown}");
        refused += usize::from(!made(folder.path(), &[]));
        assert!(start.elapsed() < MAXIMUM_TIME, "{name}: runs long: …{shown}");
        fs::write(&file, whole).unwrap();
    }
    assert!(refused > 40 && refused < inputs.len(), "{refused} of {}", inputs.len());
}
