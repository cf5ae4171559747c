//! `shaders/src/brdf`.

use core::f64::consts::PI;

use sglow_oracle::brdf::albedo::{DIELECTRIC_ERROR, FADING_ERROR, WHITE_ERROR};
use sglow_oracle::brdf::{
    Material, Ndf, albedo, beckmann, ggx, ndf_filtered, ndf_filtered_2024, reflection,
};
use sglow_oracle::{Real, Vector3, math, sg, shade};

use super::entry::function;
use crate::bound::FILTERED_FLOOR;
use crate::function::{Function, Monotone, Numbers, Results, one, unit, vector};

/// The most that a distribution can be.
fn distribution_peak(x: Numbers<f64>) -> Results<f64> {
    [1.0 / (PI * x[11] * x[11]); 4]
}

/// The functions of this folder.
pub(super) const FUNCTIONS: &[Function] = &[
    function!(d_ggx(Axis @ 0, OtherAxis @ 4, Alpha @ 11) -> ["density"],
        peak: distribution_peak,
    ),
    function!(v_smith_ggx_correlated(UpperCosine @ 0, UpperCosine @ 1, Alpha @ 11) -> ["visibility"],
        peak: |x| [v_smith_ggx_correlated(x)[0]; 4],
        monotone: Some(Monotone { component: 0, grows: false }),
    ),
    function!(d_beckmann(Axis @ 0, OtherAxis @ 4, Alpha @ 11) -> ["density"],
        peak: distribution_peak,
    ),
    function!(g1_smith_beckmann(UpperCosine @ 0, Alpha @ 11) -> ["masking"],
        reference: Some(|x| one(g1_smith_beckmann_reference(x[0], x[11]))),
        peak: unit,
    ),
    function!(v_smith_beckmann(UpperCosine @ 0, UpperCosine @ 1, Alpha @ 11) -> ["visibility"],
        reference: Some(|x| {
            let masking = g1_smith_beckmann_reference(x[0], x[11]) * g1_smith_beckmann_reference(x[1], x[11]);
            one(masking / (4.0 * x[0] * x[1]))
        }),
        peak: |x| [v_smith_beckmann(x)[0]; 4],
    ),
    function!(sg_reflection_mirror(Axis @ 0, FacingAxis @ 4, Alpha @ 11) -> ["sharpness", "axis x", "axis y", "axis z"],
        mirror,
        peak: |x| [mirror(x)[0], 1.0, 1.0, 1.0],
        never_negative: false,
    ),
    function!(sg_reflection_dominant(Axis @ 0, FacingAxis @ 4, Alpha @ 11) -> ["sharpness", "axis x", "axis y", "axis z"],
        dominant,
        peak: |x| [dominant(x)[0].max(1e-6), 1.0, 1.0, 1.0],
        never_negative: false,
    ),
    function!(ndf_filtered_reflection(Axis @ 0, Sharpness @ 3, FacingAxis @ 4, OtherAxis @ 8, Alpha @ 11) ->
        ["radiance", "cosine"],
        filtered,
        reference: Some(filtered_reference),
        slow_reference: true,
        // What a mirror reflects is at most 1, what a rough surface does at most the lobe's integral over the horizon's
        // projected area; this is a scale, no bound.
        peak: |x| [sg::integral(x[3].min(4e37)).min(1.0), 1.0, 1.0, 1.0],
        floor: FILTERED_FLOOR,
    ),
    function!(ndf_filtered_2024_reflection(Axis @ 0, Sharpness @ 3, FacingAxis @ 4, OtherAxis @ 8, Alpha @ 11) ->
        ["radiance"],
        filtered_2024,
        reference: Some(filtered_reference),
        slow_reference: true,
        peak: |x| [sg::integral(x[3].min(4e37)).min(1.0), 1.0, 1.0, 1.0],
        floor: FILTERED_FLOOR,
    ),
    function!(ggx_albedo(UpperCosine @ 0, Alpha @ 11) ->
        ["white metal", "dielectric", "blue of a dielectric", "fading"],
        directional_albedo,
        reference: Some(directional_albedo_reference),
        slow_reference: true,
        // Each result is seen against what makes its own largest error that of white metal over its peak. Blue has half of
        // the dielectric's reflectance and all of the same error.
        peak: |x| {
            let [_, dielectric, blue, fading] = directional_albedo(x);
            let relative = |albedo: f64, reflectance: f64, promised: f64| {
                albedo.max(reflectance) * promised / WHITE_ERROR
            };
            [
                1.0,
                relative(dielectric, 0.04, DIELECTRIC_ERROR),
                relative(blue, 0.02, 2.0 * DIELECTRIC_ERROR),
                relative(fading, 0.01, FADING_ERROR),
            ]
        },
    ),
];

/// Smith's masking of Beckmann, which Walter's rational function fits.
// [Walter 2007, Eq. (26)]
fn g1_smith_beckmann_reference(cosine: f64, alpha: f64) -> f64 {
    let a = cosine / (alpha * (1.0 - cosine * cosine).max(0.0).sqrt());
    if a > 1e3 {
        return 1.0;
    }
    2.0 / (1.0 + math::erf(a) + (-a * a).exp() / (a * PI.sqrt()))
}

/// The reflection of a white surface by quadrature, where that resolves lobe and surface. Of the cosine for Fresnel's
/// term there is no reference.
fn filtered_reference(x: Numbers<f64>) -> Results<f64> {
    let (view, normal, axis) = (vector(&x, 0), vector(&x, 4), vector(&x, 8));
    let [view, normal, axis] = [view, normal, axis].map(Vector3::normalized);
    let mut reference = [f64::NAN; 4];
    if x[11] >= 0.05 && x[3] <= 1e3 && view.dot(normal) >= 0.05 {
        let one = Vector3::splat(1.0);
        let arriving = shade::Incoming { axis, sharpness: x[3], coefficient: one };
        let material = Material { diffuse: one * 0.0, specular: one, alpha: x[11] };
        reference[0] = shade::specular::quadrature(&arriving, &material, Ndf::Ggx, view, normal).x;
    }
    reference
}

fn d_ggx<R: Real>(x: Numbers<R>) -> Results<R> {
    one(ggx::d_ggx_about(vector(&x, 0), vector(&x, 4), x[11]))
}

fn v_smith_ggx_correlated<R: Real>(x: Numbers<R>) -> Results<R> {
    one(ggx::v_smith_ggx_correlated(x[0], x[1], x[11]))
}

fn d_beckmann<R: Real>(x: Numbers<R>) -> Results<R> {
    one(beckmann::d_beckmann_about(vector(&x, 0), vector(&x, 4), x[11]))
}

fn g1_smith_beckmann<R: Real>(x: Numbers<R>) -> Results<R> {
    one(beckmann::g1_smith_beckmann(x[0], x[11]))
}

fn v_smith_beckmann<R: Real>(x: Numbers<R>) -> Results<R> {
    one(beckmann::v_smith_beckmann(x[0], x[1], x[11]))
}

fn lobe<R: Real>(lobe: reflection::Reflection<R>) -> Results<R> {
    [lobe.sharpness, lobe.axis.x, lobe.axis.y, lobe.axis.z]
}

fn mirror<R: Real>(x: Numbers<R>) -> Results<R> {
    lobe(reflection::mirror(vector(&x, 0), vector(&x, 4), x[11]))
}

fn dominant<R: Real>(x: Numbers<R>) -> Results<R> {
    lobe(reflection::dominant(vector(&x, 0), vector(&x, 4), x[11]))
}

fn filtered<R: Real>(x: Numbers<R>) -> Results<R> {
    let reflected = ndf_filtered::reflection(
        vector(&x, 0),
        vector(&x, 4),
        x[11],
        vector(&x, 8),
        x[3].min(R::constant(4e37)),
    );
    [reflected.radiance, reflected.cosine, R::zero(), R::zero()]
}

fn filtered_2024<R: Real>(x: Numbers<R>) -> Results<R> {
    let (view, normal, axis) = (vector(&x, 0), vector(&x, 4), vector(&x, 8));
    one(ndf_filtered_2024::reflection(view, normal, x[11], axis, x[3].min(R::constant(4e37))))
}

/// Reflectances at normal incidence: of white metal, of a dielectric whose blue is another, and of what reflects less than
/// 2 %.
const REFLECTANCES: [[f64; 3]; 3] = [[1.0; 3], [0.04, 0.04, 0.02], [0.01; 3]];

fn directional_albedo<R: Real>(x: Numbers<R>) -> Results<R> {
    let [white, dielectric, fading] = REFLECTANCES.map(|[r, g, b]| {
        albedo::directional(Vector3::constant(Vector3::new(r, g, b)), x[0], x[11])
    });
    [white.x, dielectric.x, dielectric.z, fading.x]
}

/// By quadrature, where that has a lobe to resolve.
fn directional_albedo_reference(x: Numbers<f64>) -> Results<f64> {
    if x[0] < 1e-3 || x[11] < 0.01 {
        return [f64::NAN; 4];
    }
    let [white, added] = albedo::quadrature(x[0], x[11]);
    let [w, d, f] = REFLECTANCES
        .map(|[r, _, b]| [r, b].map(|own| own * (white - added) + (50.0 * r).min(1.0) * added));
    [w[0], d[0], d[1], f[0]]
}
