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
float ray_offset() { return frame.ray_offset; }
float scene_radius() { return frame.scene_radius; }

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
