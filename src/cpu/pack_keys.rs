//! Twin of `point_cut/pack_keys`.

use super::point_sides::{has_bit, set_bit};

/// The keys of a set in ascending order as far as they have room, how many have none, and the set without these.
#[must_use]
pub fn pack_keys(bits: &[u32], capacity: usize) -> (Vec<u32>, usize, Vec<u32>) {
    let mut keys: Vec<u32> = (0..32 * bits.len() as u32).filter(|key| has_bit(bits, *key)).collect();
    let lost = keys.len().saturating_sub(capacity);
    keys.truncate(capacity);
    let mut kept = vec![0; bits.len()];
    keys.iter().for_each(|key| set_bit(&mut kept, *key));
    (keys, lost, kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_keys_of_two_words() {
        assert_eq!(pack_keys(&[0b1010, 1 << 31 | 1], 9), (vec![1, 3, 32, 63], 0, vec![0b1010, 1 << 31 | 1]));
        assert_eq!(pack_keys(&[0b1010, 1 << 31 | 1], 3), (vec![1, 3, 32], 1, vec![0b1010, 1]));
        assert_eq!(pack_keys(&[0, 0], 0), (vec![], 0, vec![0, 0]));
    }
}
