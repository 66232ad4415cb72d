// Values of a view as a picture. One thread per pixel.
#include "common/frame.glsl"
#include "common/srgb.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
// Rust: passes::debug_view::Coding.
const uint LINEAR_COLOR = 0u;
const uint DIRECTION = 1u;
const uint MAPPED = 2u;
layout(constant_id = 0) const uint CODING = LINEAR_COLOR;
layout(set = 0, binding = 1) uniform texture2D values_image;
// scale[0]: the value at the upper end of the colour map; its lower end is 0.
layout(set = 0, binding = 2, std430) readonly buffer Scale { float scale[]; };
layout(set = 0, binding = 3, rgba8) uniform writeonly image2D out_picture;
// sRGB colours 0xRRGGBB: of pixels without a value (a < 0), then `count` from the lower end to the upper.
layout(push_constant) uniform Push { uint count; uint none; uint colors[MAX_LEVEL + 1u]; };

vec3 mapped(float value) {
    float at = clamp(value / max(scale[0], 1e-20), 0.0, 1.0) * float(count - 1u);
    uint below = min(uint(at), count - 2u);
    return mix(unpack_color(colors[below]), unpack_color(colors[below + 1u]), at - float(below));
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    vec4 values = texelFetch(values_image, ivec2(pixel), 0);
    vec3 color = unpack_color(none);
    if (values.a >= 0.0) {
        color = CODING == MAPPED ? mapped(values.a) : CODING == DIRECTION ? values.rgb * 0.5 + 0.5 : srgb_encode(values.rgb);
    }
    imageStore(out_picture, ivec2(pixel), vec4(color, 1.0));
}
