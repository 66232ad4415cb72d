//! Twin of `merge/deal_lights`.

use super::count_lights::LevelTable;

/// Entries of a sub-image in the list of its levels.
pub const SUB_IMAGE_STRIDE: usize = crate::shared::SUB_IMAGE_STRIDE as usize;

/// Which levels are merged for how many sub-images.
#[derive(Clone, Copy, Debug)]
pub struct Deal {
    /// Sub-images, n x n.
    pub sub_image_count: u32,
    /// First used level.
    pub first_level: u32,
    /// Lmax.
    pub top_level: u32,
    /// Lights in S0.
    pub light_count: u32,
}

/// Lights of a level with `count` lights that `sub_image` of `sub_image_count` gets.
#[must_use]
pub fn dealt_count(count: u32, sub_image: u32, sub_image_count: u32) -> u32 {
    if count < sub_image_count { count } else { (count - sub_image).div_ceil(sub_image_count) }
}

/// `sub_images[SUB_IMAGE_STRIDE * t + l]`: first merged light of level l for sub-image t; the entry after Lmax ends the list.
/// Entries of unused levels stay 0.
#[must_use]
pub fn deal_lights(table: &LevelTable, deal: Deal) -> Vec<u32> {
    let mut sub_images = vec![0; SUB_IMAGE_STRIDE * deal.sub_image_count as usize];
    let mut next = 0;
    for (sub_image, entries) in sub_images.chunks_exact_mut(SUB_IMAGE_STRIDE).enumerate() {
        for level in deal.first_level..=deal.top_level {
            let count = if level == 0 { deal.light_count } else { table.count(level) as u32 };
            entries[level as usize] = next;
            next += dealt_count(count, sub_image as u32, deal.sub_image_count);
        }
        entries[deal.top_level as usize + 1] = next;
    }
    sub_images
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dealing_by_hand() {
        assert_eq!([0, 1, 2, 3].map(|sub_image| dealt_count(10, sub_image, 4)), [3, 3, 2, 2]);
        assert_eq!([0, 1, 2, 3].map(|sub_image| dealt_count(4, sub_image, 4)), [1; 4]);
        assert_eq!([0, 1, 2, 3].map(|sub_image| dealt_count(3, sub_image, 4)), [3; 4], "copied to all");
        for count in 16..100 {
            assert_eq!((0..16).map(|sub_image| dealt_count(count, sub_image, 16)).sum::<u32>(), count);
        }
    }

    #[test]
    fn starts_by_hand() {
        let mut table = LevelTable::default();
        table.0[2..6].copy_from_slice(&[0, 5, 5, 2]);
        let sub_images = deal_lights(&table, Deal { sub_image_count: 4, first_level: 1, top_level: 2, light_count: 9 });
        assert_eq!(sub_images[1..4], [0, 2, 4], "two of five, both of two");
        assert_eq!(sub_images[SUB_IMAGE_STRIDE + 1..SUB_IMAGE_STRIDE + 4], [4, 5, 7]);
    }
}
