//! Input that breaks a contract is reported: `shaders/src/contract`.

use sglow_measure::functions;
use sglow_measure::hold::Subject;
use sglow_measure::input::Kind;
use sglow_renderer::check::{Check, Violations};
use sglow_renderer::frame::Surfaces;
use sglow_renderer::function::{Arguments, Function, NOT_FINITE, NOT_UNIT, OUT_OF_RANGE};
use sglow_renderer::stages::{Seen, Stages as _};
use sglow_results::stability::regime::REGIMES;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Lobes, Precision};

use crate::common::{KINDS, Run, Uploaded, gpu, small, whole_space};
use crate::function::variants;

/// What is wrong with an argument, and the bit that says so.
fn breaks(kind: Kind) -> Vec<(f32, u32)> {
    let not_finite = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].map(|value| (value, NOT_FINITE));
    let wrong: &[(f32, u32)] = match kind {
        Kind::Sharpness | Kind::OtherSharpness => &[(-1e-3, OUT_OF_RANGE)],
        Kind::Cosine | Kind::UpperCosine | Kind::MeanLength => &[(1.5, OUT_OF_RANGE)],
        Kind::Alpha => &[(-0.1, OUT_OF_RANGE), (1.1, OUT_OF_RANGE)],
        Kind::Exponent => &[(89.0, OUT_OF_RANGE)],
        Kind::Variance => &[(0.0, OUT_OF_RANGE)],
        Kind::Axis | Kind::OtherAxis | Kind::FacingAxis => &[(2.0, NOT_UNIT)],
        Kind::Number => &[],
        Kind::Magnitude => &[(-1.0, OUT_OF_RANGE)],
    };
    not_finite.into_iter().chain(wrong.iter().copied()).collect()
}

#[test]
fn every_function_reports_arguments_that_break_its_contract() {
    for function in functions::all() {
        let subject = Subject::find(&function, variants()).unwrap();
        let on_device = Function::new(gpu(), whole_space(), &function.id()).unwrap();
        let right: Vec<Arguments> = REGIMES
            .iter()
            .flat_map(|regime| subject.inputs(regime, 64, 5).unwrap())
            // Axes one ULP or a subnormal number from unit are unit.
            .collect();
        let reported = on_device.check(&right).unwrap();
        let wrong = right.iter().zip(&reported).find(|(_, bits)| **bits != 0);
        assert_eq!(wrong, None, "{}: right arguments are reported", function.name);
        for argument in function.arguments {
            // What becomes of the power and of the mean direction of an emission is the moments' contract.
            if function.name == "emission" && argument.at != 3 {
                continue;
            }
            for (value, bit) in breaks(argument.kind) {
                let mut arguments = right[100];
                arguments[argument.at] = value;
                let reported = on_device.check(&[arguments]).unwrap()[0];
                assert!(
                    reported & bit != 0,
                    "{}: {value} at {} goes unreported: {reported}",
                    function.name,
                    argument.at
                );
                // Bad input gives anything, but the device goes on.
                on_device.evaluate(&[arguments]).unwrap();
            }
        }
    }
}

/// Runs the pipeline on surfaces, breaks the lights and the surfaces that it read, and checks both.
fn check(
    precision: Precision,
    break_light: impl Fn(&mut [f32]),
    break_surfaces: impl Fn(&mut Surfaces),
) -> Violations {
    let settings = Settings { precision, ..small() };
    let run = Run::new(&settings, KINDS[0], &Package::embedded(), 6);
    let vsgls = &run.indirect.vsgls().unwrap();
    let mut words: Vec<f32> = sglow_renderer::readback::buffer(gpu(), vsgls).unwrap();
    break_light(&mut words);
    gpu().queue.write_buffer(vsgls, 0, bytemuck::cast_slice(&words));
    let mut gbuffer = run.gbuffer.clone();
    break_surfaces(&mut gbuffer);
    let uploaded = Uploaded::new(&gbuffer, settings.size);
    let check =
        Check::new(&gpu().device, &gpu().queue, &Package::embedded(), Lobes::Both, precision)
            .unwrap();
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    check.encode(&mut encoder, uploaded.views(), vsgls, settings.lights, settings.size);
    gpu().queue.submit([encoder.finish()]);
    check.read(gpu()).unwrap()
}

#[test]
fn lights_and_surfaces_that_break_the_contract_are_counted() {
    for precision in Precision::ALL {
        let right = check(precision, |_| (), |_| ());
        assert!(right.is_empty(), "{precision}: {right}");
        assert_eq!(right.to_string(), "lights and surfaces keep the contract");

        // The variance of light 7: the fourth word of a light in both precisions.
        let words = if precision == Precision::F32 { 20 } else { 12 };
        let broken = check(precision, |lights| lights[7 * words + 3] = f32::NAN, |_| ());
        assert_eq!((broken.not_finite, broken.first_light), (1, Some(7)), "{broken}");
        let broken = check(precision, |lights| lights[9 * words + 3] = -1.0, |_| ());
        assert_eq!((broken.out_of_range, broken.first_light), (1, Some(9)), "{broken}");

        // A pixel that has a surface.
        let pixel = |surfaces: &Surfaces| {
            surfaces.position.iter().position(|texel| texel[3] >= 0.0).unwrap()
        };
        let broken = check(
            precision,
            |_| (),
            |surfaces| {
                let at = pixel(surfaces);
                surfaces.normal[at][0] = 3.0;
                surfaces.base_color[at][1] = f32::INFINITY;
            },
        );
        assert_eq!((broken.not_unit, broken.not_finite), (1, 1), "{broken}");
        assert!(broken.first_light.is_none() && broken.first_pixel.is_some(), "{broken}");
        assert!(broken.to_string().contains("1 a direction that is not unit"), "{broken}");
    }
}

#[test]
fn shading_goes_on_with_lights_that_are_not_numbers() {
    let settings = small();
    let run = Run::new(&settings, KINDS[0], &Package::embedded(), 6);
    let words: Vec<f32> =
        sglow_renderer::readback::buffer(gpu(), &run.indirect.vsgls().unwrap()).unwrap();
    let uploaded = Uploaded::new(&run.gbuffer, settings.size);
    for value in [f32::NAN, f32::INFINITY, -1.0, f32::MAX] {
        let bad = vec![value; words.len()];
        gpu().queue.write_buffer(&run.indirect.vsgls().unwrap(), 0, bytemuck::cast_slice(&bad));
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        let seen = Seen { gbuffer: uploaded.views(), eye: run.eye, light: &run.light };
        run.indirect.encode_shade(&mut encoder, &seen, None, None).unwrap();
        gpu().queue.submit([encoder.finish()]);
        gpu().finish().unwrap();
    }
}
