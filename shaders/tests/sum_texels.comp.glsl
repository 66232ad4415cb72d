// Sums the texels of every level of an image, each times 1 + x + 3 y + 7 z, z being the layer or the slice.
#extension GL_EXT_samplerless_texture_functions : require
layout(local_size_x = 1) in;

#if defined(LAYERS)
layout(set = 0, binding = 0) uniform utexture2DArray texels;
#elif defined(VOLUME)
layout(set = 0, binding = 0) uniform utexture3D texels;
#else
layout(set = 0, binding = 0) uniform utexture2D texels;
#endif
layout(set = 0, binding = 1, std430) writeonly buffer Sums { uint sums[]; };

void main() {
    for (int level = 0; level < textureQueryLevels(texels); level++) {
#if defined(LAYERS) || defined(VOLUME)
        ivec3 size = textureSize(texels, level);
#else
        ivec3 size = ivec3(textureSize(texels, level), 1);
#endif
        uint sum = 0u;
        for (int i = 0; i < size.x * size.y * size.z; i++) {
            ivec3 place = ivec3(i % size.x, i / size.x % size.y, i / (size.x * size.y));
#if defined(LAYERS) || defined(VOLUME)
            uint value = texelFetch(texels, place, level).x;
#else
            uint value = texelFetch(texels, place.xy, level).x;
#endif
            sum += value * uint(1 + place.x + 3 * place.y + 7 * place.z);
        }
        sums[level] = sum;
    }
}
