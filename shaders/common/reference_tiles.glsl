// Pixels of the reference techniques, dispatched in parts of REFERENCE_TILES tiles. Needs frame.glsl.

// The pixel of this invocation in part `part`; false where there is none.
bool reference_pixel(uint part, out uvec2 pixel) {
    uint tile = part * REFERENCE_TILES + gl_WorkGroupID.x;
    uint tiles_per_row = (image_size().x + TILE_SIZE - 1u) / TILE_SIZE;
    pixel = uvec2(tile % tiles_per_row, tile / tiles_per_row) * TILE_SIZE + gl_LocalInvocationID.xy;
    return all(lessThan(pixel, image_size()));
}
