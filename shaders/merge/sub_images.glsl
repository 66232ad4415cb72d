// The merged list: per sub-image, per level. SUB_IMAGE_STRIDE entries per sub-image in `sub_images`.

// How many of the first `first` of a level's `count` lights sub-image `sub_image` of `sub_image_count` gets.
uint dealt_before(uint first, uint count, uint sub_image, uint sub_image_count) {
    return count < sub_image_count ? first : (first + sub_image_count - 1u - sub_image) / sub_image_count;
}

// Lights of a level with `count` lights that sub-image `sub_image` of `sub_image_count` gets.
uint dealt_count(uint count, uint sub_image, uint sub_image_count) {
    return dealt_before(count, count, sub_image, sub_image_count);
}
