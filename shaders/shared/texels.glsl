// Reading buffers as texels: vec4 from a samplerBuffer, words from a usamplerBuffer.
//
// Software rasterisers fetch texels for all lanes at once, but load storage buffers lane by lane: a gathered vec4 costs them
// twelve times as much.
#ifndef DERMIS_TEXELS
#define DERMIS_TEXELS
#include "shared/instance.glsl"

vec4 fetch(samplerBuffer texels, uint i) {
    return texelFetch(texels, int(i));
}

uint word(usamplerBuffer words, uint i) {
    return texelFetch(words, int(i)).x;
}

float number(usamplerBuffer words, uint i) {
    return uintBitsToFloat(texelFetch(words, int(i)).x);
}

// This instance's items of the list whose head is this row of the dispatches.
uint list_count(usamplerBuffer dispatches, uint row) {
    return word(dispatches, count_at(row));
}

#endif
