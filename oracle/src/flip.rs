//! FLIP: how much two pictures seem to differ when they are shown in turn, in one place.
//!
//! For pictures that a screen can show (LDR-FLIP), at a distance from it that is stated in pixels per degree of the
//! visual field. Differences of colour are taken after what the eye blurs was blurred; where edges or points differ, they
//! are raised.

use core::f64::consts::{FRAC_1_SQRT_2, PI};

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use thiserror::Error;

use crate::Vector3;

/// A screen of 3840 pixels and 0.7 m, 0.7 m away.
// [Andersson 2020], the default
pub const PIXELS_PER_DEGREE: f64 = 67.0;
/// Pixels per degree that the filters are made for.
const RANGE: [f64; 2] = [4.0, 1000.0];

/// Why two pictures are not compared.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum FlipError {
    /// The pixels are not those of a picture of the size.
    #[error("the {which} has {found} pixels; a picture of {} x {} has {}", size[0], size[1], size[0] * size[1])]
    WrongCount {
        /// `reference` or `picture`.
        which: &'static str,
        /// The pixels given.
        found: usize,
        /// The size requested.
        size: [usize; 2],
    },
    /// A pixel is no colour.
    #[error("the {which} is not finite at column {}, row {}, and must be", at[0], at[1])]
    NotFinite {
        /// `reference` or `picture`.
        which: &'static str,
        /// The first such pixel.
        at: [usize; 2],
    },
    /// Nobody looks from there.
    #[error("there are {found} pixels per degree, and must be {} to {}", RANGE[0], RANGE[1])]
    PixelsPerDegree {
        /// What was requested.
        found: f64,
    },
}

/// How two pictures differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// The difference of every pixel, 0 to 1, row by row.
    pub errors: Vec<f64>,
    /// Their mean; 0 of a picture without pixels.
    pub mean: f64,
}

/// Compares a picture with its reference, both linear Rec. 709 and clamped to 0 to 1, row by row.
///
/// `pixels_per_degree` is how large the picture is seen, 4 to 1000; [`PIXELS_PER_DEGREE`] is usual.
///
/// # Errors
/// [`FlipError`] names the picture and the pixel at fault.
pub fn flip(
    reference: &[Vector3],
    picture: &[Vector3],
    size: [usize; 2],
    pixels_per_degree: f64,
) -> Result<Flip, FlipError> {
    if !(RANGE[0]..=RANGE[1]).contains(&pixels_per_degree) {
        return Err(FlipError::PixelsPerDegree { found: pixels_per_degree });
    }
    for (which, pixels) in [("reference", reference), ("picture", picture)] {
        if pixels.len() != size[0] * size[1] {
            return Err(FlipError::WrongCount { which, found: pixels.len(), size });
        }
        let finite = |pixel: &Vector3| pixel.to_array().iter().all(|part| part.is_finite());
        if let Some(index) = pixels.iter().position(|pixel| !finite(pixel)) {
            return Err(FlipError::NotFinite { which, at: [index % size[0], index / size[0]] });
        }
    }
    Ok(Viewer::new(pixels_per_degree).compare(reference, picture, size))
}

/// The linear value of an sRGB one, 0 to 1.
// [IEC 61966-2-1]
#[must_use]
pub fn decoded(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// CIE XYZ of linear Rec. 709, from the primaries' and D65's chromaticities; column by column.
// [IEC 61966-2-1]
const XYZ: DMat3 = DMat3::from_cols_array(&[
    0.412_390_799_265_959_5,
    0.212_639_005_871_510_24,
    0.019_330_818_715_591_82,
    0.357_584_339_383_878,
    0.715_168_678_767_756,
    0.119_194_779_794_625_98,
    0.180_480_788_401_834_3,
    0.072_192_315_360_733_71,
    0.950_532_152_249_660_7,
]);

/// XYZ over that of white.
fn relative_xyz(linear: Vector3) -> Vector3 {
    let white = XYZ * DVec3::ONE;
    (XYZ * DVec3::from(linear) / white).into()
}

fn linear_of_relative(xyz: Vector3) -> Vector3 {
    let white = XYZ * DVec3::ONE;
    (XYZ.inverse() * (DVec3::from(xyz) * white)).into()
}

/// Luminance, red against green, and blue against yellow, linear in light.
// [Andersson 2020, colour pipeline], YCxCz
fn opponents(linear: Vector3) -> Vector3 {
    let Vector3 { x, y, z } = relative_xyz(linear);
    Vector3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// What of opponents a screen can show.
fn linear_of_opponents(opponents: Vector3) -> Vector3 {
    let y = luminance(opponents);
    let xyz = Vector3::new(y + opponents.y / 500.0, y, y - opponents.z / 200.0);
    linear_of_relative(xyz).map(|part| part.clamp(0.0, 1.0))
}

/// The luminance of opponents, 0 to 1.
fn luminance(opponents: Vector3) -> f64 {
    (opponents.x + 16.0) / 116.0
}

/// CIE L*a*b* with chroma in proportion to lightness: dark colours look less colourful.
// [CIE 15:2004]; [Andersson 2020, colour pipeline], the Hunt effect
fn perceived(linear: Vector3) -> Vector3 {
    const KNEE: f64 = 6.0 / 29.0;
    let Vector3 { x, y, z } = relative_xyz(linear).map(|part| {
        if part > KNEE * KNEE * KNEE {
            part.cbrt()
        } else {
            part / (3.0 * KNEE * KNEE) + 4.0 / 29.0
        }
    });
    let lightness = 116.0 * y - 16.0;
    let chroma = 0.01 * lightness;
    Vector3::new(lightness, chroma * 500.0 * (x - y), chroma * 200.0 * (y - z))
}

/// The distance of two perceived colours, to the power 0.7.
// [Abasi 2020], HyAB; [Andersson 2020, colour pipeline]
fn color_distance(one: Vector3, other: Vector3) -> f64 {
    let difference = one - other;
    (difference.x.abs() + difference.y.hypot(difference.z)).powf(0.7)
}

/// Distances from 0 to 1: those below 0.4 of the greatest take 0.95 of the range.
// [Andersson 2020, colour pipeline]
fn color_error(one: Vector3, other: Vector3) -> f64 {
    let [green, blue] = [Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 1.0)].map(perceived);
    let greatest = color_distance(green, blue);
    let knee = 0.4 * greatest;
    let distance = color_distance(one, other);
    if distance < knee {
        0.95 * distance / knee
    } else {
        0.95 + 0.05 * (distance - knee) / (greatest - knee)
    }
}

/// Weights of a row or column of pixels, the middle one in the middle.
type Kernel = Vec<f64>;

/// A function of the distance from the middle pixel.
fn kernel(radius: usize, function: impl Fn(f64) -> f64) -> Kernel {
    (0..=2 * radius).map(|index| function(index as f64 - radius as f64)).collect()
}

/// A kernel whose weights above 0 add up to 1, and those below to -1.
fn balanced(kernel: Kernel) -> Kernel {
    let sum = |sign: f64| kernel.iter().map(|weight| (sign * weight).max(0.0)).sum::<f64>();
    let [above, below] = [1.0, -1.0].map(sum);
    kernel
        .iter()
        .map(|&weight| weight / if weight > 0.0 { above } else { below.max(1e-300) })
        .collect()
}

/// A plane filtered by one kernel along its rows and another along its columns; beyond an edge the edge goes on.
fn filtered(plane: &[f64], size: [usize; 2], along: &[f64], down: &[f64]) -> Vec<f64> {
    let [width, height] = size;
    let clamped = |at: usize, tap: usize, radius: usize, side: usize| {
        (at + tap).saturating_sub(radius).min(side - 1)
    };
    let pass = |plane: &[f64], kernel: &[f64], horizontal: bool| -> Vec<f64> {
        let radius = kernel.len() / 2;
        (0..plane.len())
            .into_par_iter()
            .map(|index| {
                let (x, y) = (index % width, index / width);
                let weighted = |(tap, weight): (usize, &f64)| {
                    let (x, y) = if horizontal {
                        (clamped(x, tap, radius, width), y)
                    } else {
                        (x, clamped(y, tap, radius, height))
                    };
                    weight * plane[y * width + x]
                };
                kernel.iter().enumerate().map(weighted).sum()
            })
            .collect()
    };
    pass(&pass(plane, along, true), down, false)
}

/// What a viewer at some distance blurs and finds.
struct Viewer {
    /// Of each opponent the sum of blurs: a weight and a kernel for both axes.
    contrast: [Vec<(f64, Kernel)>; 3],
    /// Of an edge and of a point: across it, and along it.
    features: [[Kernel; 2]; 2],
}

impl Viewer {
    fn new(pixels_per_degree: f64) -> Self {
        Self {
            contrast: contrast_kernels(pixels_per_degree),
            features: feature_kernels(pixels_per_degree),
        }
    }

    fn compare(&self, reference: &[Vector3], picture: &[Vector3], size: [usize; 2]) -> Flip {
        let [reference, picture] = [reference, picture].map(|pixels| self.seen(pixels, size));
        let errors: Vec<f64> = (0..size[0] * size[1])
            .map(|index| {
                let color = color_error(reference.colors[index], picture.colors[index]);
                let feature = |kind: usize| {
                    (reference.features[kind][index] - picture.features[kind][index]).abs()
                };
                let feature = (FRAC_1_SQRT_2 * feature(0).max(feature(1))).sqrt();
                // [Andersson 2020, final difference]
                color.powf(1.0 - feature)
            })
            .collect();
        let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
        Flip { errors, mean }
    }

    /// What is seen of a picture.
    fn seen(&self, pixels: &[Vector3], size: [usize; 2]) -> Seen {
        let shown = |pixel: &Vector3| opponents(pixel.map(|part| part.clamp(0.0, 1.0)));
        let opponents: Vec<Vector3> = pixels.iter().map(shown).collect();
        let blurred = [0, 1, 2].map(|channel| {
            let plane: Vec<f64> = opponents.iter().map(|pixel| pixel.to_array()[channel]).collect();
            let mut sum = vec![0.0; plane.len()];
            for (weight, kernel) in &self.contrast[channel] {
                let blurred = filtered(&plane, size, kernel, kernel);
                for (sum, part) in sum.iter_mut().zip(blurred) {
                    *sum += weight * part;
                }
            }
            sum
        });
        let color = |index: usize| {
            let [x, y, z] = [0, 1, 2].map(|channel| blurred[channel][index]);
            perceived(linear_of_opponents(Vector3::new(x, y, z)))
        };
        let luminances: Vec<f64> = opponents.iter().map(|&pixel| luminance(pixel)).collect();
        let features = [0, 1].map(|kind| {
            let [across, along] = &self.features[kind];
            let horizontal = filtered(&luminances, size, across, along);
            let vertical = filtered(&luminances, size, along, across);
            horizontal.iter().zip(vertical).map(|(one, other)| one.hypot(other)).collect()
        });
        Seen { colors: (0..pixels.len()).map(color).collect(), features }
    }
}

/// What is seen of a picture: colours after the eye's blur, and the strength of edges and of points.
struct Seen {
    colors: Vec<Vector3>,
    features: [Vec<f64>; 2],
}

/// What the eye blurs of luminance, red against green, and blue against yellow: Gaussians whose Fourier transforms are
/// the sensitivities to contrast, cut off at three standard deviations of the widest.
// [Andersson 2020, colour pipeline]
fn contrast_kernels(pixels_per_degree: f64) -> [Vec<(f64, Kernel)>; 3] {
    const SENSITIVITIES: [&[[f64; 2]]; 3] =
        [&[[1.0, 0.0047]], &[[1.0, 0.0053]], &[[34.1, 0.04], [13.5, 0.025]]];
    const WIDEST: f64 = 0.04;
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
    SENSITIVITIES.map(|terms| {
        let blurs: Vec<(f64, Kernel)> = terms
            .iter()
            .map(|&[amplitude, width]| {
                let kernel = kernel(radius, |pixels| {
                    let degrees = pixels / pixels_per_degree;
                    (-PI * PI * degrees * degrees / width).exp()
                });
                let sum: f64 = kernel.iter().sum();
                (amplitude * (PI / width).sqrt() * sum * sum, balanced(kernel))
            })
            .collect();
        let whole: f64 = blurs.iter().map(|(weight, _)| weight).sum();
        blurs.into_iter().map(|(weight, kernel)| (weight / whole, kernel)).collect()
    })
}

/// An edge is where the first derivative of a Gaussian is large, a point where the second one is. The Gaussian's standard
/// deviation is half the width that the eye is most sensitive to, 0.082 degrees.
// [Andersson 2020, feature pipeline]
fn feature_kernels(pixels_per_degree: f64) -> [[Kernel; 2]; 2] {
    let deviation = 0.5 * 0.082 * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as usize;
    let gaussian = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
    let edge = |x: f64| -x * gaussian(x);
    let point = |x: f64| (x * x / (deviation * deviation) - 1.0) * gaussian(x);
    let along = balanced(kernel(radius, gaussian));
    [kernel(radius, edge), kernel(radius, point)].map(|across| [balanced(across), along.clone()])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [40, 24];

    fn picture(color: impl Fn(u32, u32) -> [f64; 3]) -> Vec<Vector3> {
        (0..SIZE[1] as u32)
            .flat_map(|y| (0..SIZE[0] as u32).map(move |x| [x, y]))
            .map(|[x, y]| {
                let [r, g, b] = color(x, y);
                Vector3::new(r, g, b)
            })
            .collect()
    }

    /// A number 0 to 1 of a place and a channel.
    fn hashed(x: u32, y: u32, channel: u32) -> f64 {
        let word = x.wrapping_mul(0x9e37_79b1).wrapping_add(y.wrapping_mul(0x85eb_ca77));
        let word = word.wrapping_add(channel.wrapping_mul(0xc2b2_ae3d));
        let word = (word ^ (word >> 15)).wrapping_mul(0x2c1b_3c6d);
        let word = (word ^ (word >> 12)).wrapping_mul(0x297a_2d39);
        f64::from((word ^ (word >> 15)) >> 8) / f64::from(1 << 24)
    }

    fn named(name: &str) -> Vec<Vector3> {
        let [width, height] = SIZE.map(|side| side as f64);
        let light = |x: u32, y: u32| (x / 4 + y / 4).is_multiple_of(2);
        picture(|x, y| {
            let [across, down] = [f64::from(x) + 0.5, (f64::from(y) + 0.5) / height];
            match name {
                "gradient" => [across / width, down, 0.5],
                "shifted" => [(across + 1.0) / (width + 2.0), down, 0.4],
                "checker" => [f64::from(u8::from(light(x, y))); 3],
                "counter" => [f64::from(u8::from(!light(x, y))); 3],
                "noise" => [0, 1, 2].map(|channel| hashed(x, y, channel)),
                "gray" => [0.5; 3],
                "dot" => [if (x, y) == (20, 12) { 1.0 } else { 0.5 }; 3],
                "white" => [1.0; 3],
                "stripes" if x.is_multiple_of(2) => [0.8, 0.2, 0.1],
                "stripes" => [0.1, 0.3, 0.9],
                "even" => [0.45, 0.25, 0.5],
                _ => [0.0; 3],
            }
        })
    }

    /// Pixels per degree, reference, picture, the mean, and the errors at [`PLACES`].
    type Row = (f64, &'static str, &'static str, f64, [f64; 4]);

    const PLACES: [[usize; 2]; 4] = [[0, 0], [20, 12], [5, 20], [39, 23]];

    /// What the authors' own program gives, in f32: `flip-evaluator` 1.7 of PyPI, with numpy 2.4.6, by
    /// `evaluate(reference, picture, "LDR", inputsRGB=False, applyMagma=False, parameters={"ppd": ...})`.
    #[rustfmt::skip]
    const THEIRS: [Row; 16] = [
        (67.0, "gradient", "shifted", 0.2407759, [0.1642408, 0.2468576, 0.2540596, 0.2652278]),
        (67.0, "checker", "counter", 0.5921991, [0.9672430, 0.2712576, 0.4807036, 0.9672430]),
        (67.0, "gray", "noise", 0.3495244, [0.8949938, 0.3906027, 0.3864715, 0.5591850]),
        (67.0, "gray", "dot", 0.0023169, [0.0000000, 0.2110531, 0.0000000, 0.0000000]),
        (67.0, "noise", "noise", 0.0000000, [0.0000000, 0.0000000, 0.0000000, 0.0000000]),
        (67.0, "black", "white", 0.9673946, [0.9673918, 0.9673918, 0.9673918, 0.9673918]),
        (67.0, "stripes", "even", 0.0699102, [0.4232957, 0.0079725, 0.0634474, 0.3686495]),
        (67.0, "gradient", "noise", 0.7745792, [0.9761250, 0.5153209, 0.8700815, 0.9651452]),
        (20.0, "gradient", "shifted", 0.2384934, [0.1556074, 0.2447489, 0.2529117, 0.2668266]),
        (20.0, "checker", "counter", 0.9658779, [0.9673913, 0.9639084, 0.9656396, 0.9673913]),
        (20.0, "gray", "noise", 0.7580927, [0.9694445, 0.6257182, 0.9329897, 0.7601117]),
        (20.0, "gray", "dot", 0.0010817, [0.0000000, 0.7213547, 0.0000000, 0.0000000]),
        (20.0, "noise", "noise", 0.0000000, [0.0000000, 0.0000000, 0.0000000, 0.0000000]),
        (20.0, "black", "white", 0.9673946, [0.9673913, 0.9673913, 0.9673913, 0.9673913]),
        (20.0, "stripes", "even", 0.3249901, [0.4845759, 0.3095614, 0.3255150, 0.4404895]),
        (20.0, "gradient", "noise", 0.8402882, [0.9858197, 0.6541102, 0.3627471, 0.9726847]),
    ];

    fn worst(compare: impl Fn(f64, &[Vector3], &[Vector3]) -> Flip) -> f64 {
        let mut worst = 0.0_f64;
        for (pixels_per_degree, reference, picture, mean, errors) in THEIRS {
            let found = compare(pixels_per_degree, &named(reference), &named(picture));
            let at = PLACES.map(|[x, y]| found.errors[y * SIZE[0] + x]);
            let off = at.iter().zip(errors).map(|(found, theirs)| (found - theirs).abs());
            let off = off.fold((found.mean - mean).abs(), f64::max);
            println!(
                "{pixels_per_degree} {reference} {picture}: {:.7}, off by {off:.1e}",
                found.mean
            );
            worst = worst.max(off);
        }
        worst
    }

    #[test]
    fn is_what_the_authors_program_says() {
        let ours = worst(|pixels_per_degree, reference, picture| {
            flip(reference, picture, SIZE, pixels_per_degree).unwrap()
        });
        // Theirs is f32: features that are alike differ by some 2e-7, of which the square root is taken, 4e-4, by which the
        // power of an error changes by 1/e of it at most.
        assert!(ours < 2e-4, "{ours}");
        // Negative controls: eyes that blur nothing, eyes that see no points, and the pictures of another distance.
        let spoilt = |spoil: fn(&mut Viewer)| {
            worst(|pixels_per_degree, reference, picture| {
                let mut viewer = Viewer::new(pixels_per_degree);
                spoil(&mut viewer);
                viewer.compare(reference, picture, SIZE)
            })
        };
        let sharp = spoilt(|viewer| viewer.contrast = [(); 3].map(|()| vec![(1.0, vec![1.0])]));
        let pointless = spoilt(|viewer| viewer.features[1] = viewer.features[0].clone());
        let apart = worst(|_, reference, picture| flip(reference, picture, SIZE, 40.0).unwrap());
        assert!(sharp > 0.1 && pointless > 1e-3 && apart > 0.05, "{sharp} {pointless} {apart}");
    }

    #[test]
    fn colors_go_there_and_back() {
        for color in [[0.1, 0.7, 0.3], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]] {
            let [r, g, b] = color;
            let color = Vector3::new(r, g, b);
            assert!((linear_of_opponents(opponents(color)) - color).length() < 1e-12);
        }
        // White has no colour, black is nothing.
        assert!((perceived(Vector3::splat(1.0)) - Vector3::new(100.0, 0.0, 0.0)).length() < 1e-12);
        assert!(perceived(Vector3::zero()).length() < 1e-12);
        assert!((decoded(0.5) - 0.214_041_140_482_232_6).abs() < 1e-15);
    }

    #[test]
    fn bad_input_is_refused_by_name() {
        let gray = named("gray");
        let message = |reference: &[Vector3], picture: &[Vector3], distance| {
            flip(reference, picture, SIZE, distance).unwrap_err().to_string()
        };
        assert_eq!(
            message(&gray[1..], &gray, 67.0),
            "the reference has 959 pixels; a picture of 40 x 24 has 960"
        );
        let mut broken = gray.clone();
        broken[41].y = f64::NAN;
        assert_eq!(
            message(&gray, &broken, 67.0),
            "the picture is not finite at column 1, row 1, and must be"
        );
        for distance in [f64::NAN, 0.0, 1e9] {
            assert!(message(&gray, &gray, distance).ends_with("and must be 4 to 1000"));
        }
        let nothing = flip(&[], &[], [0, 7], 67.0).unwrap();
        assert_eq!((nothing.mean, nothing.errors.len()), (0.0, 0));
        // What a screen cannot show is shown as it can.
        let bright: Vec<Vector3> = gray.iter().map(|_| Vector3::splat(7.0)).collect();
        assert_eq!(flip(&bright, &named("white"), SIZE, 67.0).unwrap().mean, 0.0);
    }
}
