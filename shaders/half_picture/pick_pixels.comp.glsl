// Every second pixel of every second row of the G-buffer, and the constants of a frame that has only these. One thread per
// pixel of the half picture.
#include "common/frame.glsl"
#include "half_picture/size.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
// Holds the constants of the whole picture.
layout(set = 0, binding = 1, std430) buffer HalfFrame { FrameData half_frame; };
layout(set = 0, binding = 2) uniform texture2D depth_image;
layout(set = 0, binding = 3) uniform utexture2D normals_image;
layout(set = 0, binding = 4, r32f) uniform writeonly image2D out_depth;
layout(set = 0, binding = 5, rgba32ui) uniform writeonly uimage2D out_normals;
#ifdef FINDS_MOTION
layout(set = 0, binding = 6) uniform texture2D motion_image;
layout(set = 0, binding = 7, rgba32f) uniform writeonly image2D out_motion;
#endif

// Pixel x of the half picture is seen where pixel 2 x of the whole one is. A width that is odd makes the half picture reach
// past the whole one.
void write_constants() {
    vec2 reach = vec2(2u * half_size()) / vec2(image_size());
    vec2 shift = reach - 1.0;
    half_frame.size_px = half_size();
    half_frame.jitter_x_px = 0.5 * frame.jitter_x_px - 0.25;
    half_frame.jitter_y_px = 0.5 * frame.jitter_y_px - 0.25;
    half_frame.previous_jitter_px = 0.5 * frame.previous_jitter_px - 0.25;
    half_frame.forward_ws = ray_through(shift);
    half_frame.right_ws = reach.x * frame.right_ws;
    half_frame.up_ws = reach.y * frame.up_ws;
    half_frame.previous_forward_ws =
        frame.previous_forward_ws + shift.x * frame.previous_right_ws - shift.y * frame.previous_up_ws;
    half_frame.previous_right_ws = reach.x * frame.previous_right_ws;
    half_frame.previous_up_ws = reach.y * frame.previous_up_ws;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (pixel == uvec2(0u)) {
        write_constants();
    }
    if (any(greaterThanEqual(pixel, half_size()))) {
        return;
    }
    ivec2 at = ivec2(2u * pixel);
    imageStore(out_depth, ivec2(pixel), vec4(texelFetch(depth_image, at, 0).x, 0.0, 0.0, 0.0));
    imageStore(out_normals, ivec2(pixel), uvec4(texelFetch(normals_image, at, 0).xy, 0u, 0u));
#ifdef FINDS_MOTION
    vec4 motion = texelFetch(motion_image, at, 0);
    imageStore(out_motion, ivec2(pixel), vec4(0.5 * motion.xy, motion.zw));
#endif
}
