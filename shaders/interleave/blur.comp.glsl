// Removes the n x n pattern along one axis: averages a window that holds every sub-image equally often, without
// crossing the discontinuity buffer. Where a surface is thinner than n pixels no such window exists; there the
// average takes from across the edges, the more the fewer sub-images the surface holds. The first pass over the
// lighting also puts the pixels back in place. Shadow estimates are per unit of their own sub-image's lighting, so
// each counts as much as that lighting: a sub-image whose few lights are weak says little. One thread per pixel.
#include "common/frame.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
// 0: along x; 1: along y.
layout(constant_id = 0) const uint AXIS = 0u;
// Whether the input is in the interleaved layout rather than the picture's.
layout(constant_id = 1) const uint READS_INTERLEAVED = 0u;
// Whether values are weighted by their alpha.
layout(constant_id = 2) const uint WEIGHTED = 0u;
layout(set = 0, binding = 1) uniform texture2D input_image;
layout(set = 0, binding = 2, std430) readonly buffer Edges { uint edges[]; };
layout(set = 0, binding = 3, rgba32f) uniform writeonly image2D out_image;
layout(set = 0, binding = 4) uniform texture2D depth_image;

// The value at a pixel; times its weight, with the weight in alpha, where values are weighted.
vec4 value_at(ivec2 pixel) {
    ivec2 interleaved = ivec2(interleaved_from_pixel(uvec2(pixel)));
    vec4 value = texelFetch(input_image, READS_INTERLEAVED != 0u ? interleaved : pixel, 0);
    return WEIGHTED == 0u ? value : vec4(value.rgb * value.a, value.a);
}

// Pixels that can be reached from `pixel` along `direction` (+1 or -1) without crossing an edge, at most n.
int reach(ivec2 pixel, ivec2 axis, int direction) {
    ivec2 size = ivec2(image_size());
    uint bit = 1u << AXIS;
    int n = int(interleave());
    int steps = 0;
    ivec2 at = pixel;
    while (steps < n) {
        ivec2 before = direction > 0 ? at : at - axis;
        if (any(lessThan(before, ivec2(0))) || (edges[before.y * size.x + before.x] & bit) != 0u) {
            break;
        }
        at += direction * axis;
        ++steps;
    }
    return steps;
}

// The average of the n + 1 pixels about `pixel`, edges or not, as long as there is a surface.
vec4 average_across_edges(ivec2 pixel, ivec2 axis) {
    int half_window = int(interleave()) / 2;
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int i = -half_window; i <= half_window; ++i) {
        ivec2 p = pixel + i * axis;
        bool inside = all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, ivec2(image_size())));
        if (inside && texelFetch(depth_image, p, 0).x > 0.0) {
            float weight = abs(i) == half_window ? 0.5 : 1.0;
            sum += weight * value_at(p);
            weights += weight;
        }
    }
    return sum / max(weights, 1e-20);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(pixel), image_size()))) {
        return;
    }
    int n = int(interleave());
    // No `?:` between vectors: lavapipe (Mesa 22.3) takes another component's side where the condition is a constant of the
    // pipeline, and blurred along the diagonal.
    ivec2 axis = ivec2(1 - int(AXIS), int(AXIS));
    int back = reach(pixel, axis, -1);
    int ahead = reach(pixel, axis, 1);
    // n + 1 pixels with half weight at both ends, or near an edge n pixels shifted to one side: either way every
    // sub-image counts once.
    bool centred = back >= n / 2 && ahead >= n / 2;
    int first = centred ? -n / 2 : (back < n / 2 ? -back : max(ahead - n + 1, -back));
    int last = centred ? n / 2 : min(first + n - 1, ahead);
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int i = first; i <= last; ++i) {
        float weight = centred && (i == first || i == last) ? 0.5 : 1.0;
        sum += weight * value_at(pixel + i * axis);
        weights += weight;
    }
    vec4 average = sum / weights;
    int count = last - first + 1;
    if (count < n) {
        average = mix(average_across_edges(pixel, axis), average, float(count) / float(n));
    }
    if (WEIGHTED != 0u) {
        average.rgb /= max(average.a, 1e-30);
    }
    imageStore(out_image, pixel, average);
}
