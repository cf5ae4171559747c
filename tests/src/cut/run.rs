//! One run of a cut on the device, and what of it is compared with the oracle.

use sglow_oracle::cluster::{self, Map};
use sglow_oracle::cut::global::{DIRECTIONS, cost, effective, ranges, rank_key};
use sglow_oracle::cut::key::{Grid, Key, UNLIT, places};
use sglow_oracle::cut::sum::LEAST_VARIANCE;
use sglow_oracle::cut::{CentralMoments, Sums, Tree};
use sglow_oracle::rsm::Emission;
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::vsgl::{Lobe, Vsgl};
use sglow_oracle::{Bounded, Real, Vector3};
use sglow_renderer::frame::Surfaces;
use sglow_renderer::reference;
use sglow_runtime::light::LightView;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Light, Lobes, Precision, Sharpness, SpecularPower, Variance};

use crate::common::{Comparison, KINDS, Uploaded, gpu, light, random_surfaces};
use crate::part::cut::{Cut, CutSettings};

/// A map and what is made of it.
#[derive(Clone)]
pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) settings: CutSettings,
    pub(super) light: LightView,
    pub(super) surfaces: Surfaces,
}

pub(super) fn case(name: &'static str, size: [u32; 2], count: u32) -> Case {
    let settings = CutSettings {
        size,
        count,
        light: Light::Spot,
        grid: [1, 1],
        variance: Variance::Trace,
        sharpness: Sharpness::Exact,
        lobes: Lobes::Both,
        specular_power: SpecularPower::F0,
        precision: Precision::F32,
        diffuse_mean_length: 1.0,
    };
    let surfaces = random_surfaces(size, 11);
    Case { name, settings, light: light(KINDS[0], size[0]), surfaces }
}

/// What the device made of a case.
pub(super) struct Run {
    pub(super) case: Case,
    pub(super) leaves_box: Vec<u32>,
    pub(super) leaf_count: usize,
    pub(super) keys: Vec<u32>,
    pub(super) sorted: (Vec<u32>, Vec<u32>),
    pub(super) blocks: Vec<f32>,
    pub(super) nodes: Vec<[u32; 4]>,
    pub(super) costs: Vec<f32>,
    pub(super) ranks: (Vec<u32>, Vec<u32>),
    pub(super) lights: Vec<Vsgl>,
    pub(super) texels: Vec<SurfaceTexel<Bounded>>,
}

/// What of a run is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Box,
    Keys,
    Sort,
    Blocks,
    Tree,
    Costs,
    Ranks,
    Lights,
}

pub(super) const PARTS: [Part; 8] = [
    Part::Box,
    Part::Keys,
    Part::Sort,
    Part::Blocks,
    Part::Tree,
    Part::Costs,
    Part::Ranks,
    Part::Lights,
];

impl Run {
    pub(super) fn new(case: &Case, package: &Package) -> Self {
        let CutSettings { size, lobes, precision, .. } = case.settings;
        let mut cut = Cut::new(package, &case.settings).unwrap();
        let map = Uploaded::new(&case.surfaces, size);
        cut.run(map.views(), &case.light).unwrap();
        Self {
            case: case.clone(),
            leaves_box: cut.leaves_box(),
            leaf_count: cut.leaf_count(),
            keys: cut.keys(),
            sorted: cut.sorted(),
            blocks: cut.blocks(),
            nodes: cut.nodes(),
            costs: cut.costs(),
            ranks: cut.ranks(),
            lights: reference::lights_of(gpu(), cut.vsgls(), lobes, precision).unwrap(),
            texels: reference::texels(&case.surfaces),
        }
    }

    pub(super) fn with_map<T>(&self, of: impl FnOnce(&Map<'_, Bounded>) -> T) -> T {
        let CutSettings { size, specular_power, .. } = self.case.settings;
        let view = &self.case.light;
        of(&Map {
            texels: &self.texels,
            size: size.map(|side| side as usize),
            light: reference::MapLights::of(view).of_map(),
            origin: reference::vector(view.origin),
            minimum_variance: LEAST_VARIANCE,
            emission: self.emission(),
            specular_power: reference::specular_power(specular_power),
        })
    }

    pub(super) fn emission(&self) -> Emission {
        let CutSettings { variance, sharpness, lobes, diffuse_mean_length, .. } =
            self.case.settings;
        let settings = Settings { variance, sharpness, lobes, ..Settings::default() };
        let diffuse_mean_length = f64::from(diffuse_mean_length);
        Emission { diffuse_mean_length, ..reference::emission(&settings) }
    }

    /// The moments of each place's texel; none where there is no leaf.
    pub(super) fn places(&self) -> Vec<Option<(usize, CentralMoments<Bounded>)>> {
        self.with_map(|map| {
            let of = |texel: usize| {
                let at = [texel % map.size[0], texel / map.size[0]];
                let moments = CentralMoments::of_texel(map, at);
                moments.lit().then_some((texel, moments))
            };
            places(map.size).into_iter().map(|place| of(place?)).collect()
        })
    }

    /// The sums of the leaves in the device's order.
    pub(super) fn sums(&self) -> Sums<Bounded> {
        let of_place = self.places();
        let leaf = |at: usize| match of_place[self.sorted.1[at] as usize] {
            Some((_, moments)) if at < self.leaf_count => moments,
            _ => CentralMoments::nothing(),
        };
        Sums::of_leaves(&(0..self.keys.len()).map(leaf).collect::<Vec<_>>())
    }

    pub(super) fn grid(&self) -> Grid {
        let number =
            |word: u32| f32::from_bits(if word >> 31 == 1 { word & 0x7fff_ffff } else { !word });
        let low = [0, 1, 2].map(|axis| number(!self.leaves_box[axis]));
        let high = [3, 4, 5].map(|axis| number(self.leaves_box[axis]));
        Grid::around(low, high)
    }

    pub(super) fn compare_box(&self) -> Comparison {
        let mut comparison = Comparison::default();
        let lit: Vec<[Bounded; 3]> =
            self.places().iter().flatten().map(|(_, of)| of.mean.to_array()).collect();
        let number =
            |word: u32| f32::from_bits(if word >> 31 == 1 { word & 0x7fff_ffff } else { !word });
        for axis in 0..3 {
            let at = lit.iter().map(|mean| mean[axis]);
            let (low, high) = (at.clone().reduce(Real::min), at.reduce(Real::max));
            let (Some(low), Some(high)) = (low, high) else { continue };
            let words = [!self.leaves_box[axis], self.leaves_box[3 + axis]];
            for (word, expected) in words.into_iter().zip([low, high]) {
                comparison.number(|| format!("box along {axis}"), number(word), expected);
            }
        }
        comparison
    }

    /// How many keys are others than the oracle's, of how many rounding decides, and how many leaves there are.
    pub(super) fn compare_keys(&self) -> (usize, usize, usize) {
        let grid = self.grid();
        let (mut wrong, mut doubtful, mut leaves) = (0, 0, 0);
        for (key, place) in self.keys.iter().zip(self.places()) {
            let Some((texel, moments)) = place else {
                wrong += usize::from(*key != UNLIT);
                continue;
            };
            leaves += 1;
            let [x, y, z, _] = self.case.surfaces.normal[texel];
            let normal = Vector3::new(f64::from(x), f64::from(y), f64::from(z));
            // A difference that f32 holds is not rounded, whichever way it would be.
            let mean = moments.mean.map(|part| {
                let value = part.value();
                if f64::from(value as f32) == value {
                    Bounded::with_error(value, 0.0)
                } else {
                    part
                }
            });
            let expected = Key::of(mean, normal, &grid);
            doubtful += usize::from(!expected.certain);
            wrong += usize::from(expected.certain && expected.key != *key || *key == UNLIT);
        }
        wrong += usize::from(leaves != self.leaf_count);
        (wrong, doubtful, leaves)
    }

    pub(super) fn sort_is_right(&self) -> bool {
        let order = cluster::order(&self.keys);
        let keys: Vec<u32> = order.iter().map(|&place| self.keys[place]).collect();
        let places: Vec<u32> = order.iter().map(|&place| place as u32).collect();
        let ranked: Vec<u32> =
            cluster::order(&self.ranks.0).into_iter().map(|node| node as u32).collect();
        self.sorted == (keys, places) && self.ranks.1 == ranked
    }

    pub(super) fn compare_blocks(&self) -> Comparison {
        let words = if self.case.settings.lobes == Lobes::Both { 24 } else { 16 };
        let mut comparison = Comparison::default();
        let (sums, grid) = (self.sums(), self.grid());
        for (index, (block, found)) in
            sums.blocks().iter().zip(self.blocks.chunks(words)).enumerate().skip(1)
        {
            let three = |at: usize| [found[at], found[at + 1], found[at + 2]];
            let name = |what: &str| format!("{what} of block {index}");
            comparison.vector(&name("mean"), three(0), block.mean);
            comparison.number(|| name("weight"), found[3], block.weight);
            comparison.vector(&name("diffuse power"), three(4), block.diffuse_power);
            comparison.number(|| name("variance"), found[7], block.variance);
            comparison.vector(&name("diffuse direction"), three(8), block.diffuse_direction);
            comparison.number(|| name("diffuse weight"), found[11], block.diffuse_weight);
            if words == 24 {
                comparison.vector(&name("specular power"), three(12), block.specular_power);
                comparison.number(|| name("specular length"), found[15], block.specular_length);
                comparison.vector(&name("specular direction"), three(16), block.specular_direction);
            }
            if block.weight.value() > 0.0 {
                let cells = [0, 1, 2].map(|axis| found[words - 4 + axis].to_bits());
                for (corner, bits) in [(0, 0), (1, 16)] {
                    let middle = grid.middle(cells.map(|word| (word >> bits) & 0xffff));
                    // A corner is anywhere in its cell; here the middle of the cell is an f32.
                    let expected = block.bounds[corner].map(|part| {
                        let error = 0.5 * grid.finest() + part.error();
                        let rounding = f64::from(f32::EPSILON) * part.value().abs();
                        Bounded::with_error(part.value(), error + rounding)
                    });
                    let middle = middle.to_array().map(|part| part as f32);
                    comparison.vector(&name("corner of the box"), middle, expected);
                }
            }
        }
        comparison
    }

    pub(super) fn tree(&self) -> Tree {
        Tree::of_keys(&self.sorted.0[..self.leaf_count])
    }

    pub(super) fn tree_is_right(&self) -> bool {
        let tree = self.tree();
        tree.nodes.iter().zip(&self.nodes).enumerate().all(|(at, (node, found))| {
            let expected = [node.leaves.start, node.leaves.end - 1, node.parent.unwrap_or(at)];
            *found == [expected[0] as u32, expected[1] as u32, expected[2] as u32, node.prefix]
        })
    }

    pub(super) fn compare_costs(&self) -> Comparison {
        let (tree, sums) = (self.tree(), self.sums());
        let mut comparison = Comparison::default();
        for (at, node) in tree.nodes.iter().enumerate() {
            let expected = cost(&sums.of(node.leaves.clone()), &sums.all(), DIRECTIONS);
            comparison.number(|| format!("cost of node {at}"), self.costs[at], expected);
        }
        comparison
    }

    pub(super) fn ranks_are_right(&self) -> bool {
        let tree = self.tree();
        let effective = effective(&tree, &self.costs);
        let of = |at: usize| match tree.nodes.get(at) {
            Some(node) => rank_key(effective[at], node.prefix),
            None => u32::MAX,
        };
        (0..self.keys.len()).all(|at| self.ranks.0[at] == of(at))
    }

    /// The lights against the nodes of the cut of the device's costs, one by one and all together.
    pub(super) fn compare_lights(&self) -> Comparison {
        let count = self.case.settings.count as usize;
        let (tree, sums) = (self.tree(), self.sums());
        let nodes = if self.leaf_count == 0 {
            Vec::new()
        } else {
            ranges(&tree, &effective(&tree, &self.costs), count)
        };
        let mut comparison = Comparison::default();
        let origin = reference::vector(self.case.light.origin);
        let mut expected =
            vec![CentralMoments::<Bounded>::nothing().light(origin, &self.emission()); count];
        for leaves in &nodes {
            // A light is behind the gap of the node whose rank it has.
            let rank = leaves
                .start
                .checked_sub(1)
                .map(|gap| 1 + self.ranks.1.iter().position(|&node| node as usize == gap).unwrap());
            let light = sums.of(leaves.clone()).light(origin, &self.emission());
            match expected.get_mut(rank.unwrap_or(0)) {
                Some(place) => *place = light,
                None => comparison.number(|| "rank".to_owned(), f32::NAN, Bounded::exact(0.0)),
            }
        }
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
        comparison
    }

    /// The power of all lights and that of the map's texels, one by one; the largest relative difference.
    pub(super) fn lost_power(&self) -> f64 {
        let whole = self.places().iter().flatten().fold(Vector3::zero(), |sum, (_, of)| {
            sum + of.diffuse_power.value() + of.specular_power.value()
        });
        let power = self.lights.iter().fold(Vector3::zero(), |sum, light| sum + light.power());
        let [found, whole] = [power, whole].map(Vector3::to_array);
        (0..3).map(|at| ((found[at] - whole[at]) / whole[at].max(1e-300)).abs()).fold(0.0, f64::max)
    }

    pub(super) fn holds(&self, part: Part) -> bool {
        match part {
            Part::Box => self.compare_box().violations() == 0,
            Part::Keys => self.compare_keys().0 == 0,
            Part::Sort => self.sort_is_right(),
            Part::Blocks => self.compare_blocks().violations() == 0,
            Part::Tree => self.tree_is_right(),
            Part::Costs => self.compare_costs().violations() == 0,
            Part::Ranks => self.ranks_are_right(),
            Part::Lights => self.compare_lights().violations() == 0,
        }
    }

    #[track_caller]
    pub(super) fn assert_holds(&self) {
        let what = self.case.name;
        if self.leaf_count > 0 {
            self.compare_box().assert_holds(&format!("box, {what}"));
            self.compare_blocks().assert_holds(&format!("blocks, {what}"));
            self.compare_lights().assert_holds(&format!("lights, {what}"));
        }
        if self.leaf_count > 1 {
            self.compare_costs().assert_holds(&format!("costs, {what}"));
        }
        let (wrong, doubtful, leaves) = self.compare_keys();
        println!("{what}: {doubtful} of {leaves} leaves are at the border of a cell");
        assert_eq!(wrong, 0, "keys, {what}");
        // Where all leaves are in one place, cells are as narrow as what f32 tells apart.
        let narrow = self.grid().exponent < -12;
        assert!(narrow || doubtful * 10 <= leaves.max(10), "{what}: {doubtful} of {leaves}");
        assert!(self.sort_is_right(), "sort, {what}");
        assert!(self.tree_is_right(), "tree, {what}");
        assert!(self.ranks_are_right(), "ranks, {what}");
        let lost = self.lost_power();
        println!("{what}: power is off by {lost:e}");
        assert!(
            lost < 1e-6 || self.case.settings.sharpness != Sharpness::Exact,
            "{what}: {lost:e}"
        );
        for light in &self.lights {
            assert!(
                light.variance > 0.0 && light.position.length().is_finite(),
                "{what}: {light:?}"
            );
        }
    }
}
