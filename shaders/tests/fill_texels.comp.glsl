// Writes base + x + 10 y + 100 z into every texel of one level of an image, z being the layer or the slice.
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;

layout(push_constant) uniform Push { uint base; };

#if defined(LAYERS)
layout(set = 0, binding = 0, r32ui) uniform writeonly uimage2DArray out_texels;
#elif defined(VOLUME)
layout(set = 0, binding = 0, r32ui) uniform writeonly uimage3D out_texels;
#else
layout(set = 0, binding = 0, r32ui) uniform writeonly uimage2D out_texels;
#endif

void main() {
    ivec3 place = ivec3(gl_GlobalInvocationID);
#if defined(LAYERS) || defined(VOLUME)
    ivec3 size = imageSize(out_texels);
    ivec3 texel = place;
#else
    ivec3 size = ivec3(imageSize(out_texels), 1);
    ivec2 texel = place.xy;
#endif
    if (all(lessThan(place, size))) {
        imageStore(out_texels, texel, uvec4(base + uint(place.x + 10 * place.y + 100 * place.z)));
    }
}
