// Brings the light of the half picture to all pixels: each takes that of the up to four pixels around it that show the same
// surface (joint bilateral upsampling, Kopf et al. 2007). Where none does, as on what is thinner than two pixels, those
// count that resemble it most. One thread per pixel of the whole picture.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "half_picture/size.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
layout(set = 0, binding = 3) uniform texture2D half_depth;
layout(set = 0, binding = 4) uniform utexture2D half_normals;
layout(set = 0, binding = 5) uniform texture2D half_indirect;
layout(set = 0, binding = 6, rgba32f) uniform writeonly image2D out_indirect;

// Distance from the tangent plane, in footprints of a pixel, at which a weight falls to 1/e.
const float PLANE_SIGMA = 2.0;
// Power of the cosine between two normals.
const float NORMAL_POWER = 16.0;
// What a pixel of another surface counts, beside one of the same.
const float OTHER_SURFACE = 1e-4;
// How far around a pixel another is looked for, in pixels of the half picture, where the four around it show nothing.
const int SEARCH = 2;

struct Surface {
    vec3 position_ws;
    vec3 plane_normal;
    vec3 normal;
    float footprint;
};

// How much the surface of a pixel of the half picture resembles another; 0 where it shows none.
float likeness(Surface surface, ivec2 p) {
    bool is_inside = all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, ivec2(half_size())));
    float depth = is_inside ? texelFetch(half_depth, p, 0).x : 0.0;
    if (depth <= 0.0) {
        return 0.0;
    }
    vec3 normal = unpack_octahedral(texelFetch(half_normals, p, 0).x);
    vec3 offset = position_from_depth(uvec2(2 * p), depth) - surface.position_ws;
    float off_plane = dot(offset, surface.plane_normal) / (PLANE_SIGMA * surface.footprint);
    float cosine = max(dot(normal, surface.normal), 0.0);
    return exp(-abs(off_plane)) * pow(cosine, NORMAL_POWER) + OTHER_SURFACE;
}

// Light in rgb, weight in a.
vec4 around(Surface surface, ivec2 pixel) {
    ivec2 first = pixel / 2;
    vec2 share = 0.5 * vec2(pixel % 2);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 corner = ivec2(i & 1, i >> 1);
        vec2 along = mix(1.0 - share, share, vec2(corner));
        float weight = along.x * along.y;
        weight = weight > 0.0 ? weight * likeness(surface, first + corner) : 0.0;
        if (weight > 0.0) {
            sum += weight * vec4(texelFetch(half_indirect, first + corner, 0).rgb, 1.0);
        }
    }
    return sum;
}

// The same from further away.
vec4 further_around(Surface surface, ivec2 pixel) {
    vec4 sum = vec4(0.0);
    for (int y = -SEARCH; y <= SEARCH; ++y) {
        for (int x = -SEARCH; x <= SEARCH; ++x) {
            ivec2 p = pixel / 2 + ivec2(x, y);
            float weight = likeness(surface, p);
            if (weight > 0.0) {
                sum += weight * vec4(texelFetch(half_indirect, p, 0).rgb, 1.0);
            }
        }
    }
    return sum;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(pixel), image_size()))) {
        return;
    }
    float depth = texelFetch(depth_image, pixel, 0).x;
    vec4 sum = vec4(0.0);
    if (depth > 0.0) {
        uvec2 normals = texelFetch(normals_image, pixel, 0).xy;
        float footprint = 2.0 * length(frame.up_ws) / float(image_size().y) * frame.near / depth;
        Surface surface = Surface(position_from_depth(uvec2(pixel), depth), unpack_octahedral(normals.y),
                                  unpack_octahedral(normals.x), footprint);
        sum = around(surface, pixel);
        if (sum.a <= 0.0) {
            sum = further_around(surface, pixel);
        }
    }
    imageStore(out_indirect, pixel, sum.a > 0.0 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0));
}
