//! Random numbers by hashing, bit-identical to those of `common/random.glsl`.

/// PCG hash (Jarzynski and Olano 2020).
#[must_use]
pub fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Hash of three numbers.
#[must_use]
pub fn hash3(a: u32, b: u32, c: u32) -> u32 {
    hash(a ^ hash(b ^ hash(c)))
}

/// A number strictly between 0 and 1 from random bits: 23 bits, so that the half is kept and 1 is never reached.
#[must_use]
pub fn unit_float(bits: u32) -> f32 {
    ((bits >> 9) as f32 + 0.5) * (1.0 / 8_388_608.0)
}

/// From a point of the R2 sequence (Roberts 2018) to the next, in units of 2⁻³².
const R2_STEP: [u32; 2] = [3_242_174_889, 2_447_445_414];

/// Point n of the R2 sequence shifted by a seed.
#[must_use]
pub fn r2_sequence(index: u32, seed: u32) -> [f32; 2] {
    let x = R2_STEP[0].wrapping_mul(index).wrapping_add(hash(seed));
    let y = R2_STEP[1].wrapping_mul(index).wrapping_add(hash(seed ^ 0x68bc_21eb));
    [unit_float(x), unit_float(y)]
}

/// Point n of the R2 sequence about the first one, -0.5 to 0.5: point 0 is 0, and points n and -n lie opposite each other.
#[must_use]
pub fn centered_r2(n: i32) -> [f32; 2] {
    R2_STEP.map(|step| step.wrapping_mul(n as u32) as i32 as f32 / 4_294_967_296.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hash_is_a_permutation_step_of_pcg() {
        // state = 2891336453 = 0xac564b05, shifted right by 10 + 4.
        assert_eq!(hash(0), {
            let word = ((0xac56_4b05_u32 >> 14) ^ 0xac56_4b05).wrapping_mul(277_803_737);
            (word >> 22) ^ word
        });
        assert_ne!(hash(0), hash(1));
        assert_eq!(hash3(1, 2, 3), hash(1 ^ hash(2 ^ hash(3))));
    }

    #[test]
    fn unit_floats_are_positive_and_even() {
        assert!(unit_float(0) > 0.0);
        let mean: f64 = (0..100_000).map(|i| f64::from(unit_float(hash(i)))).sum::<f64>() / 1e5;
        assert!((mean - 0.5).abs() < 0.003, "{mean}");
    }

    #[test]
    fn centered_points_lie_opposite_each_other() {
        assert_eq!(centered_r2(0), [0.0; 2]);
        let [x, y] = centered_r2(1);
        assert!((x + 0.245_122).abs() < 1e-6 && (y + 0.430_16).abs() < 1e-6, "{x}, {y}");
        for n in 1..100 {
            assert_eq!(centered_r2(n), centered_r2(-n).map(|edge| -edge), "{n}");
        }
    }

    #[test]
    fn unit_floats_stay_below_one() {
        assert!(unit_float(u32::MAX) < 1.0);
    }
}
