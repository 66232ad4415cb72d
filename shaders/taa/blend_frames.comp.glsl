// Temporal anti-aliasing: the mean over the frames so far, each sampled elsewhere in its pixels, which follows what moves
// (Karis 2014). What the frames before have is clipped to the colours around the pixel (Salvi 2016), so that nothing stays
// behind where something else has come into sight. One thread per pixel.
#include "common/frame.glsl"
#include "common/color.glsl"
#include "common/seen_at.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D radiance_image;
layout(set = 0, binding = 2) uniform texture2D depth_image;
// From the pixel to where its surface was, in pixels, and near / view z there.
layout(set = 0, binding = 3) uniform texture2D motion_image;
// The picture of the frame before; a is the number of frames in it, below 0 where something moved.
layout(set = 0, binding = 4) uniform texture2D previous_antialiased;
layout(set = 0, binding = 5, std430) readonly buffer Exposure { float exposure[]; };
layout(set = 0, binding = 6, rgba32f) uniform writeonly image2D out_antialiased;

// A frame weighs at least this much where something moves, and where nothing does.
const float LEAST_WEIGHT = 0.1;
const float LEAST_WEIGHT_AT_REST = 0.04;
// How far from the mean of the colours around a pixel its history may lie, in their standard deviations.
const float MOST_DEVIATIONS = 1.25;
// How far a history outside is moved there in a frame where nothing moves: what is smaller than a pixel shows in some frames
// only, and would flicker. Shadows that move stay for a few frames.
const float CLIP_AT_REST = 0.25;
// Deviations that are smaller are rounding: far below one step of a display.
const float LEAST_DEVIATION = 1e-5;

bool is_inside(ivec2 p) { return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, ivec2(image_size()))); }

ivec2 nearest_inside(ivec2 p) { return clamp(p, ivec2(0), ivec2(image_size()) - 1); }

vec3 radiance_at(ivec2 p) { return texelFetch(radiance_image, nearest_inside(p), 0).rgb; }

// What lies behind all surfaces is infinitely far away: only turns of the camera move it. z: above 0 where it was before the
// camera.
vec3 background_motion(ivec2 pixel) {
    vec3 direction = ray_through((vec2(pixel) + 0.5) / vec2(image_size()) * 2.0 - 1.0);
    vec3 before = seen_before(direction);
    return vec3(before.xy - seen_now(direction).xy, before.z);
}

// Motion of the nearest surface in the 3x3 pixels around: edges move with what is in front, whichever side of them a frame
// has sampled.
vec3 nearest_motion(ivec2 pixel) {
    ivec2 nearest = pixel;
    float greatest = 0.0;
    for (int i = 0; i < 9; ++i) {
        ivec2 p = nearest_inside(pixel + ivec2(i % 3, i / 3) - 1);
        float depth = texelFetch(depth_image, p, 0).x;
        if (depth > greatest) {
            nearest = p;
            greatest = depth;
        }
    }
    return greatest > 0.0 ? texelFetch(motion_image, nearest, 0).xyz : background_motion(pixel);
}

// Weights of four texels in a row for a place between the second and the third (Catmull and Rom 1974).
vec4 sharp_weights(float f) {
    return vec4(f * (-0.5 + f * (1.0 - 0.5 * f)), 1.0 + f * f * (-2.5 + 1.5 * f), f * (0.5 + f * (2.0 - 1.5 * f)),
                f * f * (-0.5 + 0.5 * f));
}

// The picture of the frame before at a place, counted in pixels from the centre of the first one.
vec3 history_at(vec2 at) {
    ivec2 first = ivec2(floor(at)) - 1;
    vec2 share = at - floor(at);
    vec4 across = sharp_weights(share.x);
    vec4 down = sharp_weights(share.y);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 16; ++i) {
        float weight = across[i & 3] * down[i >> 2];
        // At rest a single texel counts.
        if (weight != 0.0) {
            sum += weight * texelFetch(previous_antialiased, nearest_inside(first + ivec2(i & 3, i >> 2)), 0).rgb;
        }
    }
    return max(sum, 0.0);
}

// Radiance as it is compared: exposed, with luminances up to 1 however bright it is, as luma and two differences of colour
// (YCoCg).
vec3 comparable(vec3 radiance) {
    vec3 exposed = radiance * exposure[0];
    vec3 c = exposed / (1.0 + luminance(exposed));
    return vec3(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * (c.r - c.b), 0.5 * c.g - 0.25 * (c.r + c.b));
}

vec3 radiance_of(vec3 compared) {
    float rest = compared.x - compared.z;
    vec3 c = vec3(rest + compared.y, compared.x + compared.z, rest - compared.y);
    return max(c / (exposure[0] * max(1.0 - luminance(c), 1e-6)), 0.0);
}

// The history moved towards the mean of the 3x3 pixels around, by a share of the way to where it lies within their deviation.
vec3 clipped(ivec2 pixel, vec3 history, float share) {
    vec3 around[9];
    vec3 mean = vec3(0.0);
    for (int i = 0; i < 9; ++i) {
        around[i] = comparable(radiance_at(pixel + ivec2(i % 3, i / 3) - 1));
        mean += around[i] / 9.0;
    }
    vec3 variance = vec3(0.0);
    for (int i = 0; i < 9; ++i) {
        variance += (around[i] - mean) * (around[i] - mean) / 9.0;
    }
    vec3 offset = comparable(history) - mean;
    vec3 off = abs(offset) / max(MOST_DEVIATIONS * sqrt(variance), LEAST_DEVIATION);
    float most = max(off.x, max(off.y, off.z));
    return most > 1.0 ? radiance_of(mean + offset * mix(1.0, 1.0 / most, share)) : history;
}

// What is brighter than white counts as much less as it is brighter: it would flicker, and no display shows it. Of all else
// the mean is plain.
float display_weight(vec3 radiance) { return 1.0 / max(1.0, luminance(radiance) * exposure[0]); }

vec4 blended(ivec2 pixel, vec3 here, vec2 at) {
    float count = texelFetch(previous_antialiased, nearest_inside(ivec2(floor(at + 0.5))), 0).a;
    bool moves = at != vec2(pixel);
    // What moved in the frame before may have uncovered what stands here.
    bool is_at_rest = !moves && count > 1.0;
    vec3 history = clipped(pixel, history_at(at), is_at_rest ? CLIP_AT_REST : 1.0);
    float weight = max(1.0 / (abs(count) + 1.0), is_at_rest ? LEAST_WEIGHT_AT_REST : LEAST_WEIGHT);
    float of_here = weight * display_weight(here);
    float of_history = (1.0 - weight) * display_weight(history);
    vec3 mean = (of_here * here + of_history * history) / (of_here + of_history);
    // What is not a number must not stay.
    return luminance(mean) < 3e38 ? vec4(mean, moves ? -1.0 / weight : 1.0 / weight) : vec4(here, 1.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!is_inside(pixel)) {
        return;
    }
    vec3 here = radiance_at(pixel);
    vec3 motion = nearest_motion(pixel);
    vec2 at = vec2(pixel) + motion.xy;
    // Also false for what is not a number.
    bool was_inside = all(greaterThanEqual(at, vec2(-0.5))) && all(lessThan(at, vec2(image_size()) - 0.5));
    bool has_history = frame.history_is_valid != 0u && motion.z > 0.0 && was_inside;
    imageStore(out_antialiased, pixel, has_history ? blended(pixel, here, at) : vec4(here, 1.0));
}
