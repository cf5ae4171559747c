//! The error of specular models against quadrature. `docs/results.md` shows it.

use rayon::prelude::*;
use sglow_oracle::brdf::Ndf;
use sglow_oracle::shade::specular_error::{ALPHAS, cases, root_mean_square};
use sglow_renderer::reference;
use sglow_results::specular::SpecularError;
use sglow_runtime::settings::Settings;
use sglow_shaders::Specular;

/// The error of every model of the axis `specular` with GGX, over roughness alpha 0.05 to 1.
#[must_use]
pub fn errors() -> Vec<SpecularError> {
    let cases: Vec<_> = ALPHAS.par_iter().flat_map(|&alpha| cases(Ndf::Ggx, &[alpha])).collect();
    let model = |&specular: &Specular| {
        let settings = Settings { specular, ..Settings::default() };
        Some((specular.to_string(), reference::model(&settings).specular?))
    };
    let models: Vec<_> = Specular::ALL.iter().filter_map(model).collect();
    models
        .into_par_iter()
        .map(|(model, specular)| {
            let [white, dielectric] = root_mean_square(cases.iter(), specular);
            SpecularError { model, white, dielectric }
        })
        .collect()
}
