//! The comparison of a receiver with a light's map.

use crate::visibility::map::{self, Maps, View};
use crate::vsgl::Vsgl;
use crate::{Real, Vector3};

/// Whether a light is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// It is.
    Yes,
    /// It is not.
    No,
    /// Rounding decides.
    Uncertain,
}

impl Seen {
    /// What two possible comparisons say together.
    fn or(self, other: Self) -> Self {
        if self == other { self } else { Self::Uncertain }
    }

    /// Whether a number is above 0.
    fn above<R: Real>(number: R) -> Self {
        if number.sign_is_certain() || number.error() == 0.0 {
            if number.value() > 0.0 { Self::Yes } else { Self::No }
        } else {
            Self::Uncertain
        }
    }
}

/// Whether light number `light` reaches a receiver with a unit normal on the side that is lit, by the atlas of all
/// lights, row by row. Behind the light's plane nothing is lit.
// [Ritschel 2008, Section 3.4]
pub fn visible<R: Real>(
    light: usize,
    vsgl: &Vsgl<R>,
    position: Vector3<R>,
    normal: Vector3<R>,
    maps: &Maps,
    atlas: &[f32],
) -> Seen {
    let view = View::of_light(vsgl, maps);
    if !view.basis.certain {
        return Seen::Uncertain;
    }
    let offset = view.offset(position);
    let lift = R::constant(maps.bias) * map::distance(offset);
    let lifted = offset + view.basis.coordinates(normal) * lift;
    let before = Seen::above(lifted.z);
    if before != Seen::Yes {
        return before;
    }
    let distance = map::distance(lifted);
    let [columns, rows] = map::place(lifted, maps.tile).map(|side| map::texels(side, maps.tile));
    let corner = [light % maps.columns * maps.tile, light / maps.columns * maps.tile];
    let width = maps.columns * maps.tile;
    let mut seen = None;
    for row in rows[0]..=rows[1] {
        for column in columns[0]..=columns[1] {
            let stored = atlas[(corner[1] + row) * width + corner[0] + column];
            // What is as far as the receiver does not hide the light.
            let hidden = Seen::above(R::constant(f64::from(stored)) * distance - view.near);
            let one = match hidden {
                Seen::Yes => Seen::No,
                Seen::No => Seen::Yes,
                Seen::Uncertain => Seen::Uncertain,
            };
            seen = Some(seen.map_or(one, |seen: Seen| seen.or(one)));
        }
    }
    seen.unwrap_or(Seen::Uncertain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;
    use crate::fis::stress::Random;
    use crate::vsgl::Lobe;

    fn light(axis: Vector3) -> Vsgl {
        let diffuse = Lobe { axis, sharpness: 2.0, coefficient: Vector3::splat(1.0) };
        Vsgl {
            position: Vector3::new(0.2, 0.1, -0.3),
            variance: 1e-4,
            diffuse,
            diffuse_mean_length: 0.5,
            specular: None,
        }
    }

    fn maps(tile: usize, bias: f64) -> Maps {
        Maps { tile, columns: 1, near_scale: 1.0, least_near: 1e-3, bias }
    }

    /// The exact map of a plane of a normal, in the light's basis and towards it, at a height below it.
    #[expect(clippy::cast_possible_truncation, reason = "the atlas is f32")]
    fn plane(normal: Vector3, height: f64, near: f64, tile: usize) -> Vec<f32> {
        (0..tile * tile)
            .map(|index| {
                let at = [(index % tile) as f64 + 0.5, (index / tile) as f64 + 0.5];
                let slope = -normal.dot(map::ray(at, tile));
                (near * slope / height).clamp(0.0, 1.0) as f32
            })
            .collect()
    }

    #[test]
    fn a_lit_plane_has_no_acne_and_half_the_bias_does_not_do() {
        let mut random = Random::new(11);
        for tile in [8, 16, 64] {
            let mut dark = [0, 0];
            let mut receivers = 0;
            for _ in 0..300 {
                let mut unit =
                    || Vector3::new(random.normal(), random.normal(), random.normal()).normalized();
                let (light, normal) = (light(unit()), unit());
                let height = random.uniform();
                let bias = map::least_bias(tile);
                let view = View::of_light(&light, &maps(tile, bias));
                // Anything of the plane that is nearer than the near distance is clipped at it.
                let atlas = plane(normal, height, view.near, tile);
                for _ in 0..100 {
                    let place = [(); 2].map(|()| tile as f64 * random.uniform());
                    let ray: Vector3 = map::ray(place, tile);
                    let slope = -normal.dot(ray);
                    if slope < 1e-3 || height / slope < view.near {
                        continue;
                    }
                    let position = light.position + view.basis.vector(ray * (height / slope));
                    receivers += 1;
                    for (dark, bias) in dark.iter_mut().zip([bias, 0.5 * bias]) {
                        let normal = view.basis.vector(normal);
                        let maps = maps(tile, bias);
                        let seen = visible(0, &light, position, normal, &maps, &atlas);
                        // A lift may carry a receiver behind the light's plane only if it was nearly there.
                        let rim = ray.z < 2.0 * map::least_bias(tile);
                        *dark += usize::from(seen == Seen::No && !rim);
                    }
                }
            }
            println!("{tile}: {receivers} receivers, {dark:?} in their own shadow");
            assert!(receivers > 5000);
            assert_eq!(dark[0], 0, "{tile}");
            assert!(dark[1] > 10, "{tile}: {dark:?}");
        }
    }

    #[test]
    fn an_occluder_hides_what_is_behind_it() {
        let light = light(Vector3::new(0.0, 0.0, 1.0));
        let maps = maps(16, map::least_bias(16));
        let view = View::of_light(&light, &maps);
        // A wall at the distance 2 in all directions of the map's first half of rows.
        let atlas: Vec<f32> = (0..256)
            .map(|index| if index < 128 { (view.near / 2.0) as f32 } else { 0.0 })
            .collect();
        let seen = |row: f64, distance: f64| {
            let ray: Vector3 = map::ray([8.0, row], 16);
            let position = light.position + view.basis.vector(ray * distance);
            visible(0, &light, position, -view.basis.vector(ray).normalized(), &maps, &atlas)
        };
        assert_eq!(
            (seen(4.5, 1.5), seen(4.5, 5.0), seen(12.5, 5.0)),
            (Seen::Yes, Seen::No, Seen::Yes)
        );
        let behind = light.position - Vector3::new(0.1, 0.1, 1.0);
        let up = Vector3::new(0.0, 0.0, 1.0);
        assert_eq!(visible(0, &light, behind, up, &maps, &atlas), Seen::No);
    }

    #[test]
    fn rounding_makes_some_uncertain_and_few() {
        let mut random = Random::new(4);
        let exact = light(Vector3::new(0.6, 0.0, 0.8));
        let bounded = Vsgl::<Bounded> {
            position: Vector3::constant(exact.position),
            variance: Bounded::constant(exact.variance),
            diffuse: Lobe {
                axis: Vector3::constant(exact.diffuse.axis),
                sharpness: Bounded::constant(2.0),
                coefficient: Vector3::constant(exact.diffuse.coefficient),
            },
            diffuse_mean_length: Bounded::constant(0.5),
            specular: None,
        };
        let maps = maps(16, map::least_bias(16));
        let near = View::of_light(&exact, &maps).near;
        let atlas: Vec<f32> =
            (0..256).map(|_| (near / (0.5 + 2.0 * random.uniform())) as f32).collect();
        let mut counts = [0; 3];
        for _ in 0..20_000 {
            let mut number = || random.normal();
            let position = Vector3::new(number(), number(), number());
            let normal = Vector3::new(number(), number(), number()).normalized();
            let seen = visible(0, &exact, position, normal, &maps, &atlas);
            let hedged = visible(
                0,
                &bounded,
                Vector3::constant(position),
                Vector3::constant(normal),
                &maps,
                &atlas,
            );
            assert!(hedged == seen || hedged == Seen::Uncertain);
            counts[hedged as usize] += 1;
        }
        println!("{counts:?}");
        assert!(counts[0] > 1000 && counts[1] > 1000 && counts[2] > 0 && counts[2] < 40);
    }
}
