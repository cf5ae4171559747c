//! What hides virtual lights: `shaders/src/visibility`, and the shading pass that asks.

use glam::Vec3;
use sglow_oracle::fis::stress::Random;
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::tolerance::ULP;
use sglow_oracle::visibility::light_shadow::texel;
use sglow_oracle::visibility::map::distance;
use sglow_oracle::visibility::{Maps, Point, Seen, View, exact, light_fill, light_points, visible};
use sglow_oracle::vsgl::Vsgl;
use sglow_oracle::{Bounded, Vector3, shade};
use sglow_renderer::frame::{Renderer, Surfaces};
use sglow_renderer::stages::Stages as _;
use sglow_renderer::variants::Variants as _;
use sglow_renderer::{readback, reference};
use sglow_runtime::execute::{Inputs, Lists};
use sglow_runtime::host;
use sglow_runtime::indirect::{Indirect, IndirectError};
use sglow_runtime::occluders::{Occluders, SUBSETS};
use sglow_runtime::package::Package;
use sglow_runtime::points::Geometry;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shaders::{
    Lobes, Ndf, Precision, SglowShadowPoint, SglowVsglDiffuse, Specular, Visibility as Axis,
};

use wgpu::util::DeviceExt as _;

use crate::common::{Comparison, Uploaded, broken, gpu, whole_space};
use config::Config;

mod config;
mod defaults;
mod picture;

/// Triangles as engines have them.
#[derive(Clone, Default)]
struct Mesh {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

impl Mesh {
    fn of_scene(scene: &Scene) -> Self {
        let mut mesh = Self::default();
        for part in &scene.meshes {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(&part.positions);
            mesh.indices.extend(part.indices.iter().map(|index| first + index));
        }
        mesh
    }

    /// With a square about a centre, spanned by two half edges.
    fn with_square(mut self, centre: Vec3, x: Vec3, y: Vec3) -> Self {
        let first = self.positions.len() as u32;
        let corners = [-x - y, x - y, x + y, y - x];
        self.positions.extend(corners.map(|corner| <[f32; 3]>::from(centre + corner)));
        self.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
        self
    }

    fn geometry(&self) -> Geometry<'_> {
        Geometry { positions: &self.positions, indices: &self.indices }
    }

    fn triangles(&self) -> Vec<[Vector3; 3]> {
        let at = |index: u32| reference::vector(self.positions[index as usize]);
        self.indices
            .chunks_exact(3)
            .map(|three| [at(three[0]), at(three[1]), at(three[2])])
            .collect()
    }
}

/// Lights, what they shine on, and what may hide them.
#[derive(Clone)]
struct Stage {
    settings: Settings,
    mesh: Mesh,
    lights: Vec<u8>,
    gbuffer: Surfaces,
    eye: Vec3,
}

impl Stage {
    /// A built-in scene with the lights that the sample pass makes.
    fn of_scene(name: &str, settings: &Settings) -> Self {
        let scene = Scene::builtin(name).unwrap();
        let renderer = Renderer::new(gpu(), whole_space(), &scene, settings, 0).unwrap();
        renderer.render().unwrap();
        Self {
            settings: settings.clone(),
            mesh: Mesh::of_scene(&scene),
            lights: readback::buffer(gpu(), &renderer.indirect().vsgls().unwrap()).unwrap(),
            gbuffer: renderer.read().unwrap().gbuffer,
            eye: renderer.eye(),
        }
    }

    /// White receivers of a normal, lit by diffuse lights of these positions, axes and variances.
    fn made(mesh: Mesh, receivers: &[Vec3], normal: Vec3, lights: &[(Vec3, Vec3, f32)]) -> Self {
        let lights: Vec<SglowVsglDiffuse> = lights
            .iter()
            .map(|&(position, axis, variance)| SglowVsglDiffuse {
                position: position.into(),
                variance,
                diffuse_axis: axis.normalize().into(),
                diffuse_sharpness: 0.5,
                diffuse_coefficient: [1.0, 2.0, 3.0],
                diffuse_mean_length: host::mean_length(0.5) as f32,
            })
            .collect();
        Self {
            settings: Settings {
                size: [receivers.len() as u32, 1],
                lights: lights.len() as u32,
                map: 8,
                lobes: Lobes::Diffuse,
                specular: Specular::None,
                ndf: Ndf::None,
                ..Settings::default()
            },
            mesh,
            lights: bytemuck::cast_slice(&lights).to_vec(),
            gbuffer: Surfaces {
                position: receivers.iter().map(|at| at.extend(0.0).into()).collect(),
                normal: vec![normal.extend(1.0).into(); receivers.len()],
                base_color: vec![[1.0, 1.0, 1.0, 0.0]; receivers.len()],
            },
            eye: Vec3::new(0.3, 0.2, 9.0),
        }
    }

    fn config(&self, visibility: Axis) -> Config {
        let Settings { lobes, precision, lights: count, .. } = self.settings;
        Config { points: 2048, levels: 2, ..Config::new(visibility, lobes, precision, count) }
    }

    /// Runs the maps and the shading pass.
    fn run(&self, config: &Config, package: &Package) -> Run<'_> {
        let settings = config.settings(&self.settings);
        let occluders = Occluders::new(&gpu().device, &settings, self.mesh.geometry()).unwrap();
        let indirect = made(&settings, package, &occluders).unwrap();
        let vsgls = gpu().device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("test lights"),
            contents: &self.lights,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        });
        let gbuffer = Uploaded::new(&self.gbuffer, settings.size);
        let mut given = Inputs::new();
        given.buffer("vsgls", &vsgls);
        occluders.supply(&mut given);
        given.set("least_near", config.least_near).set("bias", config.bias());
        indirect.seen(&mut given, gbuffer.views(), self.eye);
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        indirect.executor().encode_where(|_| true, &mut encoder, &given, None).unwrap();
        gpu().queue.submit([encoder.finish()]);
        gpu().finish().unwrap();
        let atlas = readback::texture(gpu(), &indirect.light_maps().unwrap(), 0).unwrap();
        let Settings { lobes, precision, .. } = settings;
        Run {
            stage: self,
            config: config.clone(),
            lights: reference::lights_of(gpu(), &vsgls, lobes, precision).unwrap(),
            atlas: atlas.into_iter().map(|texel| texel[0]).collect(),
            points: occluders.buffers().find(|one| one.0 == "points").map(|one| one.1.clone()),
            indirect,
        }
    }
}

/// The maps of given lights, and what reflects them.
fn made(
    settings: &Settings,
    package: &Package,
    occluders: &Occluders,
) -> Result<Indirect, IndirectError> {
    let configuration = Config::configuration(settings);
    let source = gpu().source(package);
    Indirect::of_configuration(source, settings, configuration, occluders, &Lists::new())
}

struct Run<'a> {
    stage: &'a Stage,
    config: Config,
    indirect: Indirect,
    points: Option<wgpu::Buffer>,
    lights: Vec<Vsgl<Bounded>>,
    atlas: Vec<f32>,
}

/// A light without its tolerance.
fn plain(light: &Vsgl<Bounded>) -> Vsgl {
    let lobe = |lobe: &sglow_oracle::vsgl::Lobe<Bounded>| sglow_oracle::vsgl::Lobe {
        axis: lobe.axis.value(),
        sharpness: lobe.sharpness.value,
        coefficient: lobe.coefficient.value(),
    };
    Vsgl {
        position: light.position.value(),
        variance: light.variance.value,
        diffuse: lobe(&light.diffuse),
        diffuse_mean_length: light.diffuse_mean_length.value,
        specular: light.specular.as_ref().map(lobe),
    }
}

impl Run<'_> {
    fn maps(&self) -> Maps {
        let config = &self.config;
        Maps {
            tile: config.tile as usize,
            columns: config.columns() as usize,
            near_scale: f64::from(config.near_scale),
            least_near: f64::from(config.least_near),
            bias: f64::from(config.bias()),
        }
    }

    fn tile(&self, light: usize) -> Vec<f32> {
        let Maps { tile, columns, .. } = self.maps();
        let corner = [light % columns * tile, light / columns * tile];
        (0..tile * tile)
            .map(|index| {
                let (x, y) = (corner[0] + index % tile, corner[1] + index / tile);
                self.atlas[y * columns * tile + x]
            })
            .collect()
    }

    fn points(&self) -> Vec<Point> {
        let points: Vec<SglowShadowPoint> =
            readback::buffer(gpu(), self.points.as_ref().unwrap()).unwrap();
        points
            .into_iter()
            .map(|point| Point {
                position: reference::vector(point.position),
                radius: f64::from(point.radius),
                normal: reference::vector(point.normal),
            })
            .collect()
    }

    /// Compares a rasterised atlas with rays. Returns the share of texels where a rasteriser may choose.
    fn compare_rasterised(&self) -> (Comparison, f64) {
        let maps = self.maps();
        let triangles = self.stage.mesh.triangles();
        let mut comparison = Comparison::default();
        let (mut uncertain, mut texels) = (0, 0);
        for (light, vsgl) in self.lights.iter().enumerate() {
            let view = View::of_light(&plain(vsgl), &maps);
            for (index, &measured) in self.tile(light).iter().enumerate() {
                let at = [index % maps.tile, index / maps.tile];
                // Vertices may be snapped to a sixteenth of a texel (Vulkan's least subPixelPrecisionBits is 4).
                let expected = texel(&triangles, &view, at, maps.tile, 1.0 / 16.0);
                texels += 1;
                if !expected.certain {
                    uncertain += 1;
                    continue;
                }
                // Vertices move independently of each other, hence the 2. A depth is a dozen products and a quotient
                // of numbers up to a few units: about 16 ULP of 1. The packed lights' axes are exact to as much.
                let error = 2.0 * expected.spread + 16.0 * ULP + 1e-5 * expected.value;
                let expected = Bounded::with_error(expected.value, error);
                comparison.number(|| format!("light {light} texel {at:?}"), measured, expected);
            }
        }
        (comparison, f64::from(uncertain) / f64::from(texels))
    }

    /// Compares what points left with the oracle's discs. Returns the share of texels where rounding may choose.
    fn compare_splats(&self) -> (Comparison, f64) {
        let config = &self.config;
        let maps = self.maps();
        let splats: Vec<u32> = readback::buffer(gpu(), &self.indirect.splats().unwrap()).unwrap();
        let points = self.points();
        let mut comparison = Comparison::default();
        let (mut uncertain, mut held) = (0, 0);
        for (light, vsgl) in self.lights.iter().enumerate() {
            let view = View::of_light(vsgl, &maps);
            let set = light % SUBSETS as usize * config.points as usize;
            let points = &points[set..][..config.points as usize];
            let expected = light_points::splats(&view, points, &maps, config.reach as usize);
            let tile = &splats[light * maps.tile * maps.tile..][..maps.tile * maps.tile];
            for (index, (&bits, expected)) in tile.iter().zip(expected).enumerate() {
                held += usize::from(expected.low > 0.0);
                uncertain += usize::from(expected.is_uncertain());
                let middle = 0.5 * (expected.low + expected.high);
                let half = 0.5 * (expected.high - expected.low) + 1e-15 * middle;
                comparison.number(
                    || format!("light {light} texel {index}"),
                    f32::from_bits(bits),
                    Bounded::with_error(middle, half),
                );
            }
        }
        assert!(held > 1000, "{held} texels hold a disc");
        (comparison, uncertain as f64 / held as f64)
    }

    /// Compares the filled atlas with the oracle's, of what the points left on the device.
    fn compare_filled(&self) -> Comparison {
        let maps = self.maps();
        let splats: Vec<u32> = readback::buffer(gpu(), &self.indirect.splats().unwrap()).unwrap();
        let mut comparison = Comparison::default();
        for light in 0..self.lights.len() {
            let tile = &splats[light * maps.tile * maps.tile..][..maps.tile * maps.tile];
            let tile: Vec<Bounded> =
                tile.iter().map(|&bits| Bounded::exact(f32::from_bits(bits))).collect();
            let levels = self.config.levels as usize;
            let expected = light_fill::fill(&tile, maps.tile, levels);
            for (index, (measured, expected)) in
                self.tile(light).into_iter().zip(expected).enumerate()
            {
                comparison.number(|| format!("light {light} texel {index}"), measured, expected);
            }
        }
        comparison
    }

    /// Compares the shading with the oracle's, which looks into the device's atlas, or asks `seen` about light and
    /// pixel. Returns the shares of lights that are seen, and of those where rounding decides.
    fn compare_shading(
        &self,
        seen: impl Fn(usize, &Vsgl<Bounded>, &SurfaceTexel<Bounded>) -> Seen,
    ) -> (Comparison, [f64; 2]) {
        let surfaces: Vec<SurfaceTexel<Bounded>> = reference::texels(&self.stage.gbuffer);
        let model = reference::model(self.indirect.settings());
        let eye = Vector3::constant(reference::vector(self.stage.eye));
        let read = |texture: wgpu::Texture| readback::texture(gpu(), &texture, 0).unwrap();
        let diffuse = self.indirect.diffuse().map(read);
        let specular = self.indirect.specular().map(read);
        let mut comparison = Comparison::default();
        let mut counts = [0; 3];
        for (index, surface) in surfaces.iter().enumerate() {
            let lights: Vec<_> = self
                .lights
                .iter()
                .enumerate()
                .map(|(light, vsgl)| {
                    let seen = seen(light, vsgl, surface);
                    counts[seen as usize] += usize::from(surface.present);
                    (*vsgl, seen)
                })
                .collect();
            let expected = shade::shade_visible(surface, eye, lights, &model);
            for (name, measured, expected) in [
                ("diffuse", &diffuse, expected.diffuse),
                ("specular", &specular, expected.specular),
            ] {
                if let Some(measured) = measured {
                    let [r, g, b, _] = measured[index];
                    comparison.vector(&format!("{name} of pixel {index}"), [r, g, b], expected);
                }
            }
        }
        let total = counts.iter().sum::<usize>() as f64;
        let share = |seen: Seen| counts[seen as usize] as f64 / total;
        (comparison, [share(Seen::Yes), share(Seen::Uncertain)])
    }

    fn by_the_atlas(&self) -> (Comparison, [f64; 2]) {
        let maps = self.maps();
        self.compare_shading(|light, vsgl, surface| {
            visible(light, vsgl, surface.position, surface.normal, &maps, &self.atlas)
        })
    }

    fn receivers(&self) -> Vec<SurfaceTexel> {
        let surfaces = reference::texels(&self.stage.gbuffer);
        surfaces.into_iter().filter(|surface: &SurfaceTexel| surface.present).collect()
    }

    /// Whether each pixel with a surface sees each light, by rays.
    fn expected(&self) -> Vec<Vec<bool>> {
        let maps = self.maps();
        let views: Vec<View> =
            self.lights.iter().map(|light| View::of_light(&plain(light), &maps)).collect();
        let positions: Vec<Vector3> =
            self.receivers().iter().map(|surface| surface.position).collect();
        exact::all_seen(&self.stage.mesh.triangles(), &views, &positions)
    }

    /// The share of pairs of light and pixel that the map decides wrongly: too dark, too bright, and weighted by the
    /// light that arrives without visibility.
    fn wrong(&self, expected: &[Vec<bool>]) -> [f64; 3] {
        let maps = self.maps();
        let lights: Vec<Vsgl> = self.lights.iter().map(plain).collect();
        let surfaces = self.receivers();
        let model = reference::model(self.indirect.settings());
        let eye = reference::vector(self.stage.eye);
        let (mut dark, mut bright, mut weighted, mut pairs, mut total) = (0, 0, 0.0, 0, 0.0);
        for (surface, expected) in surfaces.iter().zip(expected) {
            for (index, (light, &expected)) in lights.iter().zip(expected).enumerate() {
                let way = light.position - surface.position;
                // Behind the surface no light matters.
                if way.dot(surface.normal) <= 0.0 {
                    continue;
                }
                let reflected = shade::shade_visible(surface, eye, [(*light, Seen::Yes)], &model);
                let weight = reflected.total().luminance();
                let found =
                    visible(index, light, surface.position, surface.normal, &maps, &self.atlas);
                pairs += 1;
                total += weight;
                if (found == Seen::Yes) != expected {
                    weighted += weight;
                    dark += usize::from(expected);
                    bright += usize::from(!expected);
                }
            }
        }
        [dark as f64 / pairs as f64, bright as f64 / pairs as f64, weighted / total]
    }
}

fn small(lobes: Lobes, precision: Precision) -> Settings {
    Settings { size: [32, 24], map: 32, lights: 20, lobes, precision, ..Settings::default() }
}

#[test]
fn rasterised_maps_agree_with_rays() {
    for (name, lobes, precision) in [
        ("cornell", Lobes::Both, Precision::F32),
        ("cornell", Lobes::Diffuse, Precision::F32),
        ("cornell-glossy", Lobes::Both, Precision::F16),
        ("cornell", Lobes::Diffuse, Precision::F16),
    ] {
        let stage = Stage::of_scene(name, &small(lobes, precision));
        for tile in [32, 64] {
            let config = Config { tile, ..stage.config(Axis::ShadowMap) };
            let (comparison, uncertain) = stage.run(&config, whole_space()).compare_rasterised();
            let what = format!("rasterised maps of {name}, {lobes}, {precision}, {tile}");
            println!("{what}: {:.2} % uncertain", 100.0 * uncertain);
            comparison.assert_holds(&what);
            // Two lines of texels along each of a score of edges.
            assert!(uncertain < 0.15, "{uncertain}");
        }
    }
}

#[test]
fn maps_of_points_agree_with_the_oracle() {
    for (lobes, precision) in [
        (Lobes::Both, Precision::F32),
        (Lobes::Diffuse, Precision::F32),
        (Lobes::Both, Precision::F16),
        (Lobes::Diffuse, Precision::F16),
    ] {
        let stage = Stage::of_scene("cornell", &small(lobes, precision));
        for (tile, reach, levels) in [(64, 2, 2), (32, 1, 5), (8, 0, 0), (16, 8, 4)] {
            let config = Config { tile, reach, levels, ..stage.config(Axis::Imperfect) };
            let run = stage.run(&config, whole_space());
            let (comparison, uncertain) = run.compare_splats();
            let what = format!("points, {lobes}, {precision}, tile {tile}, reach {reach}");
            println!("{what}: {:.2} % uncertain", 100.0 * uncertain);
            comparison.assert_holds(&what);
            assert!(uncertain < 0.03, "{uncertain}");
            run.compare_filled().assert_holds(&format!("filled, {what}, {levels} levels"));
        }
    }
}

#[test]
fn shading_agrees_with_the_oracle() {
    for visibility in [Axis::ShadowMap, Axis::Imperfect] {
        for (specular, ndf) in [(Specular::Asg, Ndf::Ggx), (Specular::None, Ndf::None)] {
            for lobes in Lobes::ALL {
                for precision in Precision::ALL {
                    let settings = Settings { specular, ndf, ..small(lobes, precision) };
                    let stage = Stage::of_scene("cornell-glossy", &settings);
                    let run = stage.run(&stage.config(visibility), whole_space());
                    let (comparison, [seen, uncertain]) = run.by_the_atlas();
                    let what = run.indirect.settings().shade().id();
                    println!("{what}: {seen:.3} seen, {uncertain:.5} uncertain");
                    comparison.assert_holds(&what);
                    assert!((0.2..0.9).contains(&seen) && uncertain < 2e-3, "{seen} {uncertain}");
                }
            }
        }
    }
}

#[test]
fn a_broken_shader_is_noticed() {
    let stage = Stage::of_scene("cornell", &small(Lobes::Both, Precision::F32));
    let raster = stage.config(Axis::ShadowMap);
    for (from, to, what) in [
        ("offset.y - offset.x", "offset.x - offset.y", "a mirrored octant"),
        ("select(side, -side, negative)", "select(-side, side, negative)", "the other octants"),
        ("folded.x + folded.y + offset.z", "folded.x + folded.y", "another projection"),
        ("z > -0.5", "z > 0.9", "another basis"),
    ] {
        let package = broken("light_shadow-both-f32", from, to);
        stage.run(&raster, &package).compare_rasterised().0.assert_fails(what);
    }
    let points = stage.config(Axis::Imperfect);
    for (from, to, what) in [
        ("1.7320508 * point.radius", "1.7 * point.radius", "another nearest point"),
        ("facing * point.radius", "0.95 * facing * point.radius", "smaller discs"),
        ("min(facing * inverse_height", "min(1.0 / distance", "discs that face the light"),
        ("light % sglow_light_maps.subsets", "0u", "one subset for all"),
        ("all(texel == centre) ||", "", "small discs that vanish"),
    ] {
        let package = broken("light_points-both-f32", from, to);
        stage.run(&points, &package).compare_splats().0.assert_fails(what);
    }
    for (from, to, what) in [
        (
            "select(vec4<f32>(0.0), vec4<f32>(1.0), values > vec4<f32>(0.0))",
            "vec4<f32>(1.0)",
            "holes that are pulled",
        ),
        (
            "select(vec4<f32>(0.0), vec4<f32>(9.0, 3.0, 3.0, 1.0), values > vec4<f32>(0.0))",
            "vec4<f32>(9.0, 3.0, 3.0, 1.0)",
            "holes that are pushed",
        ),
        ("(x & 1u) == 1u", "(x & 1u) == 0u", "the neighbour on the other side"),
    ] {
        let package = broken("light_fill", from, to);
        stage.run(&points, &package).compare_filled().assert_fails(what);
    }
    for visibility in [Axis::ShadowMap, Axis::Imperfect] {
        for (from, to, what) in [
            ("distance <= view.near", "distance >= view.near", "a comparison the wrong way"),
            ("lift * sglow_in_basis", "0.0 * sglow_in_basis", "a forgotten bias"),
            ("point.x - point.y", "point.y - point.x", "a mirrored map"),
            ("if !(lifted.z > 0.0)", "if false", "light from behind"),
        ] {
            let package =
                broken(&format!("shade-cosine-fitted-asg-ggx-both-f32-{visibility}"), from, to);
            let run = stage.run(&stage.config(visibility), &package);
            run.by_the_atlas().0.assert_fails(&format!("{visibility}: {what}"));
        }
    }
}

/// A floor alone, and lights above it that look down aslant.
fn floor() -> Stage {
    let mesh = Mesh::default().with_square(Vec3::ZERO, Vec3::X * 20.0, Vec3::Y * 20.0);
    let mut random = Random::new(12);
    let mut within = |low: f64, high: f64| (low + (high - low) * random.uniform()) as f32;
    let receivers: Vec<Vec3> =
        (0..600).map(|_| Vec3::new(within(-4.0, 4.0), within(-4.0, 4.0), 0.0)).collect();
    let lights: Vec<_> = (0..40)
        .map(|_| {
            let position = Vec3::new(within(-2.0, 2.0), within(-2.0, 2.0), within(0.2, 2.0));
            let axis = Vec3::new(within(-1.0, 1.0), within(-1.0, 1.0), -within(0.3, 1.0));
            (position, axis, within(1e-5, 1e-3))
        })
        .collect();
    Stage::made(mesh, &receivers, Vec3::Z, &lights)
}

/// Seen is all that lies before a light's plane. Where lifting the receiver may carry it through that plane, which the
/// comparison with the oracle looks into, both are right.
fn before_the_plane(vsgl: &Vsgl<Bounded>, surface: &SurfaceTexel<Bounded>, maps: &Maps) -> Seen {
    let offset = View::of_light(&plain(vsgl), maps).offset(surface.position.value());
    let lift = 2.0 * maps.bias * distance(offset);
    if offset.z.abs() <= lift {
        Seen::Uncertain
    } else if offset.z > 0.0 {
        Seen::Yes
    } else {
        Seen::No
    }
}

#[test]
fn a_lit_plane_has_no_acne_and_half_the_bias_does_not_do() {
    let stage = floor();
    let compare = |config: &Config, package: &Package| {
        let run = stage.run(config, package);
        let maps = run.maps();
        let (comparison, shares) =
            run.compare_shading(|_, vsgl, surface| before_the_plane(vsgl, surface, &maps));
        println!("{shares:?}");
        comparison
    };
    for tile in [16, 64, 256] {
        let config = Config { tile, ..stage.config(Axis::ShadowMap) };
        compare(&config, whole_space()).assert_holds(&format!("a floor, tile {tile}"));
        for bias_scale in [0.5, 0.0] {
            let config = Config { bias_scale, ..config.clone() };
            compare(&config, whole_space())
                .assert_fails(&format!("a floor, tile {tile}, {bias_scale} of the bias"));
        }
    }
}

#[test]
fn without_geometry_everything_is_visible() {
    let stage = Stage { mesh: Mesh::default(), ..floor() };
    for visibility in [Axis::ShadowMap, Axis::Imperfect] {
        let run = stage.run(&stage.config(visibility), whole_space());
        assert!(run.atlas.iter().all(|texel| *texel == 0.0), "{visibility}");
        let (comparison, [seen, _]) = run.by_the_atlas();
        comparison.assert_holds(&format!("{visibility} of nothing"));
        assert!(seen > 0.5, "{seen}");
        // What is seen is all that lies before the lights' planes.
        let maps = run.maps();
        let (comparison, _) =
            run.compare_shading(|_, vsgl, surface| before_the_plane(vsgl, surface, &maps));
        comparison.assert_holds(&format!("{visibility} of nothing, by planes"));
    }
}

#[test]
fn an_occluder_darkens_what_rays_say_it_darkens() {
    // A square between a light and a wall. The wall's pixels are dark where the light is hidden.
    let side = 64;
    let receivers: Vec<Vec3> = (0..side * side)
        .map(|index| {
            let at = |index: u32| 4.0 * (index as f32 + 0.5) / side as f32 - 2.0;
            Vec3::new(at(index % side), at(index / side), 0.0)
        })
        .collect();
    let mesh = Mesh::default().with_square(Vec3::ZERO, Vec3::X * 3.0, Vec3::Y * 3.0).with_square(
        Vec3::new(0.1, -0.05, 1.0),
        Vec3::new(0.3, 0.1, 0.0),
        Vec3::new(-0.1, 0.3, 0.1),
    );
    let lights = [(Vec3::new(0.15, 0.1, 2.0), Vec3::new(0.1, 0.2, -1.0), 1e-4)];
    let mut stage = Stage::made(mesh, &receivers, Vec3::Z, &lights);
    stage.settings.size = [side, side];
    let triangles = stage.mesh.triangles();
    for visibility in [Axis::ShadowMap, Axis::Imperfect] {
        let config = Config { points: 8192, ..stage.config(visibility) };
        let measure = |package: &Package| {
            let run = stage.run(&config, package);
            let maps = run.maps();
            let view = View::of_light(&plain(&run.lights[0]), &maps);
            let pixels = readback::texture(gpu(), &run.indirect.diffuse().unwrap(), 0).unwrap();
            let radius = if visibility == Axis::Imperfect { run.points()[0].radius } else { 0.0 };
            let (mut wrong, mut far, mut shadowed) = (0, 0, 0);
            for (pixel, &receiver) in pixels.iter().zip(&receivers) {
                let position = reference::vector(receiver);
                let expected = exact::seen(&triangles, &view, position);
                shadowed += usize::from(!expected);
                if (pixel[0] > 0.0) == expected {
                    continue;
                }
                wrong += 1;
                // Twice half a texel's diagonal, for the texel that is looked at and for the lift, where it falls on the
                // wall; with points, discs reach over the edge by their radius, which the wall sees twice as large, and
                // holes are filled from texels four times as wide.
                let way = distance(view.offset(position));
                let texel = 2f64.sqrt() / maps.tile as f64 * way * 2.0;
                let band =
                    if visibility == Axis::ShadowMap { texel } else { 4.0 * texel + 2.0 * radius };
                let edge = (0..32).any(|step| {
                    let (sine, cosine) = (f64::from(step) * 0.196_35).sin_cos();
                    [0.5, 1.0].iter().any(|share| {
                        let aside = Vector3::new(cosine, sine, 0.0) * (band * share);
                        exact::seen(&triangles, &view, position + aside) != expected
                    })
                });
                far += usize::from(!edge);
            }
            println!(
                "{visibility}: {wrong} of {} wrong, {far} of them away from the shadow's edge, {shadowed} in shadow",
                pixels.len()
            );
            (wrong as f64 / pixels.len() as f64, far, shadowed)
        };
        let (wrong, far, shadowed) = measure(whole_space());
        assert!(shadowed > 100);
        assert_eq!(far, 0, "{visibility}: wrong away from the shadow's edge");
        // The shadow's outline is about 100 pixels long, and a texel about a pixel wide.
        let most = if visibility == Axis::ShadowMap { 0.025 } else { 0.05 };
        assert!(wrong < most, "{visibility}: {wrong}");
        // Negative controls: a map that is not looked into, or in a mirror.
        let id = format!("shade-cosine-fitted-none-none-diffuse-f32-{visibility}");
        for (from, to) in [
            ("distance <= view.near", "0.0 <= view.near"),
            ("point.x - point.y", "point.y - point.x"),
        ] {
            let (wrong, far, _) = measure(&broken(&id, from, to));
            assert!(far > 0 && wrong > most, "{visibility}: {to}: {wrong} {far}");
        }
    }
}

#[test]
fn settings_that_cannot_be_are_named() {
    let config = Config::new(Axis::Imperfect, Lobes::Both, Precision::F32, 1024);
    let fault = |config: &Config| {
        let settings = config.settings(&small(Lobes::Both, Precision::F32));
        // Some triangles, by another number of points.
        let few = Settings { shadow_points: 1, ..settings.clone() };
        let mesh = floor().mesh;
        let occluders = Occluders::new(&gpu().device, &few, mesh.geometry()).unwrap();
        let made = made(&settings, &Package::embedded(), &occluders);
        made.err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert_eq!(fault(&Config { count: 1, points: 1, ..config.clone() }), "");
    let raster = Config { visibility: Axis::ShadowMap, ..config.clone() };
    for (config, named) in [
        (Config { tile: 48, ..config.clone() }, "tile: a power of two"),
        (Config { tile: 128, ..config.clone() }, "tile: at most 64 with visibility imperfect"),
        (Config { levels: 7, ..config.clone() }, "fill_levels"),
        (
            Config { count: 65536, tile: 256, ..raster },
            "`light_maps`, a texture of 65536 x 65536 texels",
        ),
        (Config { count: 65536, ..config.clone() }, "`splats`, a buffer of 1073741824 bytes"),
        (Config { points: 1 << 20, ..config.clone() }, "it has to be a buffer of 536870912 bytes"),
        (Config { bias_scale: f32::NAN, ..config.clone() }, "`bias_scale` is NaN"),
    ] {
        let found = fault(&config);
        assert!(found.contains(named), "{named}: {found}");
    }
    // All at once.
    let found = fault(&Config { tile: 4, levels: 9, ..config });
    assert!(found.contains("`tile` is 4") && found.contains("`fill_levels` is 9"), "{found}");
    let ragged = Geometry { positions: &[[0.0; 3]], indices: &[0] };
    let made = Occluders::new(&gpu().device, &Settings::default(), ragged);
    assert!(made.unwrap_err().to_string().contains("triangles have three each"));
}
