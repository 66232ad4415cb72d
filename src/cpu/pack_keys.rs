//! Twin of `point_cut/pack_keys`.

/// The keys of a set in ascending order as far as they have room, and how many have none.
#[must_use]
pub fn pack_keys(bits: &[u32], capacity: usize) -> (Vec<u32>, usize) {
    let keys = (0..32 * bits.len() as u32).filter(|key| super::point_sides::has_bit(bits, *key));
    let mut keys: Vec<u32> = keys.collect();
    let lost = keys.len().saturating_sub(capacity);
    keys.truncate(capacity);
    (keys, lost)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_keys_of_two_words() {
        assert_eq!(pack_keys(&[0b1010, 1 << 31 | 1], 9), (vec![1, 3, 32, 63], 0));
        assert_eq!(pack_keys(&[0b1010, 1 << 31 | 1], 3), (vec![1, 3, 32], 1));
        assert_eq!(pack_keys(&[0, 0], 0), (vec![], 0));
    }
}
