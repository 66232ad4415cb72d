// A material as shaders read it.
#include "shared/Material.glsl"
