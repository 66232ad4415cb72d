// Of the random numbers of a frame's shadow samples, or of a further round of them (ROUND). Needs frame.glsl and random.glsl; with
// ROUND the including shader declares `round_number`, 2 or more.
#ifdef ROUND
// Frames are numbered from 0 on and rounds from 2^31 on, so that no frame has the samples of another one's round.
uint samples_seed() { return hash(sampling_seed(), 0x80000000u + round_number); }
#else
uint samples_seed() { return sampling_seed(); }
#endif
