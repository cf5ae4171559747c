//! From radiance to what a screen shows, for who looks and for what measures as the eye does.
//!
//! Exposure scales radiance, a curve bends it into 0 to 1, sRGB encodes it. The curve is the extended one of
//! [Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images"], applied per channel.

/// Exposed radiance that is shown as white.
pub const WHITE: f32 = 4.0;
/// Exposed radiance of the mean; the key of a scene that is neither dark nor bright [Reinhard et al. 2002].
pub const KEY: f32 = 0.18;

/// A factor on radiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure(f32);

impl Exposure {
    /// The factor `2^stops`.
    #[must_use]
    pub fn from_stops(stops: f32) -> Self {
        Self(stops.exp2())
    }

    /// Brings the geometric mean of the luminance of lit pixels to mid-grey [Reinhard et al. 2002, Eq. (1), Eq. (2)].
    /// Takes linear Rec. 709 radiance.
    ///
    /// Pictures to be compared have to share one exposure.
    #[must_use]
    pub fn automatic(pixels: &[[f32; 3]]) -> Self {
        let lit = pixels.iter().map(|[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b);
        let (count, sum) = lit
            .filter(|&value| value > 0.0 && value.is_finite())
            .fold((0_u32, 0.0), |(count, sum), value| (count + 1, sum + f64::from(value.ln())));
        if count == 0 {
            return Self(1.0);
        }
        let mean = (sum / f64::from(count)).exp() as f32;
        Self((KEY / mean).clamp(f32::MIN_POSITIVE, f32::MAX))
    }

    /// The same in stops, as the command line takes it.
    #[must_use]
    pub fn stops(self) -> f32 {
        self.0.log2()
    }

    /// A pixel as a screen shows it: sRGB, 0 to 1; what is not finite stays so.
    #[must_use]
    pub fn shown(self, pixel: [f32; 3]) -> [f32; 3] {
        pixel.map(|value| srgb(curve(value * self.0)))
    }
}

/// [Reinhard et al. 2002, Eq. (4)]: nearly linear in the dark, 1 at [`WHITE`].
#[must_use]
pub fn curve(value: f32) -> f32 {
    if value >= WHITE {
        return 1.0;
    }
    value * (1.0 + value / (WHITE * WHITE)) / (1.0 + value)
}

/// The encoding of IEC 61966-2-1.
#[must_use]
pub fn srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}
