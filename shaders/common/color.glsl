// Rec. 709 luminance of linear RGB.
// Precise, as several shaders sum it and their sums are to be the same to the bit.
float luminance(vec3 color) {
    precise float sum = dot(color, vec3(0.2126, 0.7152, 0.0722));
    return sum;
}
