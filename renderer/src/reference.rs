//! What the oracle needs to judge a frame: the runtime's data as the oracle's, and the brute-force pictures.
//!
//! Everything here is read back from the device or from the settings; nothing is computed that the oracle computes.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::variants::Variants as _;
use glam::Vec3;
use sglow_oracle::brdf;
use sglow_oracle::light::{Light, LightKind, Lights};
use sglow_oracle::rsm;
use sglow_oracle::shade::{Model, Reflected};
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::vpl::TexelFacets;
use sglow_oracle::vsgl::{
    Kernel as OracleKernel, Lobe, PackedLobe, Settings as SampleSettings, Solver as OracleSolver,
    Vsgl,
};
use sglow_oracle::{Real, Vector3, shade, vmf};
use sglow_shaders::{
    Diffuse, Emitter, Light as LightAxis, Lobes, Ndf, Precision, SglowPackedLobe,
    SglowPackedVsglBoth, SglowPackedVsglDiffuse, SglowVsglBoth, SglowVsglDiffuse, Sharpness,
    Solver, Specular, SpecularPower, Variance,
};

use crate::device::{DeviceError, Gpu};
use crate::frame::{Pixels, Surfaces};
use crate::readback;
use crate::stages::Stages as _;
use sglow_runtime::indirect::Indirect;
use sglow_runtime::light::LightView;
use sglow_runtime::settings::Settings;

pub mod path;
pub mod tree;

pub use path::{SceneMaterials, facets, path_halves, paths};

/// A vector of the runtime as one of the oracle.
pub fn vector(value: impl Into<Vec3>) -> Vector3 {
    let value: Vec3 = value.into();
    Vector3::new(f64::from(value.x), f64::from(value.y), f64::from(value.z))
}

/// The lights of a view, by the numbers in their uniforms.
#[derive(Clone, Debug)]
pub struct MapLights {
    /// Each of them.
    pub each: Vec<Light>,
    /// Of several the texels that each has of its tile.
    texels: Option<Vec<Option<usize>>>,
}

impl MapLights {
    /// Those of a view.
    pub fn of(view: &LightView) -> Self {
        let each = view.each().iter().map(|of| light(of, of.kind)).collect();
        let texels = view.lights.iter().map(|light| light.texels.map(|texels| texels as usize));
        let several = view.kind == LightAxis::Several;
        Self { each, texels: several.then(|| texels.collect()) }
    }

    /// As the oracle takes the lights of a map.
    pub fn of_map(&self) -> Lights<'_> {
        match (&self.each[..], &self.texels) {
            ([light], None) => Lights::One(light),
            (lights, texels) => {
                Lights::Several { lights, texels: texels.as_deref().unwrap_or_default() }
            }
        }
    }
}

/// The light, by the numbers in its uniform; of several the first.
pub fn light(view: &LightView, kind: LightAxis) -> Light {
    if let [first, ..] = &view.lights[..] {
        return light(first, first.kind);
    }
    let uniform = &view.uniform;
    Light {
        kind: match kind {
            LightAxis::Spot => LightKind::Spot {
                tan_half_angle: f64::from(uniform.tan_half_angle),
                cone_scale: f64::from(uniform.cone_scale),
                cone_offset: f64::from(uniform.cone_offset),
            },
            LightAxis::Directional => {
                LightKind::Directional { half_extent: f64::from(uniform.half_extent) }
            }
            // Several are taken apart before.
            LightAxis::Point | LightAxis::Several => LightKind::Point,
            LightAxis::Camera => LightKind::Camera,
        },
        position: vector(uniform.position),
        right: vector(uniform.right),
        up: vector(uniform.up),
        forward: vector(uniform.forward),
        intensity: vector(uniform.intensity),
    }
}

/// Surface textures as the oracle's texels.
pub fn texels<R: Real>(surfaces: &Surfaces) -> Vec<SurfaceTexel<R>> {
    surfaces
        .position
        .iter()
        .zip(&surfaces.normal)
        .zip(&surfaces.base_color)
        .map(|((&position, &normal), &base_color)| {
            SurfaceTexel::decode(position, normal, base_color)
        })
        .collect()
}

/// The distribution of microfacet normals; without specular reflection it is of no account.
pub fn ndf(ndf: Ndf) -> brdf::Ndf {
    match ndf {
        Ndf::None | Ndf::Ggx => brdf::Ndf::Ggx,
        Ndf::Beckmann => brdf::Ndf::Beckmann,
    }
}

/// The lobes that virtual lights emit.
pub fn lobes(lobes: Lobes) -> rsm::Lobes {
    match lobes {
        Lobes::Diffuse => rsm::Lobes::Diffuse,
        Lobes::Both => rsm::Lobes::Both,
    }
}

/// What texels emit, and how lights are made of them.
pub fn emission(settings: &Settings) -> rsm::Emission {
    rsm::Emission {
        lobes: lobes(settings.lobes),
        diffuse_mean_length: f64::from(settings.diffuse_mean_length()),
        sharpness: match settings.sharpness {
            Sharpness::Toksvig => vmf::Sharpness::Toksvig,
            Sharpness::Banerjee => vmf::Sharpness::Banerjee,
            Sharpness::Exact => vmf::Sharpness::Exact,
        },
        variance: match settings.variance {
            Variance::Trace => rsm::Variance::Trace,
            Variance::Planar => rsm::Variance::Planar,
        },
    }
}

/// How lights emit what they reflect diffusely.
pub fn emitter(emitter: Emitter) -> shade::Emitter {
    match emitter {
        Emitter::Lobe => shade::Emitter::Lobe,
        Emitter::Cosine => shade::Emitter::Cosine,
        Emitter::CosineConvolved => shade::Emitter::CosineConvolved,
        Emitter::CosineQuadratic => shade::Emitter::CosineQuadratic,
        Emitter::Disc => shade::Emitter::Disc,
    }
}

/// The power of specular lobes.
pub fn specular_power(power: SpecularPower) -> rsm::SpecularPower {
    match power {
        SpecularPower::F0 => rsm::SpecularPower::F0,
        SpecularPower::Albedo => rsm::SpecularPower::Albedo,
    }
}

/// The shading model.
pub fn model(settings: &Settings) -> Model {
    Model {
        emitter: emitter(settings.emitter),
        diffuse: match settings.diffuse {
            Diffuse::None => None,
            Diffuse::Constant => Some(shade::Diffuse::Constant),
            Diffuse::Gaussian => Some(shade::Diffuse::Gaussian),
            Diffuse::Logistic => Some(shade::Diffuse::Logistic),
            Diffuse::Erf => Some(shade::Diffuse::Erf),
            Diffuse::Quartic => Some(shade::Diffuse::Quartic),
            Diffuse::Fitted => Some(shade::Diffuse::Fitted),
            Diffuse::FittedFine => Some(shade::Diffuse::FittedFine),
        },
        specular: match settings.specular {
            Specular::None => None,
            Specular::Sg => Some(shade::Specular::Sg),
            Specular::Asg => Some(shade::Specular::Asg),
            Specular::AsgFlat => Some(shade::Specular::AsgFlat),
            Specular::AsgProduct => Some(shade::Specular::AsgProduct),
            Specular::NdfFiltered2024 => Some(shade::Specular::NdfFiltered2024),
            Specular::NdfFiltered => Some(shade::Specular::NdfFiltered),
        },
        ndf: ndf(settings.ndf),
    }
}

/// The virtual lights of an [`Indirect`], read back; packed ones as the oracle unpacks them.
pub fn lights<R: Real>(gpu: &Gpu, indirect: &Indirect) -> Result<Vec<Vsgl<R>>, DeviceError> {
    let settings = indirect.settings();
    indirect.vsgls().map_or(Ok(Vec::new()), |buffer| {
        lights_of(gpu, &buffer, settings.lobes, settings.precision)
    })
}

/// The virtual lights of the camera that the bidirectional density is made of; none without it.
pub fn camera_lights<R: Real>(gpu: &Gpu, indirect: &Indirect) -> Result<Vec<Vsgl<R>>, DeviceError> {
    indirect.camera_vsgls().map_or(Ok(Vec::new()), |buffer| {
        lights_of(gpu, &buffer, indirect.settings().lobes, Precision::F32)
    })
}

/// The virtual lights of a buffer, read back; packed ones as the oracle unpacks them.
pub fn lights_of<R: Real>(
    gpu: &Gpu,
    buffer: &wgpu::Buffer,
    lobes: Lobes,
    precision: Precision,
) -> Result<Vec<Vsgl<R>>, DeviceError> {
    let number = |value: f32| R::constant(f64::from(value));
    let vector = |[x, y, z]: [f32; 3]| Vector3::new(number(x), number(y), number(z));
    let lobe = |axis, sharpness, coefficient| Lobe {
        axis: vector(axis),
        sharpness: number(sharpness),
        coefficient: vector(coefficient),
    };
    let unpacked = |position, variance, diffuse, specular: Option<SglowPackedLobe>| {
        let diffuse: Lobe<R> = packed_lobe(diffuse).lobe();
        Vsgl {
            position: vector(position),
            variance: number(variance),
            diffuse,
            diffuse_mean_length: vmf::mean_length(diffuse.sharpness),
            specular: specular.map(|lobe| packed_lobe(lobe).lobe()),
        }
    };
    Ok(match (precision, lobes) {
        (Precision::F32, Lobes::Diffuse) => readback::buffer::<SglowVsglDiffuse>(gpu, buffer)?
            .into_iter()
            .map(|light| Vsgl {
                position: vector(light.position),
                variance: number(light.variance),
                diffuse: lobe(
                    light.diffuse_axis,
                    light.diffuse_sharpness,
                    light.diffuse_coefficient,
                ),
                diffuse_mean_length: number(light.diffuse_mean_length),
                specular: None,
            })
            .collect(),
        (Precision::F32, Lobes::Both) => readback::buffer::<SglowVsglBoth>(gpu, buffer)?
            .into_iter()
            .map(|light| Vsgl {
                position: vector(light.position),
                variance: number(light.variance),
                diffuse: lobe(
                    light.diffuse_axis,
                    light.diffuse_sharpness,
                    light.diffuse_coefficient,
                ),
                diffuse_mean_length: number(light.diffuse_mean_length),
                specular: Some(lobe(
                    light.specular_axis,
                    light.specular_sharpness,
                    light.specular_coefficient,
                )),
            })
            .collect(),
        (Precision::F16, Lobes::Diffuse) => {
            readback::buffer::<SglowPackedVsglDiffuse>(gpu, buffer)?
                .into_iter()
                .map(|light| unpacked(light.position, light.variance, light.diffuse, None))
                .collect()
        }
        (Precision::F16, Lobes::Both) => readback::buffer::<SglowPackedVsglBoth>(gpu, buffer)?
            .into_iter()
            .map(|light| {
                unpacked(light.position, light.variance, light.diffuse, Some(light.specular))
            })
            .collect(),
    })
}

/// The bits of a packed lobe as the numbers that they stand for.
fn packed_lobe(lobe: SglowPackedLobe) -> PackedLobe {
    let halves = |word: u32| [word as u16, (word >> 16) as u16];
    let [red, green] = halves(lobe.red_green);
    let [blue, sharpness] = halves(lobe.blue_sharpness);
    PackedLobe {
        axis: halves(lobe.axis).map(u16::cast_signed),
        color: [red, green, blue],
        sharpness: half::f16::from_bits(sharpness).to_f64(),
        scale: lobe.scale,
    }
}

/// One mip level of the moments of an [`Indirect`], read back: what its textures hold, in the layers of the oracle.
///
/// None where clusters need none. In halves, powers are in the unit of `view`, the light of the last frame, and the
/// weight is apart or the density.
pub fn moments<R: Real>(
    gpu: &Gpu,
    indirect: &Indirect,
    view: &LightView,
    level: u32,
) -> Result<Vec<rsm::Moments<R>>, DeviceError> {
    let Some(moments) = indirect.moments() else { return Ok(Vec::new()) };
    let moments = readback::texture(gpu, &moments, level)?;
    let Some(weights) = indirect.weights().or_else(|| indirect.density()) else {
        return Ok(Vec::new());
    };
    let weights = readback::texture(gpu, &weights, level)?;
    let count = weights.len();
    let stack = |texels: &[[f32; 4]], index: usize| -> Vec<[f32; 4]> {
        texels.iter().skip(index).step_by(count).copied().collect()
    };
    let Some(halves) = indirect.half_moments() else {
        return Ok((0..count).map(|at| rsm::Moments::of_texels(&stack(&moments, at))).collect());
    };
    let halves = readback::texture(gpu, &halves, level)?;
    // A power of two, so that nothing is rounded here.
    let power = |[r, g, b, _]: [f32; 4], w| {
        [r * view.power_unit, g * view.power_unit, b * view.power_unit, w]
    };
    let texels = (0..count).map(|at| {
        let (full, half) = (stack(&moments, at), stack(&halves, at));
        let mut layers = vec![
            full[0],
            power(half[0], weights[at][0]),
            power(half[1], half[1][3] * view.power_unit),
        ];
        if let (Some(&direction), Some(&specular)) = (full.get(1), half.get(2)) {
            layers.extend([power(specular, 0.0), power(direction, direction[3] * view.power_unit)]);
        }
        rsm::Moments::of_texels(&layers)
    });
    Ok(texels.collect())
}

/// What kernels have in common.
pub fn sample_settings(settings: &Settings, view: &LightView) -> SampleSettings {
    SampleSettings {
        count: settings.lights,
        kernel: match settings.sample().solver {
            Solver::None => OracleKernel::Previous,
            Solver::Bisection => {
                OracleKernel::Modified(OracleSolver::Bisection { iterations: settings.iterations })
            }
            Solver::Bracketed => OracleKernel::Modified(OracleSolver::Bracketed),
        },
        scale: f64::from(settings.size_factor),
        origin: vector(view.origin),
        minimum_variance: f64::from(view.minimum_variance),
        emission: emission(settings),
    }
}

/// The indirect light of a frame without visibility, by brute force: every texel of the reflective shadow map as a lit
/// facet with the real BRDF at both ends, in f64. See [`sglow_oracle::vpl`].
///
/// `progress` gets how many of the pixels are done, from several threads, and says whether to go on; the result is
/// `None` if it said no.
pub fn unshadowed(
    view: &LightView,
    settings: &Settings,
    rsm: &Surfaces,
    gbuffer: &Surfaces,
    eye: Vec3,
    progress: impl Fn(usize, usize) -> bool + Sync,
) -> Option<Vec<Reflected>> {
    by_facets(view, settings, rsm, &texels(gbuffer), eye, progress)
}

/// The same of some pixels alone, by their numbers, in their order; black of a number that the picture does not have.
pub fn unshadowed_at(
    view: &LightView,
    settings: &Settings,
    rsm: &Surfaces,
    gbuffer: &Surfaces,
    pixels: &[usize],
    eye: Vec3,
    progress: impl Fn(usize, usize) -> bool + Sync,
) -> Option<Vec<Reflected>> {
    let all: Vec<SurfaceTexel> = texels(gbuffer);
    let absent = SurfaceTexel::decode([0.0, 0.0, 0.0, -1.0], [0.0; 4], [0.0; 4]);
    let some: Vec<SurfaceTexel> =
        pixels.iter().map(|&pixel| all.get(pixel).copied().unwrap_or(absent)).collect();
    by_facets(view, settings, rsm, &some, eye, progress)
}

fn by_facets(
    view: &LightView,
    settings: &Settings,
    rsm: &Surfaces,
    receivers: &[SurfaceTexel],
    eye: Vec3,
    progress: impl Fn(usize, usize) -> bool + Sync,
) -> Option<Vec<Reflected>> {
    let facets = counted_facets(view, settings, rsm, |_| 1.0);
    facets.reflect(receivers, vector(eye), &growing(receivers.len(), progress))
}

/// The lit facets of the reflective shadow map, the power of each texel times how often it counts.
pub fn counted_facets(
    view: &LightView,
    settings: &Settings,
    rsm: &Surfaces,
    counted: impl Fn([usize; 2]) -> f64,
) -> TexelFacets {
    let size = [settings.map as usize; 2];
    let lights = MapLights::of(view);
    TexelFacets::of_counted_map(lights.of_map(), &texels(rsm), size, ndf(settings.ndf), counted)
}

/// Reports how many of `total` pixels are done: threads report out of order, progress only grows.
fn growing(
    total: usize,
    progress: impl Fn(usize, usize) -> bool + Sync,
) -> impl Fn(usize) -> bool + Sync {
    let most = AtomicUsize::new(0);
    move |done| progress(most.fetch_max(done, Ordering::Relaxed).max(done), total)
}

/// The oracle's vectors as pixels of a picture.
pub fn pixels(reflected: &[Reflected], part: impl Fn(&Reflected) -> Vector3) -> Pixels {
    reflected
        .iter()
        .map(|reflected| {
            let [r, g, b] = part(reflected).to_array();
            [r as f32, g as f32, b as f32, 1.0]
        })
        .collect()
}
