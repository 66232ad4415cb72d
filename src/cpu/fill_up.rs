//! Twin of `point_selection/fill_up`.

use super::gather_up::Gathered;
use super::point_sides::{PointSides, has_bit, set_bit};

/// Sides that have light before it is copied downwards, and those of them whose light is the mean of those of their children
/// that have any.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lending {
    /// All of them.
    pub lending: Vec<u32>,
    /// Those with the mean of their children's.
    pub averaged: Vec<u32>,
}

/// Looks from the leaves up at what has light below it, where `primary` points and what is needed are lit.
#[must_use]
pub fn fill_up(sides: &PointSides, primary: &[u32], [under, borrowed]: [&[u32]; 2], found: &Gathered) -> Lending {
    let mut filled = Lending { lending: sides.none(), averaged: sides.none() };
    for key in sides.keys().rev() {
        let is_lit = has_bit(primary, key) || has_bit(&found.needed, key);
        let has_below = !sides.is_leaf(key) && sides.children(key).iter().any(|child| has_bit(&filled.lending, *child));
        let is_filled = has_below && !has_bit(under, key) && !has_bit(borrowed, key);
        if is_lit || has_bit(&found.derived, key) || is_filled {
            set_bit(&mut filled.lending, key);
            if !is_lit {
                set_bit(&mut filled.averaged, key);
            }
        }
    }
    filled
}

/// The side itself, or the nearest one above it that has light; `None` where none has.
#[must_use]
pub fn nearest_lending(sides: &PointSides, lending: &[u32], mut key: u32) -> Option<u32> {
    while key > 3 && !has_bit(lending, key) {
        key = sides.parent(key);
    }
    has_bit(lending, key).then_some(key)
}

#[cfg(test)]
mod tests {
    use super::super::gather_up::gather_up;
    use super::super::point_sides::testing::{random_bits, random_sides};
    use super::super::spread_down::spread_down;
    use super::*;

    #[test]
    fn whatever_has_light_below_lends_it_and_every_side_finds_some() {
        for seed in 0..6 {
            let sides = random_sides(64, seed);
            let primary = random_bits(256, 0.03, seed + 20);
            let seen = random_bits(256, 0.1, seed + 40);
            let under = spread_down(&sides, &primary);
            let none = sides.none();
            let found = gather_up(&sides, [&under, &none], &seen, [true, false]);
            let filled = fill_up(&sides, &primary, [&under, &none], &found);
            for key in sides.keys().filter(|key| !has_bit(&under, *key) || has_bit(&primary, *key)) {
                let below = sides.keys().filter(|other| {
                    let mut at = *other;
                    while at > key {
                        at = sides.parent(at);
                    }
                    at == key
                });
                let is_lit = |key: u32| has_bit(&primary, key) || has_bit(&found.needed, key);
                assert_eq!(has_bit(&filled.lending, key), below.into_iter().any(is_lit), "{key}");
            }
            // Of both sides of the root something is lit in each of these.
            assert!(sides.keys().all(|key| nearest_lending(&sides, &filled.lending, key).is_some()));
        }
    }
}
