// Where a point that was seen is lit: where rays of primary points have hit it, as its leaves may lie behind other surfaces.
// A hit is kept as the texel whose ray it was. Needs point_leaves.glsl.

const uint TEXEL_BITS = 25u;
const uint LARGEST_ORDER = (1u << (32u - TEXEL_BITS)) - 2u;

// A texel of all micro-buffers, with a number from 0 to 1 by which smaller ones are preferred. Never NO_LEAF.
uint pack_texel(float order, uint texel) { return uint(clamp(order, 0.0, 1.0) * float(LARGEST_ORDER)) << TEXEL_BITS | texel; }
uint unpack_texel(uint word) { return word & ((1u << TEXEL_BITS) - 1u); }
