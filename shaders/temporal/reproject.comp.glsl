// What the frame before had of each pixel's surface: a bilinear mean over the pixels there that show the same surface.
// Nothing where it was outside the picture, hidden, or where there was no frame before. One thread per pixel.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
// From the pixel to where its surface was, in pixels, and near / view z there.
layout(set = 0, binding = 3) uniform texture2D motion_image;
layout(set = 0, binding = 4) uniform texture2D previous_depth;
layout(set = 0, binding = 5) uniform utexture2D previous_normals;
// The histories as the frame before left them (temporal/blend).
layout(set = 0, binding = 6) uniform texture2D previous_shadowed;
layout(set = 0, binding = 7) uniform texture2D previous_unshadowed;
layout(set = 0, binding = 8, rgba32f) uniform writeonly image2D out_shadowed;
layout(set = 0, binding = 9, rgba32f) uniform writeonly image2D out_unshadowed;
#ifdef KEEPS_LIGHTING
layout(set = 0, binding = 10) uniform texture2D previous_lighting;
layout(set = 0, binding = 11, rgba32f) uniform writeonly image2D out_lighting;
#endif

// Cosine of the angle between normals beyond which surfaces are different ones: 25 degrees.
const float LEAST_COSINE = 0.90630779;
// How far from the plane of the surface that is looked for another one may lie, in edges of a pixel there.
const float PLANE_FOOTPRINTS = 2.0;
// Bilinear weight that pixels of the same surface have at least together.
const float LEAST_WEIGHT = 0.01;

// What is looked for in the frame before.
struct Sought {
    vec3 position_ws;
    vec3 plane_normal;
    vec3 normal;
    float reach;
};

struct Histories {
    vec4 shadowed;
    vec4 unshadowed;
    vec4 lighting;
    float weight;
};

bool is_inside(ivec2 p) { return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, ivec2(image_size()))); }

// World position in the frame before of what was seen at a place, counted in pixels from the centre of the first one.
vec3 previous_position(vec2 at, float depth) {
    vec2 ndc = (at + 0.5) / vec2(image_size()) * 2.0 - 1.0;
    vec3 ray = frame.previous_forward_ws + ndc.x * frame.previous_right_ws - ndc.y * frame.previous_up_ws;
    return frame.previous_eye_ws + ray * (frame.previous_near / depth);
}

bool shows(ivec2 p, Sought sought) {
    float depth = is_inside(p) ? texelFetch(previous_depth, p, 0).x : 0.0;
    if (depth <= 0.0) {
        return false;
    }
    vec3 offset = previous_position(vec2(p) + frame.previous_jitter_px, depth) - sought.position_ws;
    vec3 normal = unpack_octahedral(texelFetch(previous_normals, p, 0).x);
    return dot(normal, sought.normal) >= LEAST_COSINE && abs(dot(offset, sought.plane_normal)) <= sought.reach;
}

void add(inout Histories sum, ivec2 p, float weight) {
    sum.shadowed += weight * texelFetch(previous_shadowed, p, 0);
    sum.unshadowed += weight * texelFetch(previous_unshadowed, p, 0);
#ifdef KEEPS_LIGHTING
    sum.lighting += weight * texelFetch(previous_lighting, p, 0);
#endif
    sum.weight += weight;
}

// The sum over the four pixels around a place that show what is sought.
Histories gather(vec2 at, Sought sought) {
    Histories sum = Histories(vec4(0.0), vec4(0.0), vec4(0.0), 0.0);
    ivec2 first = ivec2(floor(at));
    vec2 share = at - floor(at);
    for (int i = 0; i < 4; ++i) {
        ivec2 corner = ivec2(i & 1, i >> 1);
        vec2 along = mix(1.0 - share, share, vec2(corner));
        float weight = along.x * along.y;
        if (weight > 0.0 && shows(first + corner, sought)) {
            add(sum, first + corner, weight);
        }
    }
    return sum;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!is_inside(pixel)) {
        return;
    }
    Histories found = Histories(vec4(0.0), vec4(0.0), vec4(0.0), 0.0);
    vec3 motion = texelFetch(motion_image, pixel, 0).xyz;
    vec2 at = vec2(pixel) + motion.xy;
    // Also false for what is not a number.
    bool is_near = all(greaterThan(at, vec2(-1.0))) && all(lessThan(at, vec2(image_size())));
    if (frame.history_is_valid != 0u && motion.z > 0.0 && is_near) {
        uvec2 normals = texelFetch(normals_image, pixel, 0).xy;
        float footprint = 2.0 * length(frame.previous_up_ws) / float(image_size().y) * frame.previous_near / motion.z;
        // Where frames sample their pixels tells where their surfaces are, but pixels keep their history: what is at rest stays.
        vec3 position_ws = previous_position(at + pixel_jitter(), motion.z);
        Sought sought = Sought(position_ws, unpack_octahedral(normals.y), unpack_octahedral(normals.x),
                               PLANE_FOOTPRINTS * footprint);
        found = gather(at, sought);
    }
    float scale = found.weight >= LEAST_WEIGHT ? 1.0 / found.weight : 0.0;
    imageStore(out_shadowed, pixel, found.shadowed * scale);
    imageStore(out_unshadowed, pixel, found.unshadowed * scale);
#ifdef KEEPS_LIGHTING
    imageStore(out_lighting, pixel, found.lighting * scale);
#endif
}
