//! Measured error of each specular form on the light of built-in scenes: what arrives at their receivers from virtual
//! lights, each lobe weighed by what is reflected of it, against quadrature.
//!
//! Prints for each scene which share of the reflected light comes from lobes of which sharpness, with the scene's own
//! materials; then, for white metal and a dielectric of several roughness alphas in the place of the scene's, the error of
//! each form: the mean absolute error over the mean reflected light, and the root mean square error of a lobe, over what is
//! reflected of it.
//!
//! `cargo run -p sglow-measure --example specular_in_scenes -- cornell-glossy caustic atrium`

use std::error::Error;

use rayon::prelude::*;
use sglow_measure as _;
use sglow_oracle::Vector3;
use sglow_oracle::brdf::{Material, Ndf};
use sglow_oracle::fis::stress::Random;
use sglow_oracle::shade::{Incoming, Specular, incoming, specular};
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::vsgl::Vsgl;
use sglow_renderer::device::Gpu;
use sglow_renderer::frame::Renderer;
use sglow_renderer::reference;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;

const ALPHAS: [f64; 8] = [0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0];
/// Receivers of each scene, and lobes of each alpha that are compared with quadrature.
const RECEIVERS: usize = 96;
const LOBES: usize = 160;
/// Upper ends of the ranges of sharpness.
const ENDS: [f64; 8] = [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, f64::INFINITY];

/// What a lobe meets.
struct Meeting {
    arriving: Incoming,
    view: Vector3,
    normal: Vector3,
    material: Material,
}

impl Meeting {
    /// The luminance that is reflected, as the mean of all forms: what one of them misses is drawn for the others' sake, so
    /// that drawing favours none.
    fn weight(&self) -> f64 {
        let Self { arriving, view, normal, material } = self;
        let all = Specular::ALL
            .map(|form| form.reflect(arriving, material, Ndf::Ggx, *view, *normal).luminance());
        all.iter().sum::<f64>() / all.len() as f64
    }
}

/// All lobes of all lights at some receivers, of a material or the receiver's own.
fn meetings(
    receivers: &[SurfaceTexel],
    lights: &[Vsgl],
    eye: Vector3,
    material: Option<Material>,
) -> Vec<Meeting> {
    let of_receiver = |surface: &SurfaceTexel| -> Vec<Meeting> {
        let view = (eye - surface.position).normalized();
        let lobes = lights.iter().flat_map(|light| {
            let lobes = core::iter::once(&light.diffuse).chain(&light.specular);
            lobes.map(|lobe| incoming(surface.position, light.position, light.variance, lobe))
        });
        let material = material.unwrap_or(surface.material);
        lobes.map(|arriving| Meeting { arriving, view, normal: surface.normal, material }).collect()
    };
    receivers.iter().flat_map(of_receiver).collect()
}

/// The shares of what is reflected of lobes up to each sharpness of [`ENDS`], from the one before on.
fn shares(meetings: &[Meeting]) -> [f64; ENDS.len()] {
    let mut shares = [0.0; ENDS.len()];
    for meeting in meetings {
        let bin = ENDS.iter().position(|&end| meeting.arriving.sharpness < end);
        shares[bin.unwrap_or(ENDS.len() - 1)] += meeting.weight();
    }
    let total: f64 = shares.iter().sum();
    shares.map(|share| share / total)
}

/// Lobes drawn in proportion to what is reflected of them.
fn drawn(meetings: &[Meeting], random: &mut Random) -> Vec<usize> {
    let mut sum = 0.0;
    let sums: Vec<f64> = meetings
        .iter()
        .map(|meeting| {
            sum += meeting.weight();
            sum
        })
        .collect();
    (0..LOBES)
        .map(|index| {
            let at = (index as f64 + random.uniform()) / LOBES as f64 * sum;
            sums.partition_point(|&sum| sum < at).min(sums.len() - 1)
        })
        .collect()
}

/// Errors of each form: absolute over the mean, and root mean square of a lobe.
fn errors(meetings: &[Meeting], drawn: &[usize]) -> Vec<[f64; 2]> {
    let forms = Specular::ALL;
    // What a lobe was drawn by is divided out: luminances over the weight, so that lobes count by their light.
    let each: Vec<(f64, Vec<f64>)> = drawn
        .par_iter()
        .map(|&index| {
            let Meeting { arriving, view, normal, material } = &meetings[index];
            let weight = meetings[index].weight();
            let expected =
                specular::quadrature(arriving, material, Ndf::Ggx, *view, *normal).luminance();
            let found = forms.map(|form| {
                form.reflect(arriving, material, Ndf::Ggx, *view, *normal).luminance() / weight
            });
            (expected / weight, found.to_vec())
        })
        .collect();
    let total: f64 = each.iter().map(|(expected, _)| expected).sum();
    (0..forms.len())
        .map(|form| {
            let absolute: f64 =
                each.iter().map(|(expected, found)| (found[form] - expected).abs()).sum();
            let square: f64 = each
                .iter()
                .map(|(expected, found)| (found[form] - expected).powi(2) / expected)
                .sum();
            [absolute / total, (square / total).sqrt()]
        })
        .collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let gpu = Gpu::open(None)?;
    let package = Package::embedded();
    let names: Vec<String> = std::env::args().skip(1).collect();
    for name in &names {
        let scene = Scene::builtin(name)?;
        let settings = Settings { size: [96, 54], ..Settings::default() };
        let renderer = Renderer::new(&gpu, &package, &scene, &settings, 0)?;
        renderer.render()?;
        let lights: Vec<Vsgl> = reference::lights(&gpu, renderer.indirect())?;
        let eye = reference::vector(renderer.eye());
        let mut surfaces: Vec<SurfaceTexel> = reference::texels(&renderer.read_gbuffer()?);
        surfaces.retain(|surface| surface.present);
        let mut random = Random::new(7);
        let mut pick = |surfaces: &[SurfaceTexel]| -> Vec<SurfaceTexel> {
            (0..RECEIVERS)
                .map(|_| surfaces[(random.uniform() * surfaces.len() as f64) as usize])
                .collect()
        };
        let own = meetings(&pick(&surfaces), &lights, eye, None);
        println!("{name}: share of the reflected light by sharpness below {ENDS:?}");
        println!("{name}: own materials {:.3?}", shares(&own));
        let receivers = pick(&surfaces);
        println!("{name}: forms {:?}", Specular::ALL);
        for (kind, reflectance) in [("white metal", 1.0), ("dielectric", 0.04)] {
            for alpha in ALPHAS {
                let specular = Vector3::splat(reflectance);
                let material = Material { diffuse: Vector3::zero(), specular, alpha };
                let all = meetings(&receivers, &lights, eye, Some(material));
                let sharp: f64 = shares(&all)[4..].iter().sum();
                let errors = errors(&all, &drawn(&all, &mut Random::new(11)));
                let [absolute, squared] =
                    [0, 1].map(|part| errors.iter().map(|error| error[part]).collect::<Vec<_>>());
                println!(
                    "{name} {kind} alpha {alpha}: {:.0} % sharper than 30; absolute {absolute:.3?}, RMS {squared:.3?}",
                    100.0 * sharp
                );
            }
        }
    }
    Ok(())
}
