// How much the shadowed light of each tile of pixels differs from what the frames before have of the same surfaces, and
// whether their noise explains it: if not, the frames before know of another light, and count less. One workgroup per
// tile.
#include "common/frame.glsl"
#include "common/color.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
// Whether histories are of light itself rather than per unit of the frame's own unshadowed light.
layout(constant_id = 0) const uint KEEPS_LIGHT = 0u;
layout(set = 0, binding = 1) uniform texture2D shadowed_image;
layout(set = 0, binding = 2) uniform texture2D unshadowed_image;
layout(set = 0, binding = 3) uniform texture2D reprojected_shadowed;
layout(set = 0, binding = 4) uniform texture2D motion_image;
layout(set = 0, binding = 5) uniform texture2D previous_tiles;
// r: mean of the frame. g: variance of such means. b: how far the frame was above its history, in standard deviations.
// a: frames.
layout(set = 0, binding = 6, rgba32f) uniform writeonly image2D out_tiles;
// r: how much of the history to give up, 0 to 1.
layout(set = 0, binding = 7, rgba32f) uniform writeonly image2D out_given_up;

// A frame weighs at least this much in the variance.
const float LEAST_WEIGHT = 0.1;
// From so many frames on the variance is known.
const float KNOWN_FRAMES = 4.0;
// Of a single frame's deviation in the variance, in variances: a step shall not hide itself.
const float MOST_DEVIATION = 9.0;
// Standard deviations from which a difference is no noise in part, and wholly.
const vec2 LIMITS = vec2(3.0, 5.0);
// Two frames in a row on the same side count as one that is farther off, as the noise of their mean is less.
const float OF_TWO = sqrt(2.0);
// A frame by itself counts less: single samples of much light are common, and are not of the same tile twice in a row.
const float OF_ONE = 0.3;
const uint PIXELS = TILE_SIZE * TILE_SIZE;

// Light of the frame, of the history, and their unit.
shared vec3 sums[PIXELS];

vec3 light_at(ivec2 p) {
    vec4 before = texelFetch(reprojected_shadowed, p, 0);
    if (before.a <= 0.0) {
        return vec3(0.0);
    }
    float unit = texelFetch(unshadowed_image, p, 0).a;
    float now = luminance(texelFetch(shadowed_image, p, 0).rgb) * unit;
    return vec3(now, luminance(before.rgb) * (KEEPS_LIGHT != 0u ? 1.0 : unit), unit);
}

// Where most of a tile was, as a tile of the frame before: what its middle says.
vec4 tile_before(ivec2 tile) {
    ivec2 size = ivec2(image_size());
    ivec2 middle = min(tile * int(TILE_SIZE) + int(TILE_SIZE) / 2, size - 1);
    vec2 at = vec2(middle) + texelFetch(motion_image, middle, 0).xy;
    bool is_inside = all(greaterThanEqual(at, vec2(0.0))) && all(lessThan(at, vec2(size)));
    return frame.history_is_valid != 0u && is_inside ? texelFetch(previous_tiles, ivec2(at) / int(TILE_SIZE), 0) : vec4(0.0);
}

// How much of the history to give up, as a frame and the one before it lie so many standard deviations above their histories.
float given_up(float above, float above_before) {
    bool is_same_side = above * above_before > 0.0;
    float of_two = is_same_side ? OF_TWO * min(abs(above), abs(above_before)) : 0.0;
    return smoothstep(LIMITS.x, LIMITS.y, max(of_two, OF_ONE * abs(above)));
}

void compare(ivec2 tile, vec3 sum, vec4 before) {
    float now = sum.x / sum.z;
    if (before.a <= 0.0) {
        imageStore(out_tiles, tile, vec4(now, 0.0, 0.0, 1.0));
        imageStore(out_given_up, tile, vec4(0.0));
        return;
    }
    // The mean of the squared difference of two frames is twice their variance.
    float deviation = 0.5 * (now - before.r) * (now - before.r);
    bool is_known = before.a >= KNOWN_FRAMES;
    float above = is_known ? (sum.x - sum.y) / sum.z / sqrt(before.g + 1e-6) : 0.0;
    float variance = mix(before.g, is_known ? min(deviation, MOST_DEVIATION * before.g) : deviation, max(1.0 / before.a, LEAST_WEIGHT));
    imageStore(out_tiles, tile, vec4(now, variance, above, min(before.a + 1.0, 1e4)));
    imageStore(out_given_up, tile, vec4(given_up(above, before.b), 0.0, 0.0, 0.0));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    uint lane = gl_LocalInvocationIndex;
    sums[lane] = all(lessThan(pixel, ivec2(image_size()))) ? light_at(pixel) : vec3(0.0);
    // In pairs, so that the order is always the same.
    for (uint count = PIXELS / 2u; count > 0u; count /= 2u) {
        barrier();
        if (lane < count) {
            sums[lane] += sums[lane + count];
        }
    }
    if (lane == 0u) {
        ivec2 tile = ivec2(gl_WorkGroupID.xy);
        if (sums[0].z > 0.0) {
            compare(tile, sums[0], tile_before(tile));
        } else {
            imageStore(out_tiles, tile, vec4(0.0));
            imageStore(out_given_up, tile, vec4(0.0));
        }
    }
}
