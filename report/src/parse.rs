//! Sizes and numbers on the command line. Errors name what is valid.

/// The maximum width and height: no device has larger textures.
const LARGEST: u32 = 32768;

/// `WxH` in pixels.
///
/// # Errors
///
/// What is none, has no pixel, or is larger than any device's textures.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let wrong = || format!("'{text}' is not a size such as 640x360");
    let (width, height) = text.split_once('x').ok_or_else(wrong)?;
    let size = [width, height].map(str::parse::<u32>);
    match size {
        [Ok(width), Ok(height)] if width.max(height) > LARGEST => {
            Err(format!("'{text}' is too large; give at most {LARGEST}x{LARGEST}"))
        }
        [Ok(0), Ok(_)] | [Ok(_), Ok(0)] => Err(format!("'{text}' has no pixel; give at least 1x1")),
        [Ok(width), Ok(height)] => Ok([width, height]),
        _ => Err(wrong()),
    }
}

/// Stops of exposure.
///
/// # Errors
///
/// What is no number from -100 to 100.
pub fn stops(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|number| number.abs() <= 100.0);
    number.ok_or_else(|| format!("'{text}' is not a number of stops from -100 to 100"))
}

/// A number above 0.
///
/// # Errors
///
/// What is none, or infinite.
pub fn factor(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|number| *number > 0.0 && number.is_finite());
    number.ok_or_else(|| format!("'{text}' is not a number above 0"))
}

/// A share, as a number or a percentage.
///
/// # Errors
///
/// What is none, negative or infinite.
pub fn share(text: &str) -> Result<f64, String> {
    let wrong = || format!("'{text}' is not a share such as 0.3 or 30%");
    let (number, unit) = match text.strip_suffix('%') {
        Some(number) => (number, 100.0),
        None => (text, 1.0),
    };
    let share = number.trim().parse::<f64>().map_err(|_| wrong())? / unit;
    if share >= 0.0 && share.is_finite() { Ok(share) } else { Err(wrong()) }
}

/// A time above 0 in milliseconds.
///
/// # Errors
///
/// What is none, or infinite.
pub fn milliseconds(text: &str) -> Result<f64, String> {
    let wrong = || format!("'{text}' is not a number of milliseconds above 0");
    let time = text.parse::<f64>().map_err(|_| wrong())?;
    if time > 0.0 && time.is_finite() { Ok(time) } else { Err(wrong()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read() {
        assert_eq!(size("640x360"), Ok([640, 360]));
        for wrong in ["640", "x", "640x", "-1x2", "axb"] {
            assert!(size(wrong).unwrap_err().contains(wrong));
        }
        for empty in ["0x0", "0x4", "4x0"] {
            assert!(size(empty).unwrap_err().contains("no pixel"), "{empty}");
        }
        for large in ["4294967295x4294967295", "32769x1", "1x32769"] {
            assert!(size(large).unwrap_err().contains("at most 32768x32768"), "{large}");
        }
        for wrong in ["NaN", "inf", "-inf", "101", "x"] {
            assert!(stops(wrong).unwrap_err().contains(wrong), "{wrong}");
        }
    }

    #[test]
    fn budgets_are_read() {
        assert_eq!(share("30%"), Ok(0.3));
        assert_eq!(share("0.25"), Ok(0.25));
        for wrong in ["", "-1", "x", "%", "inf", "NaN", "1 %%"] {
            assert!(share(wrong).is_err(), "{wrong}");
        }
        assert_eq!(milliseconds("1.5"), Ok(1.5));
        for wrong in ["0", "-1", "fast", "inf", "NaN"] {
            assert!(milliseconds(wrong).unwrap_err().contains(wrong), "{wrong}");
        }
    }
}
