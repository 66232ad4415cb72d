//! Twin of `grid_scatter/fixed_point.glsl`: 64-bit two's complement with 40 fractional bits. The shaders add its
//! two words by 32-bit atomics with carry, which is the same as one wrapping 64-bit addition.

/// 2^8.
const FIXED_HIGH: f32 = 256.0;
/// 2^32.
const FIXED_LOW: f32 = 4_294_967_296.0;
/// The smallest number above zero: 2^-40.
pub const SMALLEST: f32 = 1.0 / (FIXED_HIGH * FIXED_LOW);

/// A value in [-1, 1] as a fixed-point number. By magnitude, so that small negative values keep their bits.
#[must_use]
pub fn fixed_from_float(value: f32) -> u64 {
    let scaled = value.abs() * FIXED_HIGH;
    let high = scaled.floor();
    let magnitude = words(((scaled - high) * FIXED_LOW) as u32, high as u32);
    if value < 0.0 { magnitude.wrapping_neg() } else { magnitude }
}

/// The number in two words.
#[must_use]
pub fn words(low: u32, high: u32) -> u64 {
    u64::from(high) << 32 | u64::from(low)
}

/// The value of a sum.
#[must_use]
pub fn float_from_fixed(fixed: u64) -> f32 {
    let magnitude = (fixed as i64).unsigned_abs();
    let value = (magnitude >> 32) as f32 / FIXED_HIGH + (magnitude as u32) as f32 / (FIXED_HIGH * FIXED_LOW);
    if (fixed as i64) < 0 { -value } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_by_hand() {
        assert_eq!(fixed_from_float(0.0), 0);
        assert_eq!(fixed_from_float(1.0), 256 << 32);
        assert_eq!(fixed_from_float(SMALLEST), 1);
        assert_eq!(fixed_from_float(-1.0), (-256_i64 << 32) as u64);
        assert_eq!(fixed_from_float(-0.5), (-128_i64 << 32) as u64);
        assert_eq!(fixed_from_float(1.0 / 512.0), 1 << 31);
    }

    #[test]
    fn sums_cancel_whatever_the_order() {
        let values = [0.25, -0.75, 1.0 / 512.0, -1.0 / 1024.0, 0.5];
        let sum = |order: [usize; 5]| order.iter().fold(0_u64, |sum, i| sum.wrapping_add(fixed_from_float(values[*i])));
        assert_eq!(sum([0, 1, 2, 3, 4]), sum([4, 2, 0, 3, 1]));
        assert!((float_from_fixed(sum([0, 1, 2, 3, 4])) - 1.0 / 1024.0).abs() < 1e-9);
    }

    #[test]
    fn round_trips() {
        for value in [1.0_f32, 0.3, 1e-3, 1e-6, -1e-3, -0.3, -1.0, -1e-9] {
            assert!(
                (float_from_fixed(fixed_from_float(value)) - value).abs() < 1e-7 * value.abs() + SMALLEST,
                "{value}"
            );
        }
    }
}
