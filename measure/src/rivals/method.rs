//! The settings of the methods that make virtual lights of a map.

use sglow_results::rivals::method::Method;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Cut, Draw, Kernel, Solver, Space};

/// The settings of the method, with everything else as in `base`.
#[must_use]
pub fn settings(method: Method, base: &Settings) -> Settings {
    let base = Settings {
        draw: Draw::Warped,
        kernel: Kernel::Modified,
        solver: Solver::Bracketed,
        space: Space::None,
        cut: Cut::None,
        ..base.clone()
    };
    match method {
        Method::Previous => Settings { kernel: Kernel::Previous, ..base },
        Method::Modified => Settings { solver: Solver::Bisection, ..base },
        Method::Bracketed => base,
        Method::Image => Settings { space: Space::Image, ..base },
        Method::World => Settings { space: Space::World, ..base },
        Method::Metropolis => Settings { draw: Draw::Metropolis, ..base },
    }
}
