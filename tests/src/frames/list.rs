//! The configurations whose frames are kept, each with all its settings written out: no default of today stands behind one.

use std::collections::BTreeMap;

use sglow_runtime::settings::Settings;
use sglow_shaders::{
    Cut, Density, Diffuse, Draw, Emitter, Filter, Kernel, Light, Lobes, Ndf, Output, Precision,
    Sharpness, Solver, Space, Specular, SpecularPower, Start, Variance, Visibility,
};

use super::scenes::{Lamp, Place};

/// A configuration, what it is run on, and for how long.
#[derive(Clone, Debug)]
pub(super) struct Case {
    /// Its name in the snapshot.
    pub(super) name: String,
    pub(super) place: Place,
    pub(super) lamp: Lamp,
    pub(super) settings: Settings,
    /// Frames in a row; the light moves between them.
    pub(super) frames: u32,
    /// Whether the eye moves as well, over the G-buffer of the first frame.
    pub(super) eye_moves: bool,
    /// Chains of their own by the density of each frame, which begin so. (Those of a frame begin warped.)
    pub(super) chains: Option<Start>,
    /// Whether chains begin again in the last frame.
    pub(super) restarts: bool,
    /// Whether lights and surfaces are checked against the contract of the shading pass.
    pub(super) checks: bool,
    /// Whether the light is nudged: none of the list is.
    pub(super) nudged: bool,
}

/// Every field of the settings. The picture, the map and the numbers of lights are small; the map is a power of two, the
/// picture is not.
pub(super) fn base() -> Settings {
    Settings {
        size: [33, 17],
        light_faces: 1,
        map: 64,
        lights: 64,
        camera_lights: 40,
        size_factor: 1.0,
        iterations: 12,
        light: Light::Spot,
        lobes: Lobes::Both,
        specular_power: SpecularPower::F0,
        precision: Precision::F32,
        density: Density::Power,
        draw: Draw::Warped,
        space: Space::None,
        kernel: Kernel::Modified,
        solver: Solver::Bracketed,
        filter: Filter::Exact,
        emitter: Emitter::Cosine,
        emission_sharpness: 2.0,
        variance: Variance::Trace,
        sharpness: Sharpness::Exact,
        diffuse: Diffuse::Fitted,
        specular: Specular::Asg,
        ndf: Ndf::Ggx,
        visibility: Visibility::None,
        output: Output::Rgba32float,
        cut: Cut::None,
        tolerance: 0.003,
        shadow_points: 512,
        tile: 16,
        near_scale: 1.5,
        bias_scale: 1.0,
        splat_reach: 2,
        fill_levels: 0,
        mutations: 1,
        small_step: 0.01,
        large_steps: 0.02,
        seed: 1,
        complete: false,
        assumed: Vec::new(),
        others: BTreeMap::new(),
    }
}

/// The settings of [`base`] for what reflects diffusely alone.
fn matt() -> Settings {
    Settings { lobes: Lobes::Diffuse, specular: Specular::None, ndf: Ndf::None, ..base() }
}

/// A list that grows.
struct List(Vec<Case>);

impl List {
    /// One frame of the glossy box.
    fn one(&mut self, name: impl Into<String>, settings: Settings) -> &mut Case {
        self.0.push(Case {
            name: name.into(),
            place: Place::Glossy,
            lamp: Lamp::Own,
            settings,
            frames: 1,
            eye_moves: false,
            chains: None,
            restarts: false,
            checks: false,
            nudged: false,
        });
        self.0.last_mut().expect("it was pushed")
    }

    /// Three frames of the glossy box.
    fn three(&mut self, name: impl Into<String>, settings: Settings) -> &mut Case {
        let case = self.one(name, settings);
        case.frames = 3;
        case
    }
}

/// All configurations.
pub(super) fn list() -> Vec<Case> {
    let mut list = List(Vec::new());
    shading(&mut list);
    kernels(&mut list);
    stored(&mut list);
    chains(&mut list);
    clusters(&mut list);
    cuts(&mut list);
    visibility(&mut list);
    lights(&mut list);
    several(&mut list);
    darkness(&mut list);
    points(&mut list);
    sizes(&mut list);
    scenes(&mut list);
    named(&mut list);
    let mut cases = list.0;
    cases.sort_by(|a, b| a.name.cmp(&b.name));
    cases
}

/// What is reflected towards the eye, and how lights emit it.
fn shading(list: &mut List) {
    list.one("base", base());
    for emitter in Emitter::ALL.into_iter().filter(|emitter| *emitter != base().emitter) {
        list.one(format!("emitter={emitter}"), Settings { emitter, ..base() });
    }
    let (emitter, emission_sharpness) = (Emitter::Lobe, 2.2925);
    list.one("emission_sharpness=2.2925", Settings { emitter, emission_sharpness, ..base() });
    for diffuse in Diffuse::ALL.into_iter().filter(|diffuse| *diffuse != base().diffuse) {
        list.one(format!("diffuse={diffuse}"), Settings { diffuse, ..base() });
    }
    for specular in Specular::ALL.into_iter().filter(|specular| *specular != base().specular) {
        let ndf = if specular == Specular::None { Ndf::None } else { Ndf::Ggx };
        list.one(format!("specular={specular}"), Settings { specular, ndf, ..base() });
    }
    list.one("ndf=beckmann", Settings { ndf: Ndf::Beckmann, ..base() });
    let output = Output::Rgba16float;
    list.one("output=rgba16float", Settings { output, ..base() });
    list.one("output=rgba16float matt", Settings { output, ..matt() });
}

/// Kernels and the lights that are made of them.
fn kernels(list: &mut List) {
    list.one("lobes=diffuse", Settings { lobes: Lobes::Diffuse, ..base() });
    let specular_power = SpecularPower::Albedo;
    list.one("specular_power=albedo", Settings { specular_power, ..base() });
    list.one("variance=planar", Settings { variance: Variance::Planar, ..base() });
    for sharpness in [Sharpness::Toksvig, Sharpness::Banerjee] {
        list.one(format!("sharpness={sharpness}"), Settings { sharpness, ..base() });
    }
    let (emitter, sharpness) = (Emitter::Lobe, Sharpness::Toksvig);
    list.one("emitter=lobe sharpness=toksvig", Settings { emitter, sharpness, ..base() });
    for filter in Filter::ALL {
        for (kernel, solver) in [
            (Kernel::Previous, Solver::None),
            (Kernel::Modified, Solver::Bisection),
            (Kernel::Modified, Solver::Bracketed),
        ] {
            let name = format!("kernel={kernel} solver={solver} filter={filter}");
            list.one(name, Settings { kernel, solver, filter, ..base() });
        }
    }
    let (solver, iterations) = (Solver::Bisection, 5);
    list.one("solver=bisection iterations=5", Settings { solver, iterations, ..base() });
    list.one("size_factor=0.25", Settings { size_factor: 0.25, ..base() });
}

/// What is kept of the map: each precision with each density and all lobes.
fn stored(list: &mut List) {
    for precision in Precision::ALL {
        for density in Density::ALL {
            for lobes in Lobes::ALL {
                let name = format!("precision={precision} density={density} lobes={lobes}");
                let settings = Settings { precision, density, lobes, ..base() };
                list.one(name, settings).checks = density == Density::Power;
            }
        }
    }
    let (density, precision) = (Density::Bidirectional, Precision::F16);
    for emitter in [Emitter::Lobe, Emitter::Disc] {
        let name = format!("density=bidirectional emitter={emitter}");
        list.one(name, Settings { density, emitter, ..base() });
        let name = format!("precision=f16 emitter={emitter}");
        list.one(name, Settings { precision, emitter, ..base() });
    }
    for lobes in Lobes::ALL {
        let specular_power = SpecularPower::Albedo;
        let name = format!("density=bidirectional specular_power=albedo lobes={lobes}");
        list.one(name, Settings { density, specular_power, lobes, ..base() });
    }
    let filter = Filter::Hardware;
    list.one("precision=f16 filter=hardware", Settings { precision, filter, ..base() });
    let specular_power = SpecularPower::Albedo;
    list.one(
        "precision=f16 specular_power=albedo",
        Settings { precision, specular_power, ..base() },
    );
}

/// What is drawn by Markov chains, which are kept between frames.
fn chains(list: &mut List) {
    let draw = Draw::Metropolis;
    for precision in Precision::ALL {
        for density in Density::ALL {
            let name = format!("draw=metropolis precision={precision} density={density}");
            list.three(name, Settings { draw, precision, density, ..base() });
        }
    }
    for count in [1, 7] {
        let name = format!("draw=metropolis lights={count}");
        list.three(name, Settings { draw, lights: count, ..base() });
    }
    let density = Density::Bidirectional;
    let settings = Settings { draw, density, ..base() };
    list.three("draw=metropolis density=bidirectional eye", settings).eye_moves = true;
    list.three("draw=metropolis restart", Settings { draw, ..base() }).restarts = true;
    for (name, settings) in [
        ("mutations=3", Settings { mutations: 3, ..base() }),
        ("small_step=0.1", Settings { small_step: 0.1, ..base() }),
        ("large_steps=0.5", Settings { large_steps: 0.5, ..base() }),
        ("seed=7", Settings { seed: 7, ..base() }),
    ] {
        list.three(format!("draw=metropolis {name}"), Settings { draw, ..settings });
    }
    for start in Start::ALL {
        list.three(format!("start={start}"), base()).chains = Some(start);
    }
}

/// Clusters in place of kernels.
fn clusters(list: &mut List) {
    for space in [Space::Image, Space::World] {
        for density in Density::ALL {
            for draw in Draw::ALL {
                let name = format!("space={space} density={density} draw={draw}");
                list.three(name, Settings { space, density, draw, ..base() });
            }
        }
        for count in [1, 7, 1100] {
            let name = format!("space={space} lights={count}");
            list.three(name, Settings { space, lights: count, ..base() });
        }
        let name = format!("space={space} lobes=diffuse");
        list.one(name, Settings { space, lobes: Lobes::Diffuse, ..base() });
    }
    let space = Space::World;
    for sharpness in [Sharpness::Toksvig, Sharpness::Banerjee] {
        let name = format!("space=world sharpness={sharpness}");
        list.one(name, Settings { space, sharpness, ..base() });
    }
    list.one(
        "space=world variance=planar",
        Settings { space, variance: Variance::Planar, ..base() },
    );
    let specular_power = SpecularPower::Albedo;
    list.one("space=world specular_power=albedo", Settings { space, specular_power, ..base() });
    list.one("space=world emitter=lobe", Settings { space, emitter: Emitter::Lobe, ..base() });
}

/// Cuts through a tree, which draw nothing.
fn cuts(list: &mut List) {
    let (space, emitter) = (Space::Tree, Emitter::Disc);
    let base = Settings { space, emitter, ..base() };
    for precision in Precision::ALL {
        for lobes in Lobes::ALL {
            let name = format!("space=tree precision={precision} lobes={lobes}");
            list.three(name, Settings { precision, lobes, ..base.clone() });
        }
    }
    for count in [1, 7, 1100] {
        list.one(format!("space=tree lights={count}"), Settings { lights: count, ..base.clone() });
    }
    for sharpness in [Sharpness::Toksvig, Sharpness::Banerjee] {
        let name = format!("space=tree sharpness={sharpness}");
        list.one(name, Settings { sharpness, ..base.clone() });
    }
    let variance = Variance::Planar;
    list.one("space=tree variance=planar", Settings { variance, ..base.clone() });
    let specular_power = SpecularPower::Albedo;
    list.one("space=tree specular_power=albedo", Settings { specular_power, ..base.clone() });
    for emitter in [Emitter::Lobe, Emitter::Cosine] {
        list.one(format!("space=tree emitter={emitter}"), Settings { emitter, ..base.clone() });
    }
    let visibility = Visibility::ShadowMap;
    list.one("space=tree visibility=shadow_map", Settings { visibility, ..base.clone() });
    // Neither a density nor its draw has anything to do.
    let (density, draw) = (Density::Bidirectional, Draw::Metropolis);
    list.one("space=tree density=bidirectional", Settings { density, draw, ..base.clone() });
    // A cut for each tile of pixels refines the lights.
    let base = Settings { cut: Cut::Tile, lights: 16, ..base };
    for precision in Precision::ALL {
        for lobes in Lobes::ALL {
            let name = format!("cut=tile precision={precision} lobes={lobes}");
            list.three(name, Settings { precision, lobes, ..base.clone() });
        }
    }
    for lights in [1, 1024] {
        list.one(format!("cut=tile lights={lights}"), Settings { lights, ..base.clone() });
    }
    for sharpness in [Sharpness::Toksvig, Sharpness::Banerjee] {
        let name = format!("cut=tile sharpness={sharpness}");
        list.one(name, Settings { sharpness, ..base.clone() });
    }
    let variance = Variance::Planar;
    list.one("cut=tile variance=planar", Settings { variance, ..base.clone() });
    for tolerance in [0.0, 0.1] {
        let name = format!("cut=tile tolerance={tolerance}");
        list.one(name, Settings { tolerance, ..base.clone() });
    }
    for emitter in Emitter::ALL {
        list.one(format!("cut=tile emitter={emitter}"), Settings { emitter, ..base.clone() });
    }
    for specular in Specular::ALL {
        let ndf = if specular == Specular::None { Ndf::None } else { Ndf::Ggx };
        let name = format!("cut=tile specular={specular}");
        list.one(name, Settings { specular, ndf, ..base.clone() });
    }
    let output = Output::Rgba16float;
    list.one("cut=tile output=rgba16float", Settings { output, ..base.clone() });
    for visibility in [Visibility::ShadowMap, Visibility::Imperfect] {
        let name = format!("cut=tile visibility={visibility}");
        list.one(name, Settings { visibility, lights: 64, ..base.clone() });
    }
}

/// Maps of the lights, which are cleared in each frame.
fn visibility(list: &mut List) {
    for visibility in [Visibility::ShadowMap, Visibility::Imperfect] {
        for precision in Precision::ALL {
            for lobes in Lobes::ALL {
                let name = format!("visibility={visibility} precision={precision} lobes={lobes}");
                let settings = Settings { visibility, precision, lobes, ..base() };
                list.three(name, settings);
            }
        }
        for count in [1, 7] {
            let name = format!("visibility={visibility} lights={count}");
            list.three(name, Settings { visibility, lights: count, ..base() });
        }
        let named = |what: &str| format!("visibility={visibility} {what}");
        list.one(named("tile=64"), Settings { visibility, tile: 64, ..base() });
        list.one(named("near_scale=0.5"), Settings { visibility, near_scale: 0.5, ..base() });
        list.one(named("bias_scale=2"), Settings { visibility, bias_scale: 2.0, ..base() });
        list.one(named("emitter=disc"), Settings { visibility, emitter: Emitter::Disc, ..base() });
        list.one(named("emitter=lobe"), Settings { visibility, emitter: Emitter::Lobe, ..base() });
        list.three(named("eye"), Settings { visibility, ..base() }).eye_moves = true;
    }
    let visibility = Visibility::Imperfect;
    let settings = Settings { visibility, shadow_points: 100, ..base() };
    list.one("visibility=imperfect shadow_points=100", settings);
}

/// Each kind of light with each kind of map.
fn lights(list: &mut List) {
    let (precision, density) = (Precision::F16, Density::Bidirectional);
    for lamp in [Lamp::Spot, Lamp::Directional, Lamp::Point, Lamp::Several] {
        for (what, settings) in [
            ("kernels", base()),
            ("f16", Settings { precision, ..base() }),
            ("bidirectional", Settings { density, ..base() }),
            ("clusters", Settings { space: Space::World, ..base() }),
            ("clusters bidirectional", Settings { space: Space::Image, density, ..base() }),
            ("cut", Settings { space: Space::Tree, ..base() }),
            ("visibility", Settings { visibility: Visibility::ShadowMap, ..base() }),
            ("matt", matt()),
            ("beckmann", Settings { ndf: Ndf::Beckmann, ..base() }),
        ] {
            let case = list.one(format!("light={} {what}", lamp.name()), settings);
            case.lamp = lamp;
            case.frames = if what == "kernels" { 3 } else { 1 };
        }
    }
}

/// Several lights in one map: what there is no more than one light of in the list above.
fn several(list: &mut List) {
    let visibility = Visibility::ShadowMap;
    let cut = Settings { space: Space::Tree, emitter: Emitter::Disc, ..base() };
    let tiled = Settings { cut: Cut::Tile, lights: 16, visibility, ..cut.clone() };
    for (what, settings) in [
        ("cut=tile", tiled),
        ("chains", Settings { draw: Draw::Metropolis, ..base() }),
        ("f16 bidirectional", {
            let (precision, density) = (Precision::F16, Density::Bidirectional);
            Settings { precision, density, ..base() }
        }),
        ("albedo", Settings { specular_power: SpecularPower::Albedo, ..base() }),
        ("cut albedo", Settings { specular_power: SpecularPower::Albedo, ..cut.clone() }),
        ("reflectance", Settings { density: Density::Reflectance, ..base() }),
        ("output=rgba16float", Settings { output: Output::Rgba16float, ..base() }),
        ("map=48", Settings { map: 48, ..base() }),
    ] {
        list.three(format!("light=several {what}"), settings).lamp = Lamp::Several;
    }
    for sharpness in [Sharpness::Toksvig, Sharpness::Banerjee] {
        let name = format!("light=several sharpness={sharpness}");
        list.one(name, Settings { sharpness, ..base() }).lamp = Lamp::Several;
    }
    let columns = list.one("light=several scene=columns", cut);
    (columns.lamp, columns.place) = (Lamp::Several, Place::Columns);
}

/// Numbers of maps of points.
fn points(list: &mut List) {
    let base = Settings { visibility: Visibility::Imperfect, ..base() };
    list.one("splat_reach=1", Settings { splat_reach: 1, ..base.clone() });
    list.one("fill_levels=2", Settings { fill_levels: 2, ..base });
}

/// A light that lights nothing: no density to draw by, lights without power.
fn darkness(list: &mut List) {
    let visibility = Visibility::ShadowMap;
    for (what, settings) in [
        ("kernels", base()),
        ("previous", Settings { kernel: Kernel::Previous, ..base() }),
        ("f16", Settings { precision: Precision::F16, ..base() }),
        ("bidirectional", Settings { density: Density::Bidirectional, ..base() }),
        ("chains", Settings { draw: Draw::Metropolis, ..base() }),
        ("image", Settings { space: Space::Image, ..base() }),
        ("world", Settings { space: Space::World, visibility, ..base() }),
        ("imperfect", Settings { visibility: Visibility::Imperfect, ..base() }),
        ("tree", Settings { space: Space::Tree, ..base() }),
    ] {
        list.one(format!("dark {what}"), settings).lamp = Lamp::Away;
    }
}

/// Maps and pictures of odd sizes, down to one texel. (A point light's map is a multiple of 4.) An eighth of 71 is rounded
/// up to 9, which is more than a workgroup makes of the third level of a chain.
fn sizes(list: &mut List) {
    for map in [1, 2, 4, 16, 32, 48, 63, 71] {
        list.one(format!("map={map}"), Settings { map, ..base() });
        let precision = Precision::F16;
        list.one(format!("map={map} precision=f16"), Settings { map, precision, ..base() });
    }
    for map in [1, 48, 63, 71] {
        let space = Space::World;
        list.three(format!("map={map} space=world"), Settings { map, space, ..base() });
    }
    let lights = Settings { map: 63, draw: Draw::Metropolis, ..base() };
    list.three("map=63 draw=metropolis", lights);
    let point = Settings { map: 48, ..base() };
    list.one("map=48 light=point", point.clone()).lamp = Lamp::Point;
    let clusters = Settings { space: Space::Image, ..point };
    list.one("map=48 light=point space=image", clusters).lamp = Lamp::Point;
    for count in [1, 7, 65, 1100] {
        list.one(format!("lights={count}"), Settings { lights: count, ..base() });
    }
    for size in [[1, 1], [9, 1], [17, 33], [64, 48], [71, 13]] {
        let [width, height] = size;
        let density = Density::Bidirectional;
        list.one(format!("picture={width}x{height}"), Settings { size, density, ..base() });
    }
    for camera_count in [1, 7] {
        let density = Density::Bidirectional;
        let name = format!("density=bidirectional camera_lights={camera_count}");
        list.one(name, Settings { density, camera_lights: camera_count, ..base() });
    }
}

/// What a scene has, and what is left out where it lacks something.
fn scenes(list: &mut List) {
    for place in Place::ALL {
        let name = format!("scene={}", place.name());
        list.one(name, base()).place = place;
    }
    for place in [Place::Cornell, Place::Walls] {
        list.one(format!("scene={} matt", place.name()), matt()).place = place;
    }
    for place in [Place::Glossy, Place::Lamps] {
        let settings = Settings { complete: true, ..base() };
        list.one(format!("scene={} complete", place.name()), settings).place = place;
    }
    for (what, settings) in [
        ("diffuse=none", Settings { diffuse: Diffuse::None, ..base() }),
        ("specular=none", Settings { specular: Specular::None, ndf: Ndf::None, ..base() }),
    ] {
        list.one(format!("scene=lamps {what}"), settings).place = Place::Lamps;
    }
    for visibility in [Visibility::ShadowMap, Visibility::Imperfect] {
        for place in [Place::Columns, Place::Atrium] {
            let name = format!("scene={} visibility={visibility}", place.name());
            list.three(name, Settings { visibility, ..base() }).place = place;
        }
    }
}

/// Configurations that have a name: those of a class of scenes, and presets, with fewer lights.
fn named(list: &mut List) {
    let today = Settings { size_factor: 0.25, ..base() };
    let glossy = Settings { specular_power: SpecularPower::Albedo, ..today.clone() };
    list.one("kernels of a scene without occluders", glossy).place = Place::GlossyWalls;
    list.one("kernels of a matt scene without occluders", today.clone()).place = Place::Walls;
    let shadowed = Settings { visibility: Visibility::ShadowMap, tile: 64, ..today.clone() };
    list.three("kernels of a scene with occluders", shadowed.clone());
    let disc = Settings { space: Space::World, emitter: Emitter::Disc, ..today };
    list.three("clusters of a scene without occluders", disc.clone()).place = Place::GlossyWalls;
    let disc = Settings { space: Space::World, emitter: Emitter::Disc, ..shadowed };
    list.three("clusters of a scene with occluders", disc.clone());
    list.three("clusters of a scene with occluders, eye", disc.clone()).eye_moves = true;
    let cut = Settings { space: Space::Tree, cut: Cut::Tile, lights: 256, ..disc };
    list.one("cut of a scene with occluders", cut.clone());
    list.one(
        "cut of a scene with occluders and specular surfaces",
        Settings { lights: 448, near_scale: 0.75, specular_power: SpecularPower::Albedo, ..cut },
    );
    // [Tokuyoshi 2016, Section 5, Appendices A to D]
    let printed = Settings {
        density: Density::Bidirectional,
        solver: Solver::Bisection,
        emitter: Emitter::Lobe,
        sharpness: Sharpness::Toksvig,
        diffuse: Diffuse::Constant,
        visibility: Visibility::Imperfect,
        shadow_points: 8192,
        tile: 64,
        ..base()
    };
    list.three("tokuyoshi2016", printed);
}
