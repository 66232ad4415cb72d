// The merged list: per sub-image, per level. TILE_STRIDE entries per sub-image in `tiles`.

// How many of the first `first` of a level's `count` lights sub-image `tile` of `tile_count` gets.
uint dealt_before(uint first, uint count, uint tile, uint tile_count) {
    return count < tile_count ? first : (first + tile_count - 1u - tile) / tile_count;
}

// Lights of a level with `count` lights that sub-image `tile` of `tile_count` gets.
uint dealt_count(uint count, uint tile, uint tile_count) { return dealt_before(count, count, tile, tile_count); }
