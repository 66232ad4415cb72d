// How far the shadowed light of each tile of pixels, and of the 3x3 tiles around it, is from what the frames before have of
// the same surfaces, and whether their noise explains it: if not, the frames before know of another light, and count less.
// One thread per tile.
#include "common/frame.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
// The tiles' light (temporal/sum_tiles).
layout(set = 0, binding = 1) uniform texture2D tile_sums;
layout(set = 0, binding = 2) uniform texture2D motion_image;
layout(set = 0, binding = 3) uniform texture2D previous_tiles;
// r: mean of the frame. g: variance of such means. b: its drift, how far the last few frames were above their histories, in
// standard deviations of one. a: frames.
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2D out_tiles;
// r: how much of the history to give up, 0 to 1.
layout(set = 0, binding = 5, rgba32f) uniform writeonly image2D out_given_up;

// A frame weighs at least this much in the variance.
const float LEAST_WEIGHT = 0.1;
// Added to a variance, and what one that grows again begins with: without it that of a tile without light would stay 0.
const float LEAST_VARIANCE = 1e-6;
// From so many frames on the variance is known.
const float KNOWN_FRAMES = 8.0;
// Of a single frame's deviation in the variance, in variances: a step shall not hide itself.
const float MOST_DEVIATION = 9.0;
// Standard deviations from which a difference is noise no longer in part, and not at all: of a frame, and of a drift, in which
// what is rare among frames averages out.
const vec2 FRAME_LIMITS = vec2(4.0, 6.0);
// Where lights or surfaces have moved since the frame before, light is more likely to have changed, and less is taken for noise.
vec2 drift_limits() { return frame.lighting_stands != 0u ? vec2(3.0, 5.0) : vec2(1.5, 3.5); }
// A frame of a single tile counts less: single samples of much light are common, and are not of the same tile twice in a row.
const float OF_ONE = 0.3;
// Standard deviations that a frame counts in the drift, and a tile for its frame among others, at most: a single one never makes up
// for the rest.
const float MOST_COUNTED = 4.0;
// Weight of the newest frame in the drift.
const float DRIFT_WEIGHT = 0.25;
// Variance of such a mean of numbers whose own is 1.
const float MEAN_VARIANCE = DRIFT_WEIGHT / (2.0 - DRIFT_WEIGHT);
// A drift gives up no more than this in a frame, as it goes on in the next: the least weight of a frame in the paper, or more
// while something moves.
float most_by_drift() { return frame.lighting_stands != 0u ? 0.2 : 0.5; }

ivec2 tile_count() { return (ivec2(image_size()) + int(TILE_SIZE) - 1) / int(TILE_SIZE); }

// Where most of a tile was, as a tile of the frame before: what its middle says.
vec4 tile_before(ivec2 tile) {
    ivec2 size = ivec2(image_size());
    ivec2 middle = min(tile * int(TILE_SIZE) + int(TILE_SIZE) / 2, size - 1);
    vec2 at = vec2(middle) + texelFetch(motion_image, middle, 0).xy;
    bool is_inside = all(greaterThanEqual(at, vec2(0.0))) && all(lessThan(at, vec2(size)));
    return frame.history_is_valid != 0u && is_inside ? texelFetch(previous_tiles, ivec2(at) / int(TILE_SIZE), 0) : vec4(0.0);
}

// Standard deviation of the difference of a tile's light in a frame and in its history, which has noise of its own.
float deviation_of(vec4 sum, vec4 before) { return sum.z * sqrt((before.g + LEAST_VARIANCE) * (1.0 + sum.a / sum.z)); }

// The standard deviation of such differences, and how many of them a tile's light is above its history: in this frame, and in the
// last few.
struct Difference {
    float deviation;
    float of_frame;
    float drift;
};

Difference difference_of(vec4 sum, vec4 before) {
    float deviation = deviation_of(sum, before);
    float of_frame = (sum.x - sum.y) / deviation;
    return Difference(deviation, of_frame, mix(before.b, clamp(of_frame, -MOST_COUNTED, MOST_COUNTED), DRIFT_WEIGHT));
}

// Standard deviation of a drift that is noise. That of the frames averages out; that of the history, which they have in common,
// does not.
float drift_deviation(vec4 sum) {
    float of_history = sum.a / sum.z;
    return sqrt((MEAN_VARIANCE + of_history) / (1.0 + of_history));
}

// What is given up of the history for a frame, and for a drift.
vec2 given_up(vec2 deviations) {
    vec2 of_drift = drift_limits();
    return smoothstep(vec2(FRAME_LIMITS.x, of_drift.x), vec2(FRAME_LIMITS.y, of_drift.y), abs(deviations));
}

// The same for what the tiles around one say: nothing if they are not off together, and otherwise as much as makes the error
// least, which is the share of the squared difference that is no noise.
vec2 given_up_by_group(ivec2 tile) {
    vec2 above = vec2(0.0);
    vec2 squares = vec2(0.0);
    float variance = 0.0;
    float count = 0.0;
    for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
            ivec2 other = tile + ivec2(x, y);
            if (any(lessThan(other, ivec2(0))) || any(greaterThanEqual(other, tile_count()))) {
                continue;
            }
            vec4 sum = texelFetch(tile_sums, other, 0);
            vec4 before = tile_before(other);
            if (sum.z > 0.0 && before.a >= KNOWN_FRAMES) {
                Difference difference = difference_of(sum, before);
                float of_frame = clamp(difference.of_frame, -MOST_COUNTED, MOST_COUNTED);
                vec2 deviations = vec2(of_frame, difference.drift / drift_deviation(sum));
                above += deviations * difference.deviation;
                squares += deviations * deviations;
                variance += difference.deviation * difference.deviation;
                count += 1.0;
            }
        }
    }
    if (variance <= 0.0) {
        return vec2(0.0);
    }
    return given_up(above / sqrt(variance)) * max(1.0 - count / max(squares, vec2(1e-30)), vec2(0.0));
}

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tile_count()))) {
        return;
    }
    vec4 sum = texelFetch(tile_sums, tile, 0);
    vec4 before = sum.z > 0.0 ? tile_before(tile) : vec4(0.0);
    float now = sum.z > 0.0 ? sum.x / sum.z : 0.0;
    if (before.a <= 0.0) {
        imageStore(out_tiles, tile, vec4(now, 0.0, 0.0, sum.z > 0.0 ? 1.0 : 0.0));
        // A history that is black says nothing of what light there is now.
        bool was_black = sum.z <= 0.0 && sum.x > 0.0;
        imageStore(out_given_up, tile, vec4(was_black ? 1.0 : 0.0, 0.0, 0.0, 0.0));
        return;
    }
    // The mean of the squared difference of two frames is twice their variance.
    float deviation = 0.5 * (now - before.r) * (now - before.r);
    bool is_known = before.a >= KNOWN_FRAMES;
    Difference difference = Difference(0.0, 0.0, 0.0);
    if (is_known) {
        difference = difference_of(sum, before);
    }
    vec2 of_tile = given_up(vec2(OF_ONE * difference.of_frame, difference.drift / drift_deviation(sum)));
    vec2 shares = max(of_tile, given_up_by_group(tile));
    float share = max(shares.x, min(shares.y, most_by_drift()));
    float variance = mix(before.g, is_known ? min(deviation, MOST_DEVIATION * max(before.g, LEAST_VARIANCE)) : deviation, max(1.0 / before.a, LEAST_WEIGHT));
    // What the frames before are above a history that has moved towards this one.
    float drift = difference.drift * (1.0 - share);
    imageStore(out_tiles, tile, vec4(now, variance, drift, min(before.a + 1.0, 1e4)));
    imageStore(out_given_up, tile, vec4(share, 0.0, 0.0, 0.0));
}
