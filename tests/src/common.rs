//! What the tests share: a device, comparisons that count, and inputs made by a fixed generator.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::OnceLock;

use glam::Vec3;
use sglow_graph::Description;
use sglow_oracle::fis::stress::{Random, Stress};
use sglow_oracle::rsm::Pyramid;
use sglow_oracle::{Bounded, Real, Vector3};
use sglow_renderer::device::Gpu;
use sglow_renderer::frame;
use sglow_renderer::plan::{Plan, Surfaces};
use sglow_runtime::indirect::{Indirect, Inputs, PARTS, SurfaceViews};
use sglow_runtime::light::LightView;
use sglow_runtime::occluders::Occluders;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::{Bounds, Light, LightKind, Scene};
use sglow_shader_gen::library::Library;
use sglow_shader_gen::matrix::Variant;
use sglow_shader_gen::package::{InMemory, in_memory};

/// The device that all tests use.
pub(crate) fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| {
        Gpu::open(None).expect("a Vulkan driver: `cargo xtask test` makes sure that there is one")
    })
}

/// The library and its legal variants, which are read once.
fn known() -> &'static (Library, Vec<Variant>) {
    static KNOWN: OnceLock<(Library, Vec<Variant>)> = OnceLock::new();
    KNOWN.get_or_init(|| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders");
        let library = Library::load(folder.as_ref()).unwrap();
        let variants = library.variants();
        (library, variants)
    })
}

/// The library.
pub(crate) fn library() -> Library {
    known().0.clone()
}

/// Every legal variant, committed or not, generated in memory. Of the shading variants that store halves, which differ from
/// the others in their stores alone, there are the committed ones: all would take as long again.
pub(crate) fn whole_space() -> &'static Package {
    static PACKAGE: OnceLock<Package> = OnceLock::new();
    PACKAGE.get_or_init(|| {
        let (library, mut variants) = known().clone();
        let committed: BTreeSet<Variant> = library.selected().into_iter().collect();
        variants.retain(|one| {
            let halves = one.pass == "shade" && one.value("output") == Some("rgba16float");
            !halves || committed.contains(one)
        });
        packaged("every variant of the library", &library, &variants)
    })
}

/// Variants of a library, generated in memory, with what a manifest would say of them and of the frame.
pub(crate) fn packaged(origin: &str, library: &Library, variants: &[Variant]) -> Package {
    let InMemory { texts, manifest } = in_memory(library, variants).unwrap();
    Package::generated(origin, texts).with_manifest(&manifest).unwrap()
}

/// The variants of these identifiers.
pub(crate) fn package_of(wanted: &BTreeSet<String>) -> Package {
    let (library, variants) = known();
    let mut wanted = wanted.clone();
    let variants: Vec<_> =
        variants.iter().filter(|variant| wanted.remove(&variant.id())).cloned().collect();
    packaged("some variants of the library", library, &variants)
}

/// Comparisons of measured numbers with values and their tolerances.
#[derive(Default)]
pub(crate) struct Comparison {
    compared: usize,
    unpromised: usize,
    violations: usize,
    worst: Option<(f64, String)>,
}

impl Comparison {
    /// Compares one number.
    pub(crate) fn number(
        &mut self,
        name: impl FnOnce() -> String,
        measured: f32,
        expected: Bounded,
    ) {
        if !expected.promises() {
            self.unpromised += 1;
            return;
        }
        self.compared += 1;
        let excess = (f64::from(measured) - expected.value()).abs() / expected.error().max(1e-300);
        let holds = expected.admits(measured) && measured.is_finite();
        if !holds {
            self.violations += 1;
        }
        let excess = if excess.is_nan() { f64::INFINITY } else { excess };
        if self.worst.as_ref().is_none_or(|(worst, _)| excess > *worst) {
            let text = format!(
                "{}: measured {measured:e} ({:#010x}), expected {:e} within {:e}",
                name(),
                measured.to_bits(),
                expected.value(),
                expected.error()
            );
            self.worst = Some((excess, text));
        }
    }

    /// Compares three numbers.
    pub(crate) fn vector(&mut self, name: &str, measured: [f32; 3], expected: Vector3<Bounded>) {
        for (index, (measured, expected)) in
            measured.into_iter().zip(expected.to_array()).enumerate()
        {
            self.number(|| format!("{name}[{index}]"), measured, expected);
        }
    }

    /// Compares the four channels of a texel.
    pub(crate) fn texel(&mut self, name: &str, measured: [f32; 4], expected: [Bounded; 4]) {
        for (index, (measured, expected)) in measured.into_iter().zip(expected).enumerate() {
            self.number(|| format!("{name}, channel {index}"), measured, expected);
        }
    }

    /// How many comparisons did not hold.
    pub(crate) fn violations(&self) -> usize {
        self.violations
    }

    /// Everything holds, there was something to hold, and a promise was given for nearly all of it.
    #[track_caller]
    pub(crate) fn assert_holds(&self, what: &str) {
        let (excess, worst) =
            self.worst.clone().unwrap_or((0.0, "nothing was compared".to_owned()));
        println!(
            "{what}: {} compared, {} without a promise, {} violations; worst at {excess:.3} of its tolerance: {worst}",
            self.compared, self.unpromised, self.violations
        );
        assert!(self.compared > 0, "{what}: nothing was compared");
        assert!(
            self.unpromised * 20 <= self.compared,
            "{what}: {} of {} have no tolerance",
            self.unpromised,
            self.compared + self.unpromised
        );
        assert_eq!(self.violations, 0, "{what}: {worst}");
    }

    /// The negative control: something does not hold.
    #[track_caller]
    pub(crate) fn assert_fails(&self, what: &str) {
        println!(
            "{what}: {} of {} comparisons fail, as they should",
            self.violations, self.compared
        );
        assert!(self.violations > 0, "{what} went unnoticed in {} comparisons", self.compared);
    }
}

/// The text of a variant with one thing broken on purpose.
#[track_caller]
pub(crate) fn broken(id: &str, from: &str, to: &str) -> Package {
    let package = whole_space();
    let text = package.text(id).unwrap().to_owned();
    assert!(text.contains(from), "{id} has no '{from}' to break");
    package.clone().with_text(id, text.replace(from, to))
}

/// A light of a kind, above a scene of radius about two.
pub(crate) fn light(kind: LightKind, size: u32) -> LightView {
    let light = Light {
        name: "test".to_owned(),
        kind,
        position: [0.3, 2.5, 0.2],
        direction: Vec3::new(0.1, -1.0, 0.15).normalize().into(),
        intensity: [30.0, 25.0, 12.0],
        range: None,
        map_share: 1.0,
    };
    let corners = [[-1.5, -1.0, -1.2], [1.4, 1.2, 1.3]];
    sglow_renderer::light::view(&light, &Bounds::around(corners), size)
}

/// A light of each kind in one map, with eight faces.
pub(crate) fn lights(size: u32) -> LightView {
    LightView::several(&KINDS.map(|kind| light(kind, size))).unwrap()
}

/// The kinds of lights.
pub(crate) const KINDS: [LightKind; 3] =
    [LightKind::Spot { inner: 0.3, outer: 0.9 }, LightKind::Directional, LightKind::Point];

/// Random surfaces: positions in a box, normals towards the upper half, all materials, some texels empty.
pub(crate) fn random_surfaces(size: [u32; 2], seed: u64) -> frame::Surfaces {
    let mut random = Random::new(seed);
    let mut uniform = move || random.uniform() as f32;
    let mut surfaces =
        frame::Surfaces { position: Vec::new(), normal: Vec::new(), base_color: Vec::new() };
    for _ in 0..size[0] * size[1] {
        let position = [uniform() * 3.0 - 1.5, uniform() * 2.0 - 1.0, uniform() * 2.4 - 1.2];
        let normal = loop {
            let normal = Vec3::new(uniform() * 2.0 - 1.0, uniform(), uniform() * 2.0 - 1.0);
            if (0.1..1.0).contains(&normal.length()) {
                break normal.normalize();
            }
        };
        let present = uniform() > 0.1;
        let dielectric = if present { 0.08 * uniform() } else { -1.0 };
        let roughness = 0.1 + 0.9 * uniform();
        surfaces.position.push([position[0], position[1], position[2], dielectric]);
        surfaces.normal.push([normal.x, normal.y, normal.z, roughness * roughness]);
        surfaces.base_color.push([uniform(), uniform(), uniform(), uniform() * uniform()]);
    }
    surfaces
}

/// Surface textures of 32-bit floats that hold these surfaces to the bit.
pub(crate) struct Uploaded {
    views: [wgpu::TextureView; 3],
}

impl Uploaded {
    pub(crate) fn new(surfaces: &frame::Surfaces, size: [u32; 2]) -> Self {
        let views = [&surfaces.position, &surfaces.normal, &surfaces.base_color].map(|pixels| {
            let texture = gpu().device.create_texture(&wgpu::TextureDescriptor {
                label: Some("test"),
                size: extent(size, 1),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba32Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            write(&texture, bytemuck::cast_slice(pixels), size, 1, 16);
            texture.create_view(&Default::default())
        });
        Self { views }
    }

    pub(crate) fn views(&self) -> SurfaceViews<'_> {
        let [position, normal, base_color] = &self.views;
        SurfaceViews { position, normal, base_color }
    }
}

fn extent([width, height]: [u32; 2], layers: u32) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers: layers }
}

/// A density that is hard on what draws by it, on the device and as the device has it: a power-of-two square around a map,
/// with 0 beyond the map.
pub(crate) struct DensityTexture {
    pub(crate) view: wgpu::TextureView,
    pub(crate) pyramid: Pyramid<Bounded>,
}

impl DensityTexture {
    pub(crate) fn new([width, height]: [u32; 2], stress: Stress, seed: u64) -> Self {
        let side = width.max(height).next_power_of_two();
        let mut texels = stress.texels(side as usize, seed);
        for (index, texel) in (0..).zip(&mut texels) {
            if index % side >= width || index / side >= height {
                *texel = 0.0;
            }
        }
        let texels = texels.into_iter().map(f64::from).collect();
        let pyramid = Pyramid::build(side as usize, texels).unwrap();
        let levels = pyramid.top_level() as u32 + 1;
        let texture = gpu().device.create_texture(&wgpu::TextureDescriptor {
            label: Some("test density"),
            size: extent([side; 2], 1),
            mip_level_count: levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let levels: Vec<Vec<Bounded>> = (0..levels)
            .map(|level| {
                let means = pyramid.level(level as usize);
                let rounded: Vec<f32> = means.iter().map(|&mean| mean as f32).collect();
                let bytes = bytemuck::cast_slice(&rounded);
                write_level(&texture, level, bytes, [side >> level; 2], 1, 4);
                rounded.into_iter().map(Bounded::exact).collect()
            })
            .collect();
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        Self { view, pyramid: Pyramid::of_levels(side as usize, levels).unwrap() }
    }
}

/// Writes level 0 of a texture.
pub(crate) fn write(
    texture: &wgpu::Texture,
    bytes: &[u8],
    size: [u32; 2],
    layers: u32,
    texel: u32,
) {
    write_level(texture, 0, bytes, size, layers, texel);
}

fn write_level(
    texture: &wgpu::Texture,
    mip_level: u32,
    bytes: &[u8],
    size: [u32; 2],
    layers: u32,
    texel: u32,
) {
    gpu().queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level,
            origin: wgpu::Origin3d::ZERO,
            aspect: wgpu::TextureAspect::All,
        },
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(size[0] * texel),
            rows_per_image: Some(size[1]),
        },
        extent(size, layers),
    );
}

/// What a frame of settings in a scene takes, at any size.
pub(crate) fn plan(settings: &Settings, scene: &Scene) -> Plan {
    static DESCRIPTION: OnceLock<Description> = OnceLock::new();
    let description = DESCRIPTION.get_or_init(|| library().frame().unwrap().description.clone());
    let surfaces = Surfaces::of(scene, settings.complete);
    Plan::of_any_size(description, settings, &surfaces)
        .unwrap_or_else(|errors| panic!("{settings:?}: {errors}"))
}

/// Indirect light in a scene without occluders.
pub(crate) fn indirect(settings: &Settings, package: &Package) -> Indirect {
    let source = gpu().source(package);
    Indirect::of_parts(source, settings, &PARTS, &Occluders::default()).unwrap()
}

/// Indirect light of random surfaces, encoded and run once.
pub(crate) struct Run {
    pub(crate) indirect: Indirect,
    pub(crate) light: LightView,
    pub(crate) rsm: frame::Surfaces,
    pub(crate) gbuffer: frame::Surfaces,
    pub(crate) eye: Vec3,
}

impl Run {
    pub(crate) fn new(settings: &Settings, kind: LightKind, package: &Package, seed: u64) -> Self {
        Self::lit(settings, light(kind, settings.map), package, seed)
    }

    /// The same of a light, or of several.
    pub(crate) fn lit(settings: &Settings, light: LightView, package: &Package, seed: u64) -> Self {
        let gpu = gpu();
        let rsm = random_surfaces([settings.map; 2], seed);
        let gbuffer = random_surfaces(settings.size, seed + 1);
        let indirect = indirect(settings, package);
        let run = Self { indirect, light, rsm, gbuffer, eye: Vec3::new(0.5, 1.8, 3.0) };
        let rsm = Uploaded::new(&run.rsm, [settings.map; 2]);
        let gbuffer = Uploaded::new(&run.gbuffer, settings.size);
        let inputs =
            Inputs { rsm: rsm.views(), gbuffer: gbuffer.views(), light: &run.light, eye: run.eye };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        run.indirect.encode(&mut encoder, &inputs, None).unwrap();
        gpu.queue.submit([encoder.finish()]);
        gpu.finish().unwrap();
        run
    }
}

/// Settings small enough for a test.
pub(crate) fn small() -> Settings {
    Settings { size: [24, 16], map: 32, lights: 48, camera_lights: 40, ..Settings::default() }
}

/// Copies a folder into another.
pub(crate) fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let (path, to) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &to);
        } else {
            std::fs::copy(&path, &to).unwrap();
        }
    }
}

/// Makes `SHA256SUMS` of a package anew, of the files that it has.
pub(crate) fn reseal(package: &Path) {
    let names = sglow_seal::listed(package).unwrap().0.into_iter();
    let names = names.filter(|name| name != sglow_seal::SUMS);
    let files = names.map(|name| (name.clone(), std::fs::read(package.join(&name)).unwrap()));
    std::fs::write(package.join(sglow_seal::SUMS), sglow_seal::sums(&files.collect())).unwrap();
}
