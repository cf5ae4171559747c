//! Every command has the same numbers for the same pair of pictures.

use std::path::Path;

use sglow_measure::frontier::evaluate::Evaluator;
use sglow_measure::frontier::references::References;
use sglow_measure::frontier::subject::Subject;
use sglow_measure::picture;
use sglow_oracle::metrics;
use sglow_renderer::frame::Renderer;
use sglow_renderer::request::derivation::Request;
use sglow_renderer::request::shot::{Shot, load};
use sglow_report::compare::{self, Files};
use sglow_report::picture::exr;
use sglow_report::picture::read::{INDIRECT, Read};
use sglow_results::frontier::document::Reference;
use sglow_results::picture_error::{self, Metric, Radiance, mean};
use sglow_runtime::package::Package;

use crate::common::{gpu, library};
use crate::frontier::Silent;

/// What `render` says of a picture is what `compare` says of the files that it wrote, and what `report` and `choose`
/// say of the same light; `reproduce` calls what `render` does.
#[test]
fn every_command_has_the_same_numbers_for_the_same_pair() {
    let size = [24, 18];
    let numbers = ["lights=16", "map=32"].map(str::to_owned).to_vec();
    let request = Request { numbers, ..Request::of(size) };
    let scene = load("cornell", None, &sglow_scene::Options::default()).unwrap().0;
    let shot = Shot::new(&library(), scene, &[], &request).unwrap();
    let package = Package::embedded();
    let renderer = Renderer::new(gpu(), &package, &shot.scene, &shot.settings, 0).unwrap();
    renderer.render().unwrap();
    let frame = renderer.read().unwrap();
    let reference = picture::paths(&renderer, &shot.scene, &frame, 64, &Silent).unwrap();
    let rendered = picture::error(&frame, &reference).unwrap();

    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, frame| {
        let path = folder.path().join(name);
        exr::write(&path, &picture::picture(frame).unwrap(), "a test").unwrap();
        path
    };
    let [one, other] = reference.halves.as_ref().unwrap();
    let (ours, one, other) = (write("a.exr", &frame), write("1.exr", one), write("2.exr", other));
    let files = Files { tested: &ours, reference: &one, half: Some(&other), layer: None };
    let compared = compare::load(&files).unwrap().with(picture_error::compare);

    let light = |path: &Path| -> Radiance {
        Read::new(path).unwrap().layer(INDIRECT).unwrap().pixels().to_vec()
    };
    let (picture, halves) = (light(&ours), [light(&one), light(&other)]);
    let subject = Subject::new(gpu(), &package, &shot.scene, shot.settings.clone());
    let drawn = subject.drawn().unwrap();
    let position = &drawn.frame.gbuffer.position;
    let references = References {
        reference: Reference { samples: 64, mean: 1.0, noise_over_mean: 0.0, dark: false },
        indirect: mean(halves.each_ref()),
        halves,
        unshadowed: Vec::new(),
        present: (0..position.len()).filter(|&at| position[at][3] >= 0.0).collect(),
        sample: Vec::new(),
        points: Vec::new(),
    };
    let evaluator = Evaluator::new(&subject, &references, &drawn.frame, drawn.renderer.eye());
    let reported = evaluator.picture(&picture);

    assert!(rendered.pixels > 0 && rendered.pixels < 24 * 18, "some pixels show no surface");
    for metric in Metric::ALL {
        let [one, two, three] = [rendered, compared, reported].map(|error| error.measured(metric));
        for other in [two, three] {
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-5 * a.abs().max(1e-3);
            assert!(near(one.value, other.value), "{metric}: {one:?} {other:?}");
            assert!(near(one.uncertainty, other.uncertainty), "{metric}: {one:?} {other:?}");
        }
        assert!(one.value != 0.0 && one.uncertainty > 0.0, "{metric}: {one:?}");
    }
    // Over all pixels, as once, the number is another.
    let [one, other] = references.halves.each_ref().map(Vec::as_slice);
    let all = metrics::compare(&picture, [one, other], None).unwrap().rmse_over_mean().value;
    assert!((all / rendered.rmse_over_mean - 1.0).abs() > 0.02, "{all} {rendered:?}");
}
