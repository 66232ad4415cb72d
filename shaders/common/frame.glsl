// The frame's constants: set 0, binding 0 of every shader that includes this. Rust: shared::FrameData.
#include "constants.glsl"

layout(set = 0, binding = 0, std140) uniform FrameData {
    mat4 clip_from_world;
    vec4 eye_near;
    vec4 forward;
    vec4 right;
    vec4 up;
    vec4 scene_sphere;
    uvec4 size;
    uvec4 sampling;
    uvec4 counts;
    uvec4 lights;
    vec4 tuning;
    uvec4 accumulation;
    uvec4 levels[MAX_LEVEL + 2u];
} frame;

uvec2 image_size() { return frame.size.xy; }
uvec2 sub_image_size() { return frame.size.zw; }
uint interleave() { return frame.sampling.x; }
uint shadow_sample_count() { return frame.sampling.y; }
uint first_shadow_level() { return frame.sampling.z; }
uint first_level() { return frame.sampling.w; }
uint top_level() { return frame.counts.x; }
uint frame_seed() { return frame.lights.x; }
// Of the random numbers that shadow samples take: another one than frame_seed() only where a mean keeps its VPLs.
uint sampling_seed() { return frame.accumulation.y; }
uint accumulated_frame() { return frame.accumulation.x; }
// Where in a pixel the frame samples, from its centre, in pixels; y down.
vec2 pixel_jitter() { return vec2(frame.forward.w, frame.up.w); }
float alpha() { return frame.tuning.x; }
float clamp_squared() { return frame.tuning.y; }
float ray_offset() { return frame.tuning.w; }
float scene_radius() { return frame.scene_sphere.w; }

// Where pixel (x, y) of the picture lies in the interleaved layout: n x n sub-images side by side, sub-image
// (i, j) holding the pixels with x % n == i and y % n == j. The identity when n is 1.
uvec2 interleaved_from_pixel(uvec2 pixel) {
    uint n = interleave();
    return (pixel % n) * sub_image_size() + pixel / n;
}

uvec2 pixel_from_interleaved(uvec2 position) {
    uvec2 sub_image = position / sub_image_size();
    return (position % sub_image_size()) * interleave() + sub_image;
}

// Index of a pixel's reservoirs and counters, in the interleaved layout.
uint reservoir_index(uvec2 position) {
    return position.y * (sub_image_size().x * interleave()) + position.x;
}
