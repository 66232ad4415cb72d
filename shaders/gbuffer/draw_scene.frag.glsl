// Writes albedo, shading normal and geometric normal; cut-out texels are discarded, and with CULLS_BACK_FACES backs of single-sided
// surfaces. With FINDS_MOTION also where the surface was in the frame before, with EMISSION what it sends out by itself. One
// invocation per fragment.
#include "common/frame.glsl"
#include "common/octahedral.glsl"

#include "common/material.glsl"

layout(set = 1, binding = 4, std430) readonly buffer Materials { Material materials[]; };
layout(set = 2, binding = 0) uniform sampler2D base_color_texture;
layout(set = 2, binding = 1) uniform sampler2D normal_texture;

#ifdef EMISSION
layout(set = 2, binding = 2) uniform sampler2D emission_texture;
#endif

layout(constant_id = 0) const uint CULLS_BACK_FACES = 0u;
// Only materials without normal maps, vertex colours and cut-outs are drawn.
layout(constant_id = 1) const uint IS_PLAIN = 0u;
layout(push_constant) uniform Push { uint material_index; };

// From the eye to the surface: neighbouring pixels differ by little, which far from the origin a position cannot show.
layout(location = 0) in vec3 from_eye_ws;
layout(location = 1) in vec3 normal_ws;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec4 vertex_color;
// w: the side of the bitangent. All 0 where there is no normal map.
layout(location = 4) in vec4 tangent_ws;

layout(location = 0) out vec4 out_albedo;
// x: shading normal, y: geometric normal, both octahedral, turned towards the viewer.
layout(location = 1) out uvec2 out_normals;
#ifdef FINDS_MOTION
layout(location = 5) in vec3 previous_from_eye_ws;
// xy: from the pixel to where its surface was, in pixels, y down. z: near / view z of that place, 0 where it was not
// before the camera.
layout(location = 2) out vec4 out_motion;

#include "common/seen_at.glsl"

vec4 motion() {
    // The difference of two projections rather than of one and the pixel: what interpolation is wrong by is in both, and
    // what stands still moves by exactly 0.
    vec3 now = seen_now(from_eye_ws);
    vec3 before = seen_before(previous_from_eye_ws);
    return before.z > frame.previous_near ? vec4(before.xy - now.xy, frame.previous_near / before.z, 0.0) : vec4(0.0);
}
#endif

#ifdef EMISSION
// Radiance of the surface itself.
#ifdef FINDS_MOTION
layout(location = 3) out vec4 out_emission;
#else
layout(location = 2) out vec4 out_emission;
#endif
#endif

const float MOST_REPEATS = 4.0;
// Where a texture is read. A pixel across which it repeats several times shows its mean, which is what a step of one
// repetition per pixel gives too. Beside the edge of a triangle seen edge-on, invocations that only help with derivatives
// have coordinates without bounds, for which lavapipe's anisotropic filter takes seconds.
vec2 steady(vec2 at) {
    vec2 along = max(abs(dFdxCoarse(at)), abs(dFdyCoarse(at)));
    return max(along.x, along.y) < MOST_REPEATS ? at : gl_FragCoord.xy;
}

// The base colour. Coordinates that are the same all around, as of a mesh without any, name one texel: there is nothing to
// filter, and the anisotropic filter of Mesa 25's lavapipe divides 0 by 0.
vec4 textured_color(uint flags) {
    vec2 at = steady(uv);
    vec4 color = texture(base_color_texture, at);
    if (abs(dFdxCoarse(at)) + abs(dFdyCoarse(at)) == vec2(0.0)) {
        ivec2 size = textureSize(base_color_texture, 0);
        color = texelFetch(base_color_texture, min(ivec2(wrapped_place(flags, at) * vec2(size)), size - 1), 0);
    }
    return color;
}

// The normal that the normal map gives. MikkTSpace, with which maps are baked, takes the interpolated normal and tangent as
// they are: only the result has unit length. Where `shading` was turned towards the viewer, it is that of the back.
vec3 mapped_normal(vec3 shading, float scale) {
    // Before any invocation returns: the sample takes its derivatives from all four of a quad.
    vec3 sampled = texture(normal_texture, steady(uv)).xyz * 2.0 - 1.0;
    if (tangent_ws.w == 0.0) {
        return shading;
    }
    vec3 bitangent = cross(normal_ws, tangent_ws.xyz) * tangent_ws.w;
    vec3 mapped = scale * (sampled.x * tangent_ws.xyz + sampled.y * bitangent) + sampled.z * normal_ws;
    mapped = dot(shading, normal_ws) < 0.0 ? -mapped : mapped;
    return dot(mapped, mapped) > 0.0 ? normalize(mapped) : shading;
}

#ifdef EMISSION
// A surface shines in front, and behind if it has two sides. One that is unlit has its colour on both.
vec3 emission(Material material, vec3 base_color) {
    if ((material.flags & MATERIAL_UNLIT) != 0u) {
        return base_color;
    }
    vec3 textured = material.emission * texture(emission_texture, steady(uv)).rgb;
    return gl_FrontFacing || (material.flags & MATERIAL_SINGLE_SIDED) == 0u ? textured : vec3(0.0);
}
#endif

void main() {
    Material material = materials[material_index];
    vec4 base_color = material.base_color * textured_color(material.flags);
    if (IS_PLAIN == 0u && (material.flags & MATERIAL_VERTEX_COLORS) != 0u) {
        base_color *= clamp(vertex_color, 0.0, 1.0);
    }
    vec3 geometric = cross(dFdx(from_eye_ws), dFdy(from_eye_ws));
    geometric = dot(geometric, geometric) > 0.0 ? normalize(geometric) : normalize(normal_ws);
    geometric = dot(geometric, from_eye_ws) > 0.0 ? -geometric : geometric;
    vec3 shading = dot(normal_ws, normal_ws) > 0.0 ? normalize(normal_ws) : geometric;
    shading = dot(shading, geometric) < 0.0 ? -shading : shading;
    if (IS_PLAIN == 0u && (material.flags & MATERIAL_NORMAL_MAP) != 0u) {
        shading = mapped_normal(shading, material.normal_scale);
    }
#ifdef EMISSION
    out_emission = vec4(emission(material, base_color.rgb), 1.0);
    // Light changes nothing of what is unlit.
    vec3 albedo = (material.flags & MATERIAL_UNLIT) != 0u ? vec3(0.0) : base_color.rgb;
#else
    vec3 albedo = base_color.rgb;
#endif
    bool is_culled = CULLS_BACK_FACES != 0u && !gl_FrontFacing && (material.flags & MATERIAL_SINGLE_SIDED) != 0u;
    if (IS_PLAIN == 0u && base_color.a < material.alpha_cutoff || is_culled) {
        discard;
    }
    out_albedo = vec4(albedo, 1.0);
#ifdef FINDS_MOTION
    out_motion = motion();
#endif
    out_normals = uvec2(pack_octahedral(shading), pack_octahedral(geometric));
}
