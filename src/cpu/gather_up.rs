//! Twin of `point_selection/gather_up`.

use super::point_sides::{PointSides, has_bit, set_bit};

/// What is to be done for each side.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Gathered {
    /// Sides that those above can take light from.
    pub known: Vec<u32>,
    /// Sides whose light is the mean of those of their children that are known.
    pub derived: Vec<u32>,
    /// Sides that need a micro-buffer of their own.
    pub needed: Vec<u32>,
}

/// Looks from the leaves up at what is known. `under_is_known` says whether what lies under primary points counts there,
/// `borrows` whether sides that are seen borrow the light of the one child that has any.
#[must_use]
pub fn gather_up(
    sides: &PointSides,
    [under, borrowed]: [&[u32]; 2],
    seen: &[u32],
    [under_is_known, borrows]: [bool; 2],
) -> Gathered {
    let mut found = Gathered { known: sides.none(), derived: sides.none(), needed: sides.none() };
    for key in sides.keys().rev() {
        let [is_under, is_seen] = [under, seen].map(|bits| has_bit(bits, key));
        let is_borrowed = has_bit(borrowed, key);
        let children = if sides.is_leaf(key) { Vec::new() } else { sides.children(key).to_vec() };
        let known = children.iter().filter(|child| has_bit(&found.known, **child)).count();
        let lends = children.iter().any(|child| has_bit(borrowed, *child));
        let both = known == 2;
        let borrowing = borrows && known == 1 && is_seen && !lends && !is_under && !is_borrowed;
        if (is_seen && !is_borrowed && !borrowing) || both || (is_under && under_is_known) {
            set_bit(&mut found.known, key);
        }
        if (both || borrowing) && !is_under {
            set_bit(&mut found.derived, key);
        }
        if is_seen && !(is_under || both || borrowing || is_borrowed) {
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
            let found = gather_up(&sides, [&under, &sides.none()], &seen, [true, false]);
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
            let [ours, paper] =
                [true, false].map(|known| gather_up(&sides, [&under, &sides.none()], &seen, [known, false]).needed);
            assert!(ours.iter().zip(&paper).all(|(ours, paper)| ours & !paper == 0));
        }
    }
}
