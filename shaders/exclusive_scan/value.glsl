// What is summed: set bits, or with SCAN_VALUES the words themselves. The includer declares `bits`.
#ifdef SCAN_VALUES
uint value_of(uint word) { return bits[word]; }
#else
uint value_of(uint word) { return uint(bitCount(bits[word])); }
#endif
