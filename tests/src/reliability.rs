//! `docs/reliability.md`: each test that it names exists; nothing opens a connection.

use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The tests that a page names, as `file.rs: name`, that are not in the sources.
fn missing(page: &str) -> (usize, Vec<String>) {
    let quoted: Vec<&str> = page.split('`').skip(1).step_by(2).collect();
    let named = quoted.iter().filter_map(|one| Some((*one, one.split_once(".rs: ")?)));
    let named: Vec<_> = named.collect();
    let there = |(file, name): &(&str, &str)| {
        let text = std::fs::read_to_string(root().join(format!("{file}.rs"))).unwrap_or_default();
        let test = text.split("#[test]").skip(1);
        let mut heads = test.filter_map(|rest| rest.split_once("fn ")?.1.split_once('('));
        heads.any(|(found, _)| found == *name)
    };
    let lacking = named.iter().filter(|(_, test)| !there(test));
    (named.len(), lacking.map(|(whole, _)| (*whole).to_owned()).collect())
}

#[test]
fn every_promise_has_its_test() {
    let page = std::fs::read_to_string(root().join("docs/reliability.md")).unwrap();
    let (count, lacking) = missing(&page);
    assert!(count > 35, "{count}");
    assert_eq!(lacking, Vec::<String>::new());
    // Every row of a table of promises names one.
    for line in page.lines().filter(|line| line.starts_with("| ") && !line.contains("| test |")) {
        assert!(line.contains(".rs: "), "{line}");
    }
    let wrong = "`tests/src/reliability.rs: no_such_test`, `tests/src/reliability.rs: missing`";
    assert_eq!(missing(wrong).1.len(), 2);
}

/// Crates that open connections.
const NETWORK: [&str; 10] = [
    "curl",
    "hyper",
    "isahc",
    "mio",
    "native-tls",
    "openssl",
    "reqwest",
    "rustls",
    "tokio",
    "ureq",
];

/// Whether a text opens a connection by itself.
fn connects(text: &str) -> bool {
    ["std::net", "TcpStream", "TcpListener", "UdpSocket"].iter().any(|name| text.contains(name))
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for path in std::fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn nothing_opens_a_connection() {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut tree = Command::new(cargo);
    tree.args(["tree", "--package", "xtask", "--edges", "normal", "--prefix", "none", "--offline"]);
    let output = tree.current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let names: Vec<&str> = text.lines().filter_map(|line| line.split(' ').next()).collect();
    assert!(names.len() > 100 && names.contains(&"wgpu"));
    for name in NETWORK {
        assert!(!names.contains(&name), "{name}");
    }
    let mut files = Vec::new();
    for entry in std::fs::read_dir(root()).unwrap() {
        sources(&entry.unwrap().path().join("src"), &mut files);
    }
    assert!(files.len() > 200, "{}", files.len());
    let own = files.iter().filter(|path| !path.ends_with("tests/src/reliability.rs"));
    let connecting: Vec<_> =
        own.filter(|path| connects(&std::fs::read_to_string(path).unwrap())).collect();
    assert!(connecting.is_empty(), "{connecting:?}");
    assert!(connects("use std::net::TcpStream;"));
}
