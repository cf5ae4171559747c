//! Clusters: `shaders/src/cluster`, their sort, their tree and the lights that they sum to.

use sglow_oracle::cluster::{self, Map};
use sglow_oracle::fis::stress::{Random, Stress};
use sglow_oracle::fis::{lattice, warp};
use sglow_oracle::rsm::Emission;
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::vsgl::{Lobe, Vsgl};
use sglow_oracle::{Bounded, Real, Vector3};
use sglow_renderer::frame::Surfaces;
use sglow_renderer::reference;
use sglow_runtime::light::LightView;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::LightKind;
use sglow_shaders::{Draw, Light, Lobes, Precision, Sharpness, Space, SpecularPower, Variance};

use crate::common::{
    Comparison, DensityTexture, KINDS, Uploaded, broken, gpu, light, lights, random_surfaces,
    whole_space,
};
use crate::part::clusters::{ClusterInputs, ClusterSettings, Clusters, sorted};

/// A map, its density, and what is made of it.
#[derive(Clone)]
struct Case {
    name: &'static str,
    settings: ClusterSettings,
    kind: LightKind,
    surfaces: Surfaces,
    stress: Stress,
}

fn case(name: &'static str, size: [u32; 2], count: u32, space: Space) -> Case {
    let settings = ClusterSettings {
        size,
        count,
        draw: Draw::Warped,
        space,
        light: Light::Spot,
        grid: [1, 1],
        variance: Variance::Trace,
        sharpness: Sharpness::Exact,
        lobes: Lobes::Both,
        specular_power: SpecularPower::F0,
        diffuse_mean_length: 1.0,
    };
    let surfaces = random_surfaces(size, 11);
    Case { name, settings, kind: KINDS[0], surfaces, stress: Stress::Smooth }
}

/// What the device made of a case.
struct Run {
    case: Case,
    light: LightView,
    density: DensityTexture,
    centres: Vec<[f32; 4]>,
    assignment: Vec<u32>,
    order: Vec<u32>,
    starts: Vec<u32>,
    lights: Vec<Vsgl>,
}

impl Run {
    fn new(case: &Case, package: &Package) -> Self {
        let ClusterSettings { size, lobes, .. } = case.settings;
        let mut clusters = Clusters::new(package, &case.settings).unwrap();
        let density = DensityTexture::new(size, case.stress, 5);
        let map = Uploaded::new(&case.surfaces, size);
        let several = case.settings.light == Light::Several;
        let light = if several { lights(size[0]) } else { light(case.kind, size[0]) };
        let inputs =
            ClusterInputs { map: map.views(), light: &light, density: &density.view, chains: None };
        clusters.run(&inputs).unwrap();
        Self {
            case: case.clone(),
            light,
            density,
            centres: clusters.centres(),
            assignment: clusters.assignment(),
            order: clusters.order(),
            starts: clusters.starts(),
            lights: reference::lights_of(gpu(), clusters.vsgls(), lobes, Precision::F32).unwrap(),
        }
    }

    /// The centres against the warped lattice; those of the world are texels and so exact.
    fn compare_centres(&self) -> Comparison {
        let ClusterSettings { size, count, space, .. } = self.case.settings;
        let mut comparison = Comparison::default();
        for (index, measured) in self.centres.iter().enumerate() {
            let point = lattice::point::<Bounded>(index as u32, count);
            let warped = warp(&self.density.pyramid, point);
            if !warped.certain {
                continue;
            }
            let expected = match space {
                Space::None | Space::Image | Space::Tree => {
                    let side = Bounded::constant(self.density.pyramid.size() as f64);
                    let [x, y] = warped.centre.map(|part| part * side);
                    [x, y, Bounded::exact(0.0), Bounded::exact(0.0)]
                }
                Space::World => {
                    // Without any density a point may lie beyond the map: the nearest texel stands for it.
                    let [x, y] = [0, 1].map(|axis| warped.texel[axis].min(size[axis] as usize - 1));
                    let texel = self.case.surfaces.position[y * size[0] as usize + x];
                    [texel[0], texel[1], texel[2], 0.0].map(Bounded::exact)
                }
            };
            comparison.texel(&format!("centre {index}"), *measured, expected);
        }
        comparison
    }

    /// How many texels are in another cluster than that of a closest centre, and of how many rounding decides.
    fn compare_assignment(&self) -> (usize, usize) {
        let centres: Vec<Vector3> = self
            .centres
            .iter()
            .map(|&[x, y, z, _]| Vector3::new(f64::from(x), f64::from(y), f64::from(z)))
            .collect();
        let width = self.case.settings.size[0] as usize;
        let (mut wrong, mut doubtful) = (0, 0);
        for (index, &cluster) in self.assignment.iter().enumerate() {
            let point = match self.case.settings.space {
                Space::None | Space::Image | Space::Tree => {
                    Vector3::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5, 0.0)
                }
                Space::World => Vector3::of_texel(self.case.surfaces.position[index]),
            };
            let closest = cluster::closest(&centres, point).unwrap();
            doubtful += usize::from(!closest.certain());
            wrong += usize::from(!closest.candidates.contains(&(cluster as usize)));
        }
        (wrong, doubtful)
    }

    /// The sorted texels and the starts of clusters, which are exact.
    fn sort_is_right(&self) -> bool {
        let order: Vec<u32> =
            cluster::order(&self.assignment).into_iter().map(|index| index as u32).collect();
        let starts: Vec<u32> = cluster::starts(&self.assignment, self.case.settings.count as usize)
            .into_iter()
            .map(|start| start as u32)
            .collect();
        order == self.order && starts == self.starts
    }

    fn emission(&self) -> Emission {
        let ClusterSettings { variance, sharpness, lobes, diffuse_mean_length, .. } =
            self.case.settings;
        let settings = Settings { variance, sharpness, lobes, ..Settings::default() };
        let diffuse_mean_length = f64::from(diffuse_mean_length);
        Emission { diffuse_mean_length, ..reference::emission(&settings) }
    }

    /// The lights against sums of the texels that the device assigned, one by one and all together.
    fn compare_lights(&self) -> Comparison {
        let ClusterSettings { size, count, specular_power, .. } = self.case.settings;
        let texels: Vec<SurfaceTexel<Bounded>> = reference::texels(&self.case.surfaces);
        let lights = reference::MapLights::of(&self.light);
        let map = Map {
            texels: &texels,
            size: size.map(|side| side as usize),
            light: lights.of_map(),
            origin: reference::vector(self.light.origin),
            minimum_variance: f64::from(self.light.minimum_variance),
            emission: self.emission(),
            specular_power: reference::specular_power(specular_power),
        };
        let expected = cluster::lights(&map, &self.assignment, count as usize);
        let mut comparison = Comparison::default();
        let single = |vector: Vector3| vector.to_array().map(|part| part as f32);
        for (index, (measured, expected)) in self.lights.iter().zip(&expected).enumerate() {
            let position = format!("position of light {index}");
            comparison.vector(&position, single(measured.position), expected.position);
            let variance = || format!("variance of light {index}");
            comparison.number(variance, measured.variance as f32, expected.variance);
            let lobes = |light: &Vsgl| -> Vec<Lobe> {
                std::iter::once(light.diffuse).chain(light.specular).collect()
            };
            let expected = std::iter::once(expected.diffuse).chain(expected.specular);
            for (lobe, (measured, expected)) in
                lobes(measured).into_iter().zip(expected).enumerate()
            {
                let name = |what: &str| format!("{what} of lobe {lobe} of light {index}");
                comparison.vector(&name("axis"), single(measured.axis), expected.axis);
                let sharpness = measured.sharpness as f32;
                comparison.number(|| name("sharpness"), sharpness, expected.sharpness);
                let coefficient = single(measured.coefficient);
                comparison.vector(&name("coefficient"), coefficient, expected.coefficient);
            }
        }
        // Whatever the clusters are, their power is that of the map.
        let one = vec![0; self.assignment.len()];
        let whole = cluster::lights(&map, &one, 1)[0].power();
        let measured = self.lights.iter().fold(Vector3::zero(), |sum, light| sum + light.power());
        comparison.vector("power of all lights", single(measured), whole);
        comparison
    }
}

/// Maps of all shapes, few and many clusters, centres that are spread, clustered or all the same.
fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for space in [Space::Image, Space::World] {
        cases.extend([
            case("a square", [32, 32], 100, space),
            case("another shape", [50, 23], 64, space),
            case("one cluster", [20, 16], 1, space),
            case("two clusters", [20, 16], 2, space),
            case("three clusters", [9, 40], 3, space),
            case("more clusters than texels", [9, 7], 300, space),
            // More than one block of codes to sort.
            case("many clusters", [61, 64], 3000, space),
            Case { stress: Stress::Ring, ..case("a ring", [64, 64], 150, space) },
            // In the world all centres are then the same point.
            Case { stress: Stress::HotTexel, ..case("a hot texel", [32, 32], 90, space) },
            Case { stress: Stress::Zero, ..case("no density", [24, 32], 70, space) },
            Case { stress: Stress::Noise { sigma: 3.0 }, ..case("noise", [61, 64], 200, space) },
        ]);
        let mut one_place = case("one place", [30, 30], 77, space);
        for position in &mut one_place.surfaces.position {
            position[..3].copy_from_slice(&[0.25, 0.5, -0.75]);
        }
        cases.push(one_place);
        let mut two_places = case("two places", [30, 30], 77, space);
        for (index, position) in two_places.surfaces.position.iter_mut().enumerate() {
            position[..3].copy_from_slice(&[if index % 3 == 0 { 0.25 } else { -1e-3 }, 0.5, -0.75]);
        }
        cases.push(two_places);
    }
    cases
}

#[test]
fn agree_with_the_oracle() {
    for case in cases() {
        let run = Run::new(&case, whole_space());
        let what = format!("{}, {}", case.name, case.settings.space);
        run.compare_centres().assert_holds(&format!("centres, {what}"));
        let (wrong, doubtful) = run.compare_assignment();
        let texels = run.assignment.len();
        println!("{what}: {doubtful} of {texels} texels are as close to two centres");
        assert_eq!(wrong, 0, "{what}: of {texels} texels");
        // All of them where centres are all but one point: then none is nearer than rounding tells.
        let degenerate = case.stress == Stress::HotTexel;
        assert!(degenerate || doubtful * 20 <= texels, "{what}: {doubtful} of {texels}");
        assert!(run.sort_is_right(), "{what}");
        run.compare_lights().assert_holds(&format!("lights, {what}"));
    }
}

#[test]
fn all_lights_and_lobes_agree_with_the_oracle() {
    for (kind, light) in KINDS.into_iter().zip([Light::Spot, Light::Directional, Light::Point]) {
        for lobes in [Lobes::Diffuse, Lobes::Both] {
            let mut case = case("lights", [40, 24], 60, Space::Image);
            (case.kind, case.settings.light, case.settings.lobes) = (kind, light, lobes);
            let run = Run::new(&case, whole_space());
            run.compare_lights().assert_holds(&format!("lights of {light}, {lobes}"));
        }
        let mut case = case("lights", [40, 24], 60, Space::Image);
        (case.kind, case.settings.light) = (kind, light);
        case.settings.specular_power = SpecularPower::Albedo;
        let mut run = Run::new(&case, whole_space());
        run.compare_lights().assert_holds(&format!("lights of {light} by albedo"));
        // Negative control: they are other lights.
        run.case.settings.specular_power = SpecularPower::F0;
        run.compare_lights().assert_fails("another specular power");
    }
}

/// The texels of several lights' maps, those of one light and those of another in one cluster.
#[test]
fn several_lights_agree_with_the_oracle() {
    for space in [Space::Image, Space::World] {
        let mut case = case("several lights", [40, 24], 60, space);
        (case.settings.light, case.settings.grid) = (Light::Several, [4, 2]);
        let run = Run::new(&case, whole_space());
        run.compare_lights().assert_holds(&format!("clusters of several lights, {space}"));
        let id = "cluster_sum-several-trace-exact-both-f0";
        for (from, to, what) in [
            ("face_lights[at.face]", "face_lights[0]", "the first light alone"),
            ("light.half_extent > 0.0", "light.half_extent > 1e9", "a directional light as a spot"),
        ] {
            Run::new(&case, &broken(id, from, to)).compare_lights().assert_fails(what);
        }
    }
}

/// Equal centres share one place: all texels go to the first cluster, and the others are empty, dark and finite.
#[test]
fn equal_centres_leave_all_clusters_but_the_first_one_empty() {
    let mut one_place = case("one place", [30, 30], 77, Space::World);
    for position in &mut one_place.surfaces.position {
        position[..3].copy_from_slice(&[0.25, 0.5, -0.75]);
    }
    let run = Run::new(&one_place, whole_space());
    assert!(run.assignment.iter().all(|&cluster| cluster == 0));
    for light in &run.lights[1..] {
        assert_eq!(light.power(), Vector3::zero());
        assert!(light.variance > 0.0 && light.position.length().is_finite());
    }
    let package =
        broken("cluster_assign-world", "leaf.cluster < cluster", "leaf.cluster > cluster");
    let run = Run::new(&one_place, &package);
    assert!(run.assignment.iter().any(|&cluster| cluster != 0));
    assert!(run.compare_assignment().0 > 0, "the last of equal centres goes unnoticed");
}

#[test]
fn broken_centres_are_noticed() {
    let breaks = [
        (Space::Image, "2654435769u", "2654435761u"),
        (Space::World, "drawn.texel", "drawn.texel + 1u"),
    ];
    for (space, from, to) in breaks {
        let package = broken(&format!("centres-warped-{space}"), from, to);
        let run = Run::new(&case("broken", [32, 32], 100, space), &package);
        run.compare_centres().assert_fails(to);
    }
}

#[test]
fn a_broken_search_is_noticed() {
    let breaks = [
        (
            "cluster_assign-",
            "waiting_distance[height] <= closest",
            "4.0 * waiting_distance[height] <= closest",
        ),
        (
            "cluster_assign-",
            "max(box.low - point, point - box.high)",
            "max(point - box.low, point - box.high)",
        ),
        ("cluster_assign-", "right < left;", "right > left;"),
        ("cluster_boxes", "carried &= ~bit", "carried = 0u"),
        ("cluster_boxes", "sglow_box_part(centre, part)", "sglow_box_part(0.9 * centre, part)"),
        ("cluster_tree", "min(way, 0)", "0"),
        ("cluster_tree", "(stride + 1) / 2", "stride / 2"),
    ];
    for (pass, from, to) in breaks {
        for space in [Space::Image, Space::World] {
            let id = if pass.ends_with('-') { format!("{pass}{space}") } else { pass.to_owned() };
            let run = Run::new(&case("broken", [64, 64], 300, space), &broken(&id, from, to));
            let (wrong, _) = run.compare_assignment();
            println!("{id}: {from} as {to}: {wrong} texels");
            assert!(wrong > 0, "{id}: {from} as {to} goes unnoticed");
        }
    }
}

#[test]
fn broken_clusters_are_noticed() {
    let breaks = [
        ("cluster_starts", "< id.x", "<= id.x"),
        ("sort_scatter", "4u * lane", "4u * (255u - lane)"),
    ];
    for (id, from, to) in breaks {
        let run = Run::new(&case("broken", [50, 23], 64, Space::Image), &broken(id, from, to));
        assert!(!run.sort_is_right(), "{id}: {from} as {to} goes unnoticed");
    }
}

#[test]
fn a_broken_sum_is_noticed() {
    let id = "cluster_sum-spot-trace-exact-both-f0";
    let breaks = [
        ("index < sglow_starts[id.x + 1u]", "index + 1u < sglow_starts[id.x + 1u]"),
        ("total.weight += moments.weight", "total.weight += 1.001 * moments.weight"),
        ("order / size.x", "order / size.y"),
        (
            "moments.specular_weight * moments.specular_mean_direction",
            "moments.specular_mean_direction",
        ),
        ("total, 1.0,", "total, 1.001,"),
        ("- dot(mean, mean)", "- 0.99 * dot(mean, mean)"),
    ];
    for (from, to) in breaks {
        let run = Run::new(&case("broken", [50, 23], 64, Space::World), &broken(id, from, to));
        run.compare_lights().assert_fails(to);
    }
}

fn sorts(keys: &[u32], bits: u32, package: &Package) -> bool {
    let order = cluster::order(keys);
    let expected_keys: Vec<u32> = order.iter().map(|&index| keys[index]).collect();
    let expected_values: Vec<u32> = order.iter().map(|&index| index as u32).collect();
    sorted(keys, bits, package) == (expected_keys, expected_values)
}

#[test]
fn the_sort_is_stable_and_right() {
    for length in [1, 2, 1000, 1024, 1025, 70001] {
        for bits in [1, 4, 10, 17, 32] {
            let mut random = Random::new(u64::from(bits));
            let keys: Vec<u32> = (0..length).map(|_| random.bits() >> (32 - bits)).collect();
            assert!(sorts(&keys, bits, whole_space()), "{length} random keys of {bits} bits");
            let mut ascending = keys.clone();
            ascending.sort_unstable();
            assert!(sorts(&ascending, bits, whole_space()), "{length} sorted keys of {bits} bits");
            ascending.reverse();
            assert!(sorts(&ascending, bits, whole_space()), "{length} keys from the last one");
            let equal = vec![keys[0]; length as usize];
            assert!(sorts(&equal, bits, whole_space()), "{length} equal keys of {bits} bits");
        }
    }
    assert!(sorts(&[0; 5], 0, whole_space()), "no bits");
}

#[test]
fn a_broken_sort_is_noticed() {
    let mut random = Random::new(1);
    let keys: Vec<u32> = (0..70001).map(|_| random.bits() >> 15).collect();
    let breaks = [
        ("sort_count", "digits >> (8u * part)", "digits >> (7u * part)"),
        ("sort_scan", "reach < 256u", "reach < 128u"),
        ("sort_scan", "start += count;", ""),
        ("sort_scatter", "= sum;\n            sum += count;", "= sum;\n            sum = count;"),
        ("sort_scatter", "other < lane;", "other < lane - 1u;"),
        ("sort_scatter", "+= 1u << half;", "+= 0u << half;"),
        ("sort_scatter", "4u * lane", "4u * (255u - lane)"),
    ];
    for (id, from, to) in breaks {
        assert!(!sorts(&keys, 17, &broken(id, from, to)), "{id}: {from} as {to} goes unnoticed");
    }
}

#[test]
fn settings_that_cannot_be_are_named() {
    let error = |change: &dyn Fn(&mut ClusterSettings)| {
        let mut settings = case("settings", [8, 8], 4, Space::Image).settings;
        change(&mut settings);
        Clusters::new(whole_space(), &settings).err().map(|error| error.to_string())
    };
    assert_eq!(error(&|_| {}), None);
    let text = error(&|settings| settings.count = 0).unwrap();
    assert!(text.contains("`lights` is 0; expected a whole number, at least 1"), "{text}");
    assert!(error(&|settings| settings.count = 65537).unwrap().contains("65537"));
    // Chains that are not there.
    let mut settings = case("settings", [8, 8], 4, Space::Image).settings;
    settings.draw = Draw::Metropolis;
    let mut clusters = Clusters::new(whole_space(), &settings).unwrap();
    let map = Uploaded::new(&random_surfaces([8, 8], 1), [8, 8]);
    let density = DensityTexture::new([8, 8], Stress::Smooth, 1);
    let light = light(KINDS[0], 8);
    let inputs =
        ClusterInputs { map: map.views(), light: &light, density: &density.view, chains: None };
    let error = clusters.run(&inputs).unwrap_err().to_string();
    assert!(error.contains("`given_chains` is left out"), "{error}");
}
