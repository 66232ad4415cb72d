// The frame's constants: set 0, binding 0 of every shader that includes this.
#include "constants.glsl"
#include "shared/FrameData.glsl"

layout(set = 0, binding = 0, std140) uniform Frame { FrameData frame; };

uvec2 image_size() { return frame.size_px; }
uvec2 sub_image_size() { return frame.sub_image_px; }
uint interleave() { return frame.interleave; }
uint shadow_sample_count() { return frame.shadow_samples; }
uint first_shadow_level() { return frame.shadow_from; }
uint first_level() { return frame.first_level; }
uint top_level() { return frame.top_level; }
uint frame_seed() { return frame.seed; }
// Of the random numbers that shadow samples take: another one than frame_seed() only where a mean keeps its VPLs.
uint sampling_seed() { return frame.sampling_seed; }
uint accumulated_frame() { return frame.accumulated_frame; }
// Where in a pixel the frame samples, from its centre, in pixels; y down.
vec2 pixel_jitter() { return vec2(frame.jitter_x_px, frame.jitter_y_px); }
float alpha() { return frame.alpha; }
float clamp_squared() { return frame.clamp_squared; }
float scene_radius() { return frame.scene_radius; }

// Sixteen roundings: what the position of a hit, and the distance at which the next ray meets the same triangle, can be
// wrong by, relative to the numbers that they are computed from.
const float RAY_OFFSET = 1.0 / 1048576.0;

// How far rays stay off the surface at a position. Numbers there are as large as the position's coordinates, and as large
// as the triangle is, whose corners are what a ray is intersected with.
float ray_offset(vec3 position_ws) {
    vec3 size = max(abs(position_ws), vec3(frame.largest_triangle));
    return RAY_OFFSET * max(size.x, max(size.y, size.z));
}

// From the eye through a point of the picture, -1 to 1 from its left and upper edge, at distance 1 along the viewing
// direction.
vec3 ray_through(vec2 ndc) { return frame.forward_ws + ndc.x * frame.right_ws - ndc.y * frame.up_ws; }

// Where a position lies in the picture, by way of its offset from the eye: far from the origin that difference is exact,
// where a product with the whole matrix would lose its digits to the translation.
vec4 clip_position(vec3 position_ws) {
    vec4 clip = frame.clip_from_world * vec4(position_ws - frame.eye_ws, 0.0);
    // Reversed depth is near / view z.
    clip.z = frame.near;
    return clip;
}

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
