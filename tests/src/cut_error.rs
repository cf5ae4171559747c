//! The error of a cut for each tile on a scene, against all texels as lights: what must not be lost.

use sglow_measure::cuts::{base, of_map};
use sglow_renderer::variants::Variants as _;
use sglow_results::cuts::CutError;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;

use crate::common::{broken, gpu, whole_space};

/// A small map of a scene with many corners, by the default tolerance or a finer one.
fn measured(package: &Package, share: f32) -> CutError {
    let settings = Settings { map: 64, size: [112, 63], ..base() };
    let settings = Settings { tolerance: share * settings.tolerance, ..settings };
    let scene = Scene::load("atrium").unwrap();
    of_map(gpu(), package, &[scene], &settings).unwrap().error.unwrap()
}

#[test]
fn light_in_corners_is_not_lost() {
    let show = |what: &str, found: &CutError| {
        let CutError { picture, jump, jump_999 } = found;
        println!(
            "{what}: RMSE {}, relative MSE {}, median {}, bias {}, jump {jump}, {jump_999} at 99.9 %",
            picture.rmse_over_mean, picture.relative_mse, picture.median, picture.bias
        );
    };
    let usual = measured(whole_space(), 1.0);
    show("default", &usual);
    let finer = measured(whole_space(), 0.1);
    show("a tenth of the tolerance", &finer);
    assert!(usual.picture.rmse_over_mean < 0.12 && usual.picture.bias.abs() < 0.006);
    assert!(usual.picture.median < 0.01);
    assert!(finer.picture.rmse_over_mean < 0.6 * usual.picture.rmse_over_mean);
    // Without it the box bounds what votes see, not what the pixels between them see.
    let shade = base().shade().id();
    let slack = "max(SGLOW_CUT_SLACK * inverseSqrt(1.0 + extent), min(aside, 1.0))";
    let at_votes = measured(&broken(&shade, slack, "min(aside, 1.0)"), 1.0);
    show("the box alone", &at_votes);
    assert!(at_votes.picture.rmse_over_mean > 1.2 * usual.picture.rmse_over_mean);
    // Negative control: one standard deviation alone loses what no tolerance brings back.
    let close = broken(&shade, slack, "inverseSqrt(1.0 + extent)");
    let lost = measured(&close, 0.1);
    show("one standard deviation", &lost);
    assert!(
        lost.picture.rmse_over_mean > 0.1 && lost.picture.bias < -0.02,
        "light that is lost goes unnoticed"
    );
}
