// Direct light of the environment: some shadow rays per pixel. Each goes in one of several candidate directions, of which
// half are drawn by the environment's light and half by the surface's cosine; the choice among them is by what they would
// bring without shadow (resampled importance sampling, Talbot et al. 2005), so that no ray goes where nothing comes from.
// Writes the shadowed and the unshadowed estimate S and U of the radiance per unit albedo, and in a 1 where there is a
// surface. One thread per pixel.
#include "common/light_estimates.glsl"
#include "common/environment.glsl"

layout(set = 0, binding = 5, std430) buffer RayCount { uint ray_count[]; };

// A direction and what it brings without shadow: an estimate of the irradiance from everywhere.
struct Chosen {
    vec3 direction;
    vec3 irradiance;
};

// Chooses one of the candidates numbered from `first` on in the pixel's sequences.
Chosen choose_direction(Receiver receiver, uint first, uint sequence_seed, inout uint random_state) {
    Chosen chosen = Chosen(vec3(0.0), vec3(0.0));
    float sum = 0.0;
    for (uint i = 0u; i < CANDIDATES; ++i) {
        vec2 u = r2_sequence((first + i) / 2u, hash(sequence_seed, i % 2u));
        vec3 direction = mixed_direction(receiver.normal, u, i % 2u == 0u);
        float cosine = dot(direction, receiver.normal);
        float pick = random(random_state);
        vec3 irradiance = environment_radiance(direction) * cosine;
        float brings = luminance(irradiance);
        if (cosine <= 0.0 || dot(direction, receiver.geometric) <= 0.0 || brings <= 0.0) {
            continue;
        }
        float weight = brings / mixed_density(direction, cosine);
        sum += weight;
        if (pick * sum < weight) {
            chosen = Chosen(direction, irradiance / brings);
        }
    }
    chosen.irradiance *= sum / float(CANDIDATES);
    return chosen;
}

shared uint rays_of_group;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        rays_of_group = 0u;
    }
    barrier();
    uvec2 pixel = gl_GlobalInvocationID.xy;
    bool inside = all(lessThan(pixel, image_size()));
    float depth = inside ? texelFetch(depth_image, ivec2(pixel), 0).x : 0.0;
    vec3 shadowed = vec3(0.0);
    vec3 unshadowed = vec3(0.0);
    uint rays = 0u;
    if (depth > 0.0 && has_environment()) {
        Receiver receiver = receiver_at(pixel, depth);
        uint sequence_seed = seed_of_pixel(pixel, 0x1b873593u);
        uint random_state = hash(sequence_seed);
        float share = share_of_sample();
        for (uint i = 0u; i < sample_count; ++i) {
            Chosen chosen = choose_direction(receiver, i * CANDIDATES, sequence_seed, random_state);
            if (any(greaterThan(chosen.irradiance, vec3(0.0)))) {
                unshadowed += share * chosen.irradiance;
                shadowed += is_open(receiver.origin, chosen.direction) ? share * chosen.irradiance : vec3(0.0);
                ++rays;
            }
        }
    }
    if (inside) {
        write_estimates(pixel, depth, shadowed, unshadowed);
    }
    atomicAdd(rays_of_group, rays);
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        atomicAdd(ray_count[2], rays_of_group);
    }
}
