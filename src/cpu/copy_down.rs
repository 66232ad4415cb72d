//! Twin of `point_propagation/copy_down`.

use glam::Vec3;

use super::point_sides::{PointSides, has_bit};
use super::spread_down::lends;

/// Gives the sides that are seen, and lie under a primary point, its irradiance, and those that borrow that of their parent, or
/// of its parent where their own has none.
pub fn copy_down(
    sides: &PointSides,
    primary: &[u32],
    [under, borrowed]: [&[u32]; 2],
    seen: &[u32],
    irradiance: &mut [Vec3],
) {
    let is_copied = |key: &u32| has_bit(seen, *key) && has_bit(under, *key) && !has_bit(primary, *key);
    for key in sides.keys().filter(is_copied) {
        let mut above = sides.parent(key);
        while above > 3 && !has_bit(primary, above) {
            above = sides.parent(above);
        }
        irradiance[key as usize] = irradiance[above as usize];
    }
    for key in sides.keys().filter(|key| has_bit(borrowed, *key)) {
        let parent = sides.parent(key);
        let lender = if lends(parent, under, seen, borrowed) { parent } else { sides.parent(parent) };
        irradiance[key as usize] = irradiance[lender as usize];
    }
}
