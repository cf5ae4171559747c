//! Frames as lists and as drawings: what they show, and that nothing in a drawing lies on top of something else.

use sglow_renderer::request::RequestError;
use sglow_renderer::request::derivation::Request;
use sglow_renderer::request::frame::{self, RequestedFrame};
use sglow_renderer::request::shot::load;
use sglow_report::page::graph::content::{Access, Content, Use};
use sglow_report::page::graph::{faults, text};
use sglow_runtime::package::Package;

use crate::common::library;

fn requested(
    scene: Option<&str>,
    set: &[&str],
    package: Option<&Package>,
) -> Result<(String, RequestedFrame), RequestError> {
    let set: Vec<_> = set.iter().map(|&word| word.to_owned()).collect();
    let scene = scene.map(|name| load(name, None, &sglow_scene::Options::default()).unwrap().0);
    let request = Request::of([640, 360]);
    let name = scene.as_ref().map_or("any scene", |scene| &scene.name).to_owned();
    let frame = RequestedFrame::new(&library(), package, scene.as_ref(), &set, &request)?;
    Ok((format!("{name}, 640 x 360"), frame))
}

fn content(scene: Option<&str>, set: &[&str]) -> Result<Content, RequestError> {
    requested(scene, set, None).map(listed)
}

fn listed((title, requested): (String, RequestedFrame)) -> Content {
    let RequestedFrame { changed, configuration, frame, bindings } = requested;
    let access = |(name, frame::Access { reads, writes })| (name, Access { reads, writes });
    let of = |(id, all): (String, std::collections::BTreeMap<_, _>)| {
        (id, all.into_iter().map(access).collect())
    };
    let bindings = bindings.into_iter().map(of).collect();
    Content::new(title, changed, configuration, &frame, &bindings)
}

#[test]
fn the_frame_of_cornell_as_a_table_and_as_a_list() {
    let content = content(Some("cornell"), &[]).unwrap();
    insta::assert_snapshot!("cornell", text(&content));
    let list = serde_json::to_string_pretty(&content).unwrap();
    insta::assert_snapshot!("cornell_list", list);
}

#[test]
fn what_is_kept_and_used_is_what_is_bound() {
    let content = content(Some("cornell"), &["visibility=none"]).unwrap();
    let step = |pass: &str| {
        let found = content.steps.iter().find(|step| step.pass.as_deref() == Some(pass));
        found.unwrap_or_else(|| panic!("no {pass}"))
    };
    let names =
        |uses: &[Use]| -> Vec<String> { uses.iter().map(|one| one.resource.clone()).collect() };
    let shade = step("shade");
    assert_eq!(names(&shade.writes), ["diffuse"]);
    assert!(names(&shade.reads).contains(&"cut_vsgls".to_owned()));
    // The group gives it, the variant does not bind it.
    assert!(!names(&shade.reads).contains(&"light_maps".to_owned()));
    let surface = step("surface");
    assert_eq!(surface.reads, []);
    assert_eq!(surface.writes.len(), 4);
    let bytes: u64 = content.resources.iter().map(|resource| resource.bytes).sum();
    assert_eq!(content.bytes, bytes);
}

#[test]
fn nothing_in_a_drawing_is_on_top_of_something_else() {
    for (scene, set) in [
        (Some("cornell"), &[][..]),
        (Some("cornell-glossy"), &["density=bidirectional", "precision=f16", "space=none"]),
        (Some("atrium:15k"), &["visibility=imperfect", "draw=metropolis", "lights=65536"]),
        (None, &["space=none"]),
    ] {
        let content = content(scene, set).unwrap();
        assert_eq!(faults(&content), [""; 0], "{set:?}");
    }
}

#[test]
fn a_package_has_the_frame_that_the_library_has() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders/packages/sglow");
    let package = Package::load(folder.as_ref()).unwrap();
    // Variants of the default settings are committed; those of the scene's defaults need not be.
    let set = ["space=none", "visibility=none", "emitter=cosine"];
    let own = requested(None, &set, Some(&package)).map(listed).unwrap();
    assert_eq!(own, content(None, &set).unwrap());
    let missing = ["diffuse=constant", "variance=planar", "sharpness=toksvig"];
    let text = requested(None, &missing, Some(&package)).unwrap_err().to_string();
    assert!(text.contains("has no variant"), "{text}");
}

#[test]
fn what_cannot_be_is_an_error() {
    for (set, wanted) in [
        (&["colour=red"][..], "colour"),
        (&["space=world", "precision=f16"], "precision: f32 with clusters"),
    ] {
        let text = content(None, set).unwrap_err().to_string();
        assert!(text.contains(wanted), "{text}");
    }
}
