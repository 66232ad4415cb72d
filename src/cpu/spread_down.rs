//! Twin of `point_selection/spread_down`.

use super::point_sides::{PointSides, has_bit, set_bit};

/// The sides that are primary points or lie under one.
#[must_use]
pub fn spread_down(sides: &PointSides, primary_bits: &[u32]) -> Vec<u32> {
    let mut under = sides.none();
    for key in sides.keys() {
        let parent = sides.parent(key);
        if has_bit(primary_bits, key) || (parent >= 2 && has_bit(&under, parent)) {
            set_bit(&mut under, key);
        }
    }
    under
}

/// The sides that borrow the light of their parent: both are seen, neither lies under a primary point, and the parent does
/// not borrow.
#[must_use]
pub fn borrow_down(sides: &PointSides, under: &[u32], seen: &[u32]) -> Vec<u32> {
    let mut borrowed = sides.none();
    let is_own = |key: u32, borrowed: &[u32]| has_bit(seen, key) && !has_bit(under, key) && !has_bit(borrowed, key);
    for key in sides.keys() {
        let parent = sides.parent(key);
        if parent >= 2 && is_own(key, &borrowed) && is_own(parent, &borrowed) {
            set_bit(&mut borrowed, key);
        }
    }
    borrowed
}

#[cfg(test)]
mod tests {
    use super::super::point_sides::testing::{random_bits, random_sides};
    use super::*;

    #[test]
    fn a_side_is_under_when_one_on_its_way_up_is_primary() {
        for seed in 0..4 {
            let sides = random_sides(128, seed);
            let primary = random_bits(512, 0.05, seed + 10);
            let under = spread_down(&sides, &primary);
            for key in sides.keys() {
                let way = std::iter::successors(Some(key), |key| Some(sides.parent(*key))).take_while(|key| *key >= 2);
                assert_eq!(has_bit(&under, key), way.into_iter().any(|key| has_bit(&primary, key)), "{key}");
            }
        }
    }
}
