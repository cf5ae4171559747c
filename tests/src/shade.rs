//! Reflection of virtual lights: `shaders/src/shade`, `shaders/src/sg`, `shaders/src/brdf`.

use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::vsgl::Vsgl;
use sglow_oracle::{Bounded, Vector3, shade};
use sglow_renderer::stages::{Seen, Stages as _};
use sglow_renderer::variants::Variants as _;
use sglow_renderer::{readback, reference};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Diffuse, Emitter, Lobes, Ndf, Precision, Specular};

use crate::common::{Comparison, KINDS, Run, broken, gpu, small, whole_space};

/// Compares diffuse and specular reflection at every pixel.
fn compare(run: &Run) -> Comparison {
    let lights: Vec<Vsgl<Bounded>> = reference::lights(gpu(), &run.indirect).unwrap();
    let surfaces: Vec<SurfaceTexel<Bounded>> = reference::texels(&run.gbuffer);
    let model = reference::model(run.indirect.settings());
    let eye = Vector3::constant(reference::vector(run.eye));
    let read = |texture: wgpu::Texture| readback::texture(gpu(), &texture, 0).unwrap();
    let diffuse = run.indirect.diffuse().map(read);
    let specular = run.indirect.specular().map(read);
    let mut comparison = Comparison::default();
    for (index, surface) in surfaces.iter().enumerate() {
        let expected = shade::shade(surface, eye, lights.iter().copied(), &model);
        for (name, measured, expected) in
            [("diffuse", &diffuse, expected.diffuse), ("specular", &specular, expected.specular)]
        {
            if let Some(measured) = measured {
                let [r, g, b, _] = measured[index];
                comparison.vector(&format!("{name} of pixel {index}"), [r, g, b], expected);
            }
        }
    }
    comparison
}

fn settings(diffuse: Diffuse, specular: Specular, ndf: Ndf, lobes: Lobes) -> Settings {
    Settings { diffuse, specular, ndf, lobes, ..small() }
}

#[test]
fn agrees_with_the_oracle() {
    let mut count = 0;
    for emitter in Emitter::ALL {
        for (lobes, precision) in Lobes::ALL
            .into_iter()
            .flat_map(|lobes| Precision::ALL.map(|precision| (lobes, precision)))
        {
            for diffuse in Diffuse::ALL {
                for specular in Specular::ALL {
                    // Forms of the cosine and of specular reflection are functions of their own: they are crossed once, and
                    // elsewhere one at a time.
                    let crossed = emitter == Emitter::Lobe
                        && lobes == Lobes::Both
                        && precision == Precision::F32;
                    let single = [Diffuse::Fitted, Diffuse::None].contains(&diffuse)
                        || specular == Specular::None;
                    if !crossed && !single {
                        continue;
                    }
                    for ndf in Ndf::ALL {
                        let own = settings(diffuse, specular, ndf, lobes);
                        count += usize::from(agrees(&Settings { emitter, precision, ..own }));
                    }
                }
            }
        }
    }
    println!("{count} variants");
}

/// Whether there is such a variant; it agrees with the oracle then.
fn agrees(settings: &Settings) -> bool {
    if settings.shade().excluded().is_some() {
        return false;
    }
    let run = Run::new(settings, KINDS[0], whole_space(), 4);
    compare(&run).assert_holds(&settings.shade().id());
    true
}

#[test]
fn a_broken_shader_is_noticed() {
    let breaks = [
        (
            "constant",
            "sg",
            "ggx",
            "SGLOW_INV_TWO_PI * extent.density",
            "0.16 * extent.density",
            "another normalisation",
        ),
        (
            "constant",
            "sg",
            "ggx",
            "SGLOW_INV_PI * sglow_sg_integral",
            "0.3183 * sglow_sg_integral",
            "pi to four digits",
        ),
        (
            "constant",
            "sg",
            "ggx",
            "sglow_sg_product_moderate(-axis",
            "sglow_sg_product_moderate(axis",
            "light that leaves backwards",
        ),
        ("gaussian", "asg", "ggx", "normal, 2.0)", "normal, 2.1)", "another cosine lobe"),
        ("gaussian", "asg", "ggx", "0.25 / max(alpha", "0.26 / max(alpha", "another bandwidth"),
        ("constant", "ndf_filtered", "ggx", "log2(1.0 +", "log2(1.1 +", "another filter"),
        (
            "gaussian",
            "asg_flat",
            "ggx",
            "0.25 * smoothness / max(alpha",
            "0.25 / max(alpha",
            "the printed bandwidth",
        ),
        (
            "gaussian",
            "asg_product",
            "ggx",
            "sglow_specular_factor(gloss, direction)",
            "sglow_specular_factor(gloss, incoming.axis)",
            "the factor at the incoming axis",
        ),
        (
            "gaussian",
            "asg_product",
            "beckmann",
            "max((1.0 - receiver.alpha) * (1.0 + receiver.alpha), 0.0)",
            "1.0",
            "a product that is not flat",
        ),
        (
            "constant",
            "ndf_filtered_2024",
            "ggx",
            "roughness_y = (squared * spread_y + smoothness) / (spread_y + smoothness)",
            "roughness_y = roughness_x",
            "no Jacobian across the plane of incidence",
        ),
        (
            "constant",
            "ndf_filtered_2024",
            "ggx",
            "density / area * share",
            "density / area",
            "no horizon",
        ),
        (
            "constant",
            "ndf_filtered",
            "ggx",
            "density / area * lit",
            "density / area",
            "no shadowing",
        ),
        ("gaussian", "asg", "beckmann", "3.535", "3.5", "another fit of the masking"),
        ("constant", "sg", "ggx", "(visibility * NoL)", "visibility", "a dropped cosine"),
        (
            "constant",
            "sg",
            "ggx",
            "specular += sglow_specular_gloss(from_specular",
            "specular += 0.0 * sglow_specular_gloss(from_specular",
            "a dropped lobe",
        ),
    ];
    for (diffuse, specular, ndf, from, to, what) in breaks {
        let id = format!("shade-lobe-{diffuse}-{specular}-{ndf}-both-f32-none");
        let own = settings(
            diffuse.parse().unwrap(),
            specular.parse().unwrap(),
            ndf.parse().unwrap(),
            Lobes::Both,
        );
        let settings = Settings { emitter: Emitter::Lobe, ..own };
        let run = Run::new(&settings, KINDS[0], &broken(&id, from, to), 4);
        compare(&run).assert_fails(&format!("{id}: {what}"));
    }
}

#[test]
fn a_broken_emitter_is_noticed() {
    let breaks = [
        (
            Emitter::Cosine,
            "-dot(extent.towards",
            "dot(extent.towards",
            "light that leaves backwards",
        ),
        (
            Emitter::Cosine,
            "SGLOW_INV_TWO_PI_SQUARED * integral",
            "0.0507 * integral",
            "another normalisation",
        ),
        (
            Emitter::Cosine,
            "max(dot(incoming.axis, normal), 0.0)",
            "abs(dot(incoming.axis, normal))",
            "a receiver that is lit from behind",
        ),
        (
            Emitter::CosineConvolved,
            "SGLOW_INV_PI * integral",
            "0.3183 * integral",
            "pi to four digits",
        ),
        (Emitter::CosineQuadratic, "0.25 * sum", "0.26 * sum", "another parabola"),
        (
            Emitter::CosineQuadratic,
            "2e37) * (1.0 + mean_length)",
            "2e37) * (1.01 + mean_length)",
            "another integral",
        ),
        (Emitter::Disc, "0.25 * a * sglow", "0.5 * a * sglow", "a thicker disc"),
        (Emitter::Disc, "max(height, 0.0)", "height", "a disc that shines backwards"),
        (Emitter::Disc, "2.0 * sqrt(squared)", "2.0", "another distance"),
        (Emitter::Disc, "mean_length * tilt", "tilt", "a thinner disc"),
    ];
    for (emitter, from, to, what) in breaks {
        let id = format!("shade-{emitter}-fitted-asg-ggx-both-f32-none");
        let own = settings(Diffuse::Fitted, Specular::Asg, Ndf::Ggx, Lobes::Both);
        let run = Run::new(&Settings { emitter, ..own }, KINDS[0], &broken(&id, from, to), 4);
        compare(&run).assert_fails(&format!("{id}: {what}"));
    }
}

#[test]
fn a_broken_unpacking_is_noticed() {
    let breaks = [
        ("32.0 * unpack2x16float(packed.specular", "32.1 * unpack2x16float(packed.specular"),
        ("max(-height, 0.0)", "0.99 * max(-height, 0.0)"),
        ("direction * inverseSqrt(dot(direction, direction))", "direction"),
        ("unpack2x16unorm(packed.blue_sharpness).x", "unpack2x16unorm(packed.blue_sharpness).y"),
    ];
    for (from, to) in breaks {
        let settings = Settings { precision: Precision::F16, ..small() };
        let package = broken(&settings.shade().id(), from, to);
        let run = Run::new(&settings, KINDS[0], &package, 4);
        compare(&run).assert_fails(to);
    }
}

#[test]
fn output_is_finite_where_surfaces_and_lights_touch() {
    // Every pixel lies on a texel of the map: lights sit at shading points.
    let settings = Settings { size: [32, 32], ..small() };
    let mut run = Run::new(&settings, KINDS[0], &Package::embedded(), 5);
    run.gbuffer = run.rsm.clone();
    let uploaded = crate::common::Uploaded::new(&run.gbuffer, settings.size);
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    let seen = Seen { gbuffer: uploaded.views(), eye: run.eye, light: &run.light };
    run.indirect.encode_shade(&mut encoder, &seen, None, None).unwrap();
    gpu().queue.submit([encoder.finish()]);
    gpu().finish().unwrap();
    for texture in [run.indirect.diffuse().unwrap(), run.indirect.specular().unwrap()] {
        let pixels = readback::texture(gpu(), &texture, 0).unwrap();
        assert!(pixels.iter().flatten().all(|value| value.is_finite() && *value >= 0.0));
        assert!(pixels.iter().any(|pixel| pixel[0] > 0.0), "nothing was lit");
    }
}
