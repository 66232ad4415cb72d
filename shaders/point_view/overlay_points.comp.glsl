// Points over the dimmed surfaces, each in the colour of its number; from above also the camera and what it has in view. One
// thread per pixel.
#include "common/frame.glsl"
#include "common/srgb.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D values_image;
layout(set = 0, binding = 2) uniform texture2D albedo_image;
layout(set = 0, binding = 3) uniform utexture2D normals_image;
layout(set = 0, binding = 4) uniform texture2D depth_image;
layout(set = 0, binding = 5, rgba8) uniform writeonly image2D out_picture;
layout(set = 0, binding = 6, std430) readonly buffer ShownBounds { uint shown_bounds[4]; };
#include "point_view/from_above.glsl"
// sRGB colours 0xRRGGBB: of pixels that show nothing, then of each number.
layout(push_constant) uniform Push { uint count; uint none; uint colors[MAX_LEVEL + 1u]; };
layout(constant_id = 0) const uint FROM_ABOVE = 0u;

// Part of the light that surfaces keep behind the points.
const float SURFACE_DIM = 0.35;
const vec3 CAMERA_COLOR = vec3(1.0);
// Half the width of the lines of the view, and radius of the eye, pixels.
const float LINE_PX = 0.8;
const float EYE_PX = 3.5;

// A surface lit from the eye.
vec3 dimmed_surface(uvec2 pixel, float depth) {
    vec3 normal = unpack_octahedral(texelFetch(normals_image, ivec2(pixel), 0).x);
    vec3 towards_eye = normalize(frame.eye_ws - position_from_depth(pixel, depth));
    vec3 albedo = texelFetch(albedo_image, ivec2(pixel), 0).rgb;
    return srgb_encode(SURFACE_DIM * (0.2 + 0.8 * abs(dot(normal, towards_eye))) * (0.1 + 0.9 * albedo));
}

// Whether a pixel lies on one of the two lines from the eye along the sides of the view, or at the eye.
bool is_of_camera(vec2 place) {
    vec2 offset = place - pixel_from_above(frame.eye_ws);
    bool is_line = false;
    for (int side = -1; side <= 1; side += 2) {
        vec2 along = (frame.forward_ws + float(side) * frame.right_ws).xz;
        float way = dot(along, along);
        vec2 across = vec2(-along.y, along.x) * inversesqrt(max(way, 1e-20));
        is_line = is_line || (way > 1e-12 && dot(offset, along) > 0.0 && abs(dot(offset, across)) < LINE_PX);
    }
    return is_line || length(offset) < EYE_PX;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    vec4 values = texelFetch(values_image, ivec2(pixel), 0);
    float depth = texelFetch(depth_image, ivec2(pixel), 0).x;
    vec3 color = unpack_color(none);
    if (values.z > 0.0) {
        color = unpack_color(colors[min(uint(values.x), count - 1u)]);
    } else if (FROM_ABOVE == 0u && depth > 0.0) {
        color = dimmed_surface(pixel, depth);
    }
    if (FROM_ABOVE != 0u && is_of_camera(vec2(pixel) + 0.5)) {
        color = CAMERA_COLOR;
    }
    imageStore(out_picture, ivec2(pixel), vec4(color, 1.0));
}
