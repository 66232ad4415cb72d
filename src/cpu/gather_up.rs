//! Twin of `point_selection/gather_up`.

use super::point_sides::{PointSides, has_bit, set_bit};

/// What is to be done for each side.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Gathered {
    /// Sides whose light is known in the end.
    pub known: Vec<u32>,
    /// Sides whose light is the mean of their children's.
    pub derived: Vec<u32>,
    /// Sides that need a micro-buffer of their own.
    pub needed: Vec<u32>,
}

/// Looks from the leaves up at what is known. `under_is_known` says whether what lies under primary points counts there.
#[must_use]
pub fn gather_up(sides: &PointSides, under: &[u32], seen: &[u32], under_is_known: bool) -> Gathered {
    let mut found = Gathered { known: sides.none(), derived: sides.none(), needed: sides.none() };
    for key in sides.keys().rev() {
        let [is_under, is_seen] = [under, seen].map(|bits| has_bit(bits, key));
        let both = !sides.is_leaf(key) && sides.children(key).into_iter().all(|child| has_bit(&found.known, child));
        if is_seen || both || (is_under && under_is_known) {
            set_bit(&mut found.known, key);
        }
        if both && !is_under {
            set_bit(&mut found.derived, key);
        }
        if is_seen && !is_under && !both {
            set_bit(&mut found.needed, key);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::point_sides::testing::{random_bits, random_sides};
    use super::super::spread_down::spread_down;
    use super::*;

    /// Whether the light of a side follows from what is lit.
    fn follows(sides: &PointSides, key: u32, lit: &[u32], under: &[u32]) -> bool {
        has_bit(lit, key)
            || has_bit(under, key)
            || !sides.is_leaf(key) && sides.children(key).into_iter().all(|child| follows(sides, child, lit, under))
    }

    #[test]
    fn what_is_seen_follows_from_what_is_lit_and_nothing_is_lit_that_follows_from_the_rest() {
        for seed in 0..6 {
            let sides = random_sides(64, seed);
            let primary = random_bits(256, 0.03, seed + 20);
            let seen = random_bits(256, 0.4, seed + 40);
            let under = spread_down(&sides, &primary);
            let found = gather_up(&sides, &under, &seen, true);
            for key in sides.keys().filter(|key| has_bit(&seen, *key)) {
                assert!(follows(&sides, key, &found.needed, &under), "{key} is seen and does not follow");
            }
            for key in sides.keys().filter(|key| has_bit(&found.needed, *key)) {
                let mut others = found.needed.clone();
                others[key as usize / 32] &= !(1 << (key % 32));
                assert!(!follows(&sides, key, &others, &under), "{key} follows from the others");
            }
        }
    }

    #[test]
    fn looking_upwards_first_never_needs_less() {
        for seed in 0..6 {
            let sides = random_sides(128, seed);
            let under = spread_down(&sides, &random_bits(512, 0.05, seed + 20));
            let seen = random_bits(512, 0.5, seed + 40);
            let [ours, paper] = [true, false].map(|known| gather_up(&sides, &under, &seen, known).needed);
            assert!(ours.iter().zip(&paper).all(|(ours, paper)| ours & !paper == 0));
        }
    }
}
