// What passes share that estimate the direct light of something large with shadow rays, a few for each pixel: their images, the
// surface that receives the light, and the two estimates that they write.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/scene.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
layout(set = 0, binding = 3, rgba32f) uniform writeonly image2D out_shadowed;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2D out_unshadowed;
layout(push_constant) uniform Push { uint sample_count; };

// Candidates that each ray is chosen from.
const uint CANDIDATES = 8u;

// Where light arrives, and where shadow rays start, off the surface.
struct Receiver {
    vec3 position;
    vec3 normal;
    vec3 geometric;
    vec3 origin;
};

Receiver receiver_at(uvec2 pixel, float depth) {
    uvec2 normals = texelFetch(normals_image, ivec2(pixel), 0).xy;
    vec3 geometric = unpack_octahedral(normals.y);
    vec3 position = position_from_depth(pixel, depth);
    return Receiver(position, unpack_octahedral(normals.x), geometric, position + geometric * surface_offset(position));
}

// Of the random numbers of a pixel; passes have different salts.
uint seed_of_pixel(uvec2 pixel, uint salt) {
    return hash(pixel.y * image_size().x + pixel.x, sampling_seed() ^ salt);
}

// Radiance per unit albedo that a sample's irradiance stands for.
float share_of_sample() {
    return 1.0 / (PI * float(sample_count));
}

// Writes S and U, and in a 1 where there is a surface.
void write_estimates(uvec2 pixel, float depth, vec3 shadowed, vec3 unshadowed) {
    float surface = depth > 0.0 ? 1.0 : 0.0;
    imageStore(out_shadowed, ivec2(pixel), vec4(shadowed, surface));
    imageStore(out_unshadowed, ivec2(pixel), vec4(unshadowed, surface));
}
