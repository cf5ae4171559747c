//! Drawings of a made-up frame: nothing covers anything, and what does is noticed.

use std::collections::BTreeMap;

use sglow_graph::Configuration;

use crate::page::graph::content::{Content, Kept, Part, Resource, Step, Use, Work, bytes};
use crate::page::graph::faults::faults;
use crate::page::graph::fold::rows;
use crate::page::graph::layout::Layout;
use crate::page::graph::{drawing, layout, text};

fn made_up() -> Content {
    let resource = |name: &str, part: &str, side: u64| Resource {
        name: name.to_owned(),
        part: part.to_owned(),
        kind: Kept::Texture {
            format: "rgba32float".to_owned(),
            size: [side, side],
            layers: 1,
            levels: 1,
        },
        bytes: 16 * side * side,
        external: name == "given",
        kept: name == "history",
    };
    let used = |names: &[&str]| -> Vec<Use> {
        let one = |name: &&str| Use {
            resource: (*name).to_owned(),
            level: None,
            by: "binding".to_owned(),
        };
        names.iter().map(one).collect()
    };
    let step = |part: &str, pass: &str, reads: &[&str], writes: &[&str]| Step {
        place: format!("step.{pass}"),
        part: part.to_owned(),
        label: pass.to_owned(),
        pass: Some(pass.to_owned()),
        variants: vec![format!("{pass}-one-two")],
        entry: None,
        work: Work::Dispatch { workgroups: [80, 45, 1] },
        constants: BTreeMap::new(),
        first_frame_of: None,
        reads: used(reads),
        writes: used(writes),
    };
    let steps = vec![
        step("first", "moments", &["given"], &["moments"]),
        step("first", "history_of_a_long_name", &["moments", "history"], &["history"]),
        step("second", "blur", &["moments", "history"], &["out"]),
        step("second", "blur", &["moments", "history"], &["out"]),
    ];
    let resources = vec![
        resource("moments", "first", 256),
        resource("history", "first", 64),
        resource("given", "first", 16),
        resource("out", "second", 640),
    ];
    let part = |name: &str| Part {
        name: name.to_owned(),
        bytes: resources.iter().filter(|one| one.part == name).map(|one| one.bytes).sum(),
        resources: resources.iter().filter(|one| one.part == name).count(),
        steps: 2,
    };
    Content {
        title: "made up, 640 x 360".to_owned(),
        changed: vec!["axis=value".to_owned(); 40],
        configuration: Configuration::default(),
        bytes: resources.iter().map(|one| one.bytes).sum(),
        external_bytes: 16 * 16 * 16,
        parts: vec![part("first"), part("second")],
        resources,
        steps,
    }
}

fn laid_out() -> Layout {
    let content = made_up();
    layout::layout(&content, &rows(&content.steps))
}

#[test]
fn nothing_is_on_top_of_something_else() {
    assert_eq!(faults(&laid_out()), [""; 0]);
    let empty =
        Content { steps: Vec::new(), resources: Vec::new(), parts: Vec::new(), ..made_up() };
    assert_eq!(super::faults(&empty), [""; 0]);
}

#[test]
fn what_is_on_top_or_outside_is_noticed() {
    type Change = fn(&mut Layout);
    let changes: [(&str, Change); 6] = [
        ("on top of `", |drawing| drawing.texts[1].y = drawing.texts[0].y),
        ("leaves the drawing", |drawing| drawing.width /= 2.0),
        ("leaves the drawing", |drawing| drawing.height -= 60.0),
        ("on top of a bar", |drawing| {
            let bar = drawing.shapes.iter().find(|shape| shape.fill == layout::Fill::Bytes);
            let place = bar.unwrap().place;
            let text = &mut drawing.texts[2];
            (text.x, text.y, text.slanted) = (place.x, place.y + place.height, false);
        }),
        ("on top of a mark", |drawing| {
            let mark = drawing.marks[3].clone();
            (drawing.texts[0].x, drawing.texts[0].y) = (mark.x, mark.y);
        }),
        ("marks are on top", |drawing| drawing.marks[4].x = drawing.marks[5].x),
    ];
    for (wanted, change) in changes {
        let mut drawing = laid_out();
        change(&mut drawing);
        let faults = faults(&drawing);
        assert!(faults.iter().any(|fault| fault.contains(wanted)), "{wanted}: {faults:?}");
    }
    // Names that rise less steeply than their columns are apart would touch.
    let mut drawing = laid_out();
    for text in drawing.texts.iter_mut().filter(|text| text.slanted) {
        text.slanted = false;
    }
    assert!(!faults(&drawing).is_empty());
}

#[test]
fn the_largest_has_the_longest_bar_and_each_step_is_there_once() {
    let text = text(&made_up());
    let bar = |name: &str| {
        let line = text.lines().find(|line| line.trim_start().starts_with(name)).unwrap();
        line.matches('█').count()
    };
    assert_eq!((bar("out"), bar("moments"), bar("given")), (12, 2, 1));
    assert!(
        text.contains("2 times")
            && text.contains("80x45x1")
            && text.contains("4.0 KiB of them the host's")
    );
    let svg = drawing(&made_up());
    assert!(svg.starts_with("<svg") && svg.contains("prefers-color-scheme: dark"));
    assert_eq!(svg.matches("3 blur x2").count(), 1);
    assert_eq!(bytes(1536 * 1024), "1.5 MiB");
    assert_eq!((bytes(0).as_str(), bytes(1 << 30).as_str()), ("0 B", "1.0 GiB"));
}
