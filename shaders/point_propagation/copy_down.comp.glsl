// Gives the sides that are seen, and lie under a primary point, its irradiance, and those that borrow that of their parent, or
// of its parent where their own has none. One thread per word of bits.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#include "common/dispatch.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 1) uniform utexture2D point_nodes;
layout(set = 0, binding = 2, std430) readonly buffer PrimaryBits { uint primary_bits[]; };
layout(set = 0, binding = 3, std430) readonly buffer UnderBits { uint under_bits[]; };
layout(set = 0, binding = 4, std430) readonly buffer SeenBits { uint seen_bits[]; };
layout(set = 0, binding = 5, std430) buffer PointIrradiance { float point_irradiance[]; };
layout(set = 0, binding = 6, std430) readonly buffer BorrowedBits { uint borrowed_bits[]; };
layout(push_constant) uniform Push { uint word_count; };

#include "common/points.glsl"
#include "common/point_irradiance.glsl"

bool is_primary(uint key) { return (primary_bits[key >> 5u] >> (key & 31u) & 1u) != 0u; }

bool lends(uint key) { return ((seen_bits[key >> 5u] & ~borrowed_bits[key >> 5u]) >> (key & 31u) & 1u) != 0u; }

void main() {
    uint word = linear_thread();
    if (word >= word_count) {
        return;
    }
    for (uint left = seen_bits[word] & under_bits[word] & ~primary_bits[word]; left != 0u; left &= left - 1u) {
        uint key = 32u * word + uint(findLSB(left));
        uint above = parent_key(key);
        while (above > 3u && !is_primary(above)) {
            above = parent_key(above);
        }
        set_irradiance(key, irradiance_of(above));
    }
    for (uint left = borrowed_bits[word]; left != 0u; left &= left - 1u) {
        uint key = 32u * word + uint(findLSB(left));
        uint parent = parent_key(key);
        set_irradiance(key, irradiance_of(lends(parent) ? parent : parent_key(parent)));
    }
}
