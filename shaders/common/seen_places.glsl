// Where a point that was seen is lit: where rays of primary points have hit it, as its leaves may lie behind other surfaces.
// A hit is kept as the texel whose ray it was. Needs point_leaves.glsl.

const uint TEXEL_BITS = 25u;
const uint LARGEST_ORDER = (1u << (32u - TEXEL_BITS)) - 2u;

// A number from 0 to 1 by which smaller texels are preferred, in as many bits as there are.
uint texel_order(float order) { return uint(clamp(order, 0.0, 1.0) * float(LARGEST_ORDER)); }

// A texel of all micro-buffers with its order. Never NO_LEAF.
uint pack_texel(uint order, uint texel) { return order << TEXEL_BITS | texel; }
uint unpack_texel(uint word) { return word & ((1u << TEXEL_BITS) - 1u); }
