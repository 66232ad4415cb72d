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

/// Whether the sides below may borrow the light of this one.
#[must_use]
pub fn lends(key: u32, under: &[u32], seen: &[u32], borrowed: &[u32]) -> bool {
    key >= 2 && has_bit(seen, key) && !has_bit(under, key) && !has_bit(borrowed, key)
}

/// The sides that borrow the light of their parent or of its parent: both are seen, neither lies under a primary point, and
/// the lender does not borrow.
#[must_use]
pub fn borrow_down(sides: &PointSides, under: &[u32], seen: &[u32]) -> Vec<u32> {
    let mut borrowed = sides.none();
    for key in sides.keys() {
        let parent = sides.parent(key);
        // Sides 2 and 3 are the root's.
        let above = if parent >= 2 { [parent, sides.parent(parent)] } else { [parent; 2] };
        let is_lent = above.into_iter().any(|above| lends(above, under, seen, &borrowed));
        if is_lent && lends(key, under, seen, &borrowed) {
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
