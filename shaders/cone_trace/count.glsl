// Counting samples: only in programs that are made with COUNT_SAMPLES.

#ifdef COUNT_SAMPLES

layout(std430, binding = 1) buffer samples_block { uint counts[KD_CONE_COUNTERS]; uint pixel_samples[]; };

uint samples_taken = 0u;

void count_cone(uint cone, int samples)
{
    uint at = KD_CONE_HEAD + cone * KD_CONE_WORDS;
    atomicAdd(counts[at], 1u);
    atomicAdd(counts[at + 1u], uint(samples));
    atomicMax(counts[at + 2u], uint(samples));
    samples_taken += uint(samples);
}

// A pixel may be traced twice, one pass after the other.
void count_pixel(ivec2 pixel)
{
    uint at = uint(pixel.y) * gather.size.x + uint(pixel.x), all = pixel_samples[at] + samples_taken;
    pixel_samples[at] = all;
    atomicAdd(counts[0], 1u);
    atomicMax(counts[1], all);
}

#else

void count_cone(uint cone, int samples) {}
void count_pixel(ivec2 pixel) {}

#endif
