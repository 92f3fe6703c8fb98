// Lists the vertices of a set in the order of the seeds, and writes the list's head.
// Each invocation has eight seeds; where they go follows from the counts and bits before them, so none waits for another.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/set.glsl"
#include "shared/texels.glsl"
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer seeds;
layout(set = 0, binding = 1) uniform usamplerBuffer members;
layout(set = 0, binding = 2, std430) writeonly buffer Dispatches { Dispatch dispatches[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Listed { uint listed[]; };
layout(push_constant) uniform Constants {
    uint result; // row of the list's head
} constants;

void main() {
    uint i = gl_GlobalInvocationID.x, last = uint(textureSize(members)) / SET_BLOCK * 128u - 1u;
    uint block = i >> 7, shift = 8u * (i & 3u);
    uint here = set_word(8u * i), bits = i <= last ? word(members, here) : 0u;
    uint mine = (bits >> shift) & 0xffu;
    if (mine == 0u && i != last) {
        return;
    }
    uint at = bitCount(bits & ((1u << shift) - 1u));
    for (uint b = 0u; b < block; b++) {
        at += word(members, SET_BLOCK * b + 32u);
    }
    for (uint w = SET_BLOCK * block; w < here; w++) {
        at += bitCount(word(members, w));
    }
    while (mine != 0u) {
        listed[at] = word(seeds, 8u * i + uint(findLSB(mine)));
        mine &= mine - 1u;
        at++;
    }
    if (i == last) {
        dispatches[constants.result] = Dispatch((at + 63u) / 64u, 1u, 1u, at);
    }
}
