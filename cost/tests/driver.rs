//! The whole way with the installed driver, without the test harness, because the program runs itself as the child.

#![allow(clippy::unwrap_used)] // Clippy takes only functions of the harness for tests.

use std::path::{Path, PathBuf};
use std::time::Duration;

use sglow_cost::{
    Costs, Error, Program, RADEON_ICD, Relation, Request, Shader, compare, compile, serve,
};

fn program(arguments: &[&str]) -> Program {
    Program {
        path: std::env::current_exe().unwrap(),
        arguments: arguments.iter().map(|word| (*word).to_owned()).collect(),
        icd: RADEON_ICD.into(),
        jobs: 2,
        limit: Duration::from_secs(60),
    }
}

fn request(family: &str, names: &[&str]) -> Request {
    let shader = |name: &&str| Shader {
        id: (*name).to_owned(),
        entry_point: "main".to_owned(),
        path: PathBuf::from(format!("{}/tests/spirv/{name}.spv", env!("CARGO_MANIFEST_DIR"))),
    };
    Request { family: family.to_owned(), shaders: names.iter().map(shader).collect() }
}

fn costs(family: &str) -> Costs {
    compile(&program(&["serve"]), &request(family, &["plain", "spill", "zeroed"])).unwrap()
}

fn main() {
    match std::env::args().nth(1).as_deref() {
        Some("serve") => return serve().unwrap(),
        Some("abort") => std::process::abort(),
        Some("talk") => return println!("good day"),
        Some("sleep") => return std::thread::sleep(Duration::from_secs(60)),
        _ => {}
    }
    if !Path::new(RADEON_ICD).exists() {
        println!("skipped: {RADEON_ICD} is missing (Debian: mesa-vulkan-drivers)");
        return;
    }
    private_memory_is_a_fault_and_nothing_else_is();
    two_runs_are_the_same_and_families_are_not_compared();
    broken_children_are_named();
    println!("ok");
}

fn private_memory_is_a_fault_and_nothing_else_is() {
    for family in ["navi21", "vega10"] {
        let costs = costs(family);
        assert_eq!(costs.costs.len(), 3);
        assert!(costs.skipped.is_empty());
        assert!(costs.compiler.device.to_lowercase().contains(family));
        let [plain, spill, zeroed] = &costs.costs[..] else { unreachable!() };
        assert!(spill.scratch_bytes >= 2048 * 4, "{spill:?}");
        assert!(spill.loops >= 1 && spill.loop_issue_cycles.is_some_and(|cycles| cycles > 0));
        assert!(plain.instructions > 0 && plain.loops == 0 && plain.loop_instructions.is_none());
        assert_eq!(zeroed.lds_bytes, 256 * 4);
        let faults = compare(&costs, &costs).faults;
        assert!(faults.iter().all(|fault| fault.id == "spill"));
        assert!(faults.iter().any(|fault| fault.figure == "scratch_bytes"));
    }
}

fn two_runs_are_the_same_and_families_are_not_compared() {
    let first = costs("navi21");
    assert_eq!(first, costs("navi21"));
    // Neither the number of processes nor what else is compiled changes a figure.
    let alone = compile(&program(&["serve"]), &request("navi21", &["plain"])).unwrap();
    assert_eq!(alone.costs[..], first.costs[..1]);
    let other = compare(&first, &costs("vega10"));
    assert!(matches!(other.relation, Relation::OtherCompiler { .. }));
    assert!(other.differences.is_empty());
}

fn broken_children_are_named() {
    let error = |program: &Program, family: &str| {
        compile(program, &request(family, &["plain"])).unwrap_err()
    };
    assert!(matches!(error(&program(&["abort"]), "navi21"), Error::Ended { .. }));
    assert!(matches!(error(&program(&["talk"]), "navi21"), Error::Message { .. }));
    let slow = Program { limit: Duration::from_millis(200), ..program(&["sleep"]) };
    assert!(matches!(error(&slow, "navi21"), Error::TooLong { .. }));
    let unknown = error(&program(&["serve"]), "navi999").to_string();
    assert!(unknown.contains("navi999"), "{unknown}");
    println!("{unknown}");
    let no_driver = Program { icd: "/nowhere.json".into(), ..program(&["serve"]) };
    assert!(matches!(error(&no_driver, "navi21"), Error::Icd(_)));
    let missing = compile(&program(&["serve"]), &request("navi21", &["none"])).unwrap_err();
    assert!(missing.to_string().contains("none.spv"), "{missing}");
}
