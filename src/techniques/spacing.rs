//! How far apart lights are: what the clamp is measured in.

use glam::Vec3;

/// Lights whose neighbours are looked for.
const QUERIES: usize = 256;
/// Neighbours that tell how dense lights are: enough that chance evens out, few enough to stay on one surface.
const NEIGHBOURS: usize = 8;

/// Radius of the disc as large as the part of the surface that a light stands for. Half of the lights have less room and
/// half have more, so that it does not matter how far away the farthest of them are. 0 where there are fewer than two.
pub(super) fn disc_radius(positions: &[[f32; 3]]) -> f32 {
    let step = positions.len().div_ceil(QUERIES).max(1);
    let radii: Vec<f32> = (0..positions.len()).step_by(step).map(|light| radius_around(positions, light)).collect();
    median(radii)
}

/// The middle one, or the upper one of the two in the middle; 0 where there are none.
pub(super) fn median(mut values: Vec<f32>) -> f32 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f32::total_cmp).1 }
}

/// The radius for one light: a disc around it that reaches to its k-th neighbour is shared by k lights.
fn radius_around(positions: &[[f32; 3]], light: usize) -> f32 {
    let at = Vec3::from(positions[light]);
    let mut squared: Vec<f32> = positions.iter().map(|p| Vec3::from(*p).distance_squared(at)).collect();
    // The light itself is the nearest of all.
    let k = NEIGHBOURS.min(positions.len() - 1);
    let (_, farthest, _) = squared.select_nth_unstable_by(k, f32::total_cmp);
    (*farthest / k.max(1) as f32).sqrt()
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use super::*;

    /// Lights on a square, `n * n` of them, `spacing` apart.
    fn square(n: u16, spacing: f32) -> Vec<[f32; 3]> {
        let at = |i: u16| f32::from(i) * spacing;
        (0..n).flat_map(|i| (0..n).map(move |j| [at(i), 0.0, at(j)])).collect()
    }

    /// The disc that is as large as a square.
    fn disc(edge: f32) -> f32 {
        edge / PI.sqrt()
    }

    fn check(found: f32, expected: f32) -> Result<(), String> {
        // The eighth neighbour on a square is a diagonal away: a disc so large has room for 2 pi squares, not for eight.
        if (found / expected - 1.0).abs() <= 0.15 { Ok(()) } else { Err(format!("{found} is not {expected}")) }
    }

    #[test]
    fn lights_on_a_square_stand_for_a_square_each() {
        for spacing in [1e-3, 0.2, 50.0] {
            check(disc_radius(&square(40, spacing)), disc(spacing)).unwrap();
        }
        check(0.9 * disc_radius(&square(40, 0.2)), disc(0.2)).unwrap_err();
    }

    #[test]
    fn far_lights_change_nothing() {
        let mut lights = square(40, 0.2);
        let alone = disc_radius(&lights);
        lights.extend((0..100_u8).map(|i| [3000.0 + 40.0 * f32::from(i), 0.0, 0.0]));
        check(disc_radius(&lights), alone).unwrap();
    }

    #[test]
    fn few_lights() {
        assert_eq!(disc_radius(&[]), 0.0);
        assert_eq!(disc_radius(&[[1.0; 3]]), 0.0);
        assert_eq!(disc_radius(&[[1.0; 3]; 20]), 0.0);
        assert!((disc_radius(&[[0.0; 3], [0.0, 2.0, 0.0]]) - 2.0).abs() < 1e-6);
    }
}
