// Direct light of surfaces that shine by themselves: some shadow rays per pixel. Each goes to one of several points drawn by
// how much the surfaces shine; the choice among them is by what they would bring without shadow (resampled importance sampling,
// Talbot et al. 2005). Writes the shadowed and the unshadowed estimate S and U of the radiance per unit albedo, and in a 1 where
// there is a surface. One thread per pixel.
#include "common/light_estimates.glsl"
#include "common/emitters.glsl"

// A point and what it brings without shadow: an estimate of the irradiance from all of them.
struct Chosen {
    EmitterPoint point;
    vec3 irradiance;
};

// Chooses one of the candidates numbered from `first` on in the pixel's sequence.
Chosen choose_point(Receiver receiver, uint first, uint sequence_seed, inout uint random_state) {
    Chosen chosen = Chosen(EmitterPoint(vec3(0.0), vec3(0.0), 1.0, vec3(0.0), 1.0), vec3(0.0));
    float sum = 0.0;
    for (uint i = 0u; i < CANDIDATES; ++i) {
        EmitterPoint point = sample_emitter(r2_sequence(first + i, sequence_seed));
        float pick = random(random_state);
        vec3 irradiance = unshadowed_irradiance_from(point, receiver.position, receiver.normal, receiver.geometric);
        float brings = luminance(irradiance);
        sum += brings;
        if (brings > 0.0 && pick * sum < brings) {
            chosen = Chosen(point, irradiance / brings);
        }
    }
    chosen.irradiance *= sum / float(CANDIDATES);
    return chosen;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).x;
    vec3 shadowed = vec3(0.0);
    vec3 unshadowed = vec3(0.0);
    if (depth > 0.0 && has_emitters()) {
        Receiver receiver = receiver_at(pixel, depth);
        uint sequence_seed = seed_of_pixel(pixel, 0x3c6ef372u);
        uint random_state = hash(sequence_seed);
        float share = share_of_sample();
        for (uint i = 0u; i < sample_count; ++i) {
            Chosen chosen = choose_point(receiver, i * CANDIDATES, sequence_seed, random_state);
            if (any(greaterThan(chosen.irradiance, vec3(0.0)))) {
                unshadowed += share * chosen.irradiance;
                shadowed += is_emitter_blocked(chosen.point, receiver.origin) ? vec3(0.0) : share * chosen.irradiance;
            }
        }
    }
    write_estimates(pixel, depth, shadowed, unshadowed);
}
