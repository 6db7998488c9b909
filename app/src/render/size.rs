//! How large a picture may be: checked before anything is allocated.

/// Longest side of a picture in pixels.
pub const MAX_SIDE_PX: u32 = 8192;
/// Most pixels of a picture: as many as 8K has (7680 × 4320). Its samples and depths take 1.3 GB while it is drawn.
const MAX_PIXELS: u64 = 7680 * 4320;
/// Fewest and most pixels per point.
const SCALES: [f32; 2] = [0.25, 10.0];

/// Why a picture of this size is not drawn.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SizeError {
    /// A side is 0 or too long.
    #[error("picture of {width} × {height} pixels: each side must be between 1 and {limit}")]
    Side {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// Longest side that this adapter draws.
        limit: u32,
    },
    /// The sides are not too long, but both together are too much.
    #[error(
        "picture of {width} × {height} pixels: found {:.1} million pixels, wanted at most {:.1} million",
        f64::from(*width) * f64::from(*height) / 1e6,
        MAX_PIXELS as f64 / 1e6
    )]
    Pixels {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
    },
    /// Lines and words would be invisible, or fill the picture.
    #[error("found {scale} pixels per point, wanted between {} and {}", SCALES[0], SCALES[1])]
    Scale {
        /// Scale asked for.
        scale: f32,
    },
}

/// Whether a picture of this size can be drawn.
///
/// * `device_limit`: longest side of a texture of the device.
///
/// # Errors
/// [`SizeError::Side`] or [`SizeError::Pixels`].
pub fn check_size([width, height]: [u32; 2], device_limit: u32) -> Result<(), SizeError> {
    let limit = device_limit.min(MAX_SIDE_PX);
    if ![width, height].iter().all(|side| (1..=limit).contains(side)) {
        return Err(SizeError::Side { width, height, limit });
    }
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(SizeError::Pixels { width, height });
    }
    Ok(())
}

/// Whether lines, points and words of this many pixels per point can be drawn.
///
/// # Errors
/// [`SizeError::Scale`], also for a number that is not finite.
pub fn check_scale(scale: f32) -> Result<(), SizeError> {
    if (SCALES[0]..=SCALES[1]).contains(&scale) { Ok(()) } else { Err(SizeError::Scale { scale }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_k_is_drawn_and_nothing_larger() {
        assert_eq!(check_size([7680, 4320], 16_384), Ok(()));
        assert_eq!(check_size([7680, 4321], 16_384), Err(SizeError::Pixels { width: 7680, height: 4321 }));
        assert_eq!(check_size([8193, 1], 16_384), Err(SizeError::Side { width: 8193, height: 1, limit: 8192 }));
        assert_eq!(check_size([3000, 1], 2048), Err(SizeError::Side { width: 3000, height: 1, limit: 2048 }));
        assert!(check_size([0, 10], 2048).is_err());
        let said = SizeError::Pixels { width: 8000, height: 8000 }.to_string();
        assert!(said.contains("64.0 million") && said.contains("33.2 million"), "{said}");
    }

    #[test]
    fn a_scale_is_a_number_between_its_limits() {
        assert_eq!((check_scale(0.25), check_scale(10.0)), (Ok(()), Ok(())));
        assert!([0.0, 0.2, 10.5, f32::NAN, f32::INFINITY].into_iter().all(|scale| check_scale(scale).is_err()));
    }
}
