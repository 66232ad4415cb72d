//! Twin of `exclusive_scan/*`: ranks of words of bits.

/// Per word the number of set bits before it; one more entry than words.
#[must_use]
pub fn exclusive_scan(bits: &[u32]) -> Vec<u32> {
    let mut ranks = Vec::with_capacity(bits.len() + 1);
    let mut rank = 0;
    for word in bits {
        ranks.push(rank);
        rank += word.count_ones();
    }
    ranks.push(rank);
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_words_by_hand() {
        assert_eq!(exclusive_scan(&[0b1011, 0, u32::MAX, 1 << 31, 0b11]), [0, 3, 3, 35, 36, 38]);
        assert_eq!(exclusive_scan(&[]), [0]);
    }
}
