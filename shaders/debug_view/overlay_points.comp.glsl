// Points over the dimmed picture of direct light, each coloured by its flux; a little albedo keeps what is in shadow
// recognizable. One thread per pixel.
#include "common/frame.glsl"
#include "tone_map/tone_curves.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
// Flux of the point at a pixel; a is 0 where there is none.
layout(set = 0, binding = 1) uniform texture2D points_image;
layout(set = 0, binding = 2) uniform texture2D direct_image;
layout(set = 0, binding = 3, std430) readonly buffer PointsExposure { float points_exposure[]; };
layout(set = 0, binding = 4, std430) readonly buffer DirectExposure { float direct_exposure[]; };
layout(set = 0, binding = 5) uniform texture2D albedo_image;
layout(set = 0, binding = 6, rgba8) uniform writeonly image2D out_picture;

// Parts of the encoded pictures that remain of direct light and of albedo; and how far above middle grey a common flux lies, so that hues stay strong.
const float DIRECT_DIM = 0.35;
const float ALBEDO_DIM = 0.25;
const float POINT_GAIN = 6.0;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    vec4 point = texelFetch(points_image, ivec2(pixel), 0);
    vec3 direct = texelFetch(direct_image, ivec2(pixel), 0).rgb;
    vec3 albedo = texelFetch(albedo_image, ivec2(pixel), 0).rgb;
    // By a curve of its own: the colours of the points are to be told apart, whatever the picture looks like.
    vec3 dimmed = DIRECT_DIM * tone_mapped(direct, direct_exposure[0], TONE_MAP_REINHARD);
    vec3 background = dimmed + ALBEDO_DIM * srgb_encode(albedo);
    vec3 bright = tone_mapped(point.rgb, POINT_GAIN * points_exposure[0], TONE_MAP_REINHARD);
    vec3 color = point.a > 0.0 ? bright : background;
    imageStore(out_picture, ivec2(pixel), vec4(color, 1.0));
}
