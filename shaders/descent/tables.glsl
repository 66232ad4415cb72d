// Descent tables: per grid light above S1 its parts in the level below and their cumulative luminance. A table is
// DESCENT_STRIDE words: number of parts, then (cumulative luminance, grid light) pairs.

// Table of grid light `index`; `first` is the first light of level 2.
uint descent_table(uint index, uint first) { return (index - first) * DESCENT_STRIDE; }
