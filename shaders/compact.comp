// Lists the vertices of a set in the order of the seeds, and writes the list's head: nothing where the instance has had all its
// rounds of iterations.
// Each invocation has eight seeds; where they go follows from the counts and bits before them, so none waits for another.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/set.glsl"
#include "shared/texels.glsl"
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer seeds;
layout(set = 0, binding = 1) uniform usamplerBuffer members;
layout(set = 0, binding = 2, std430) buffer Dispatches { uint heads[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Listed { uint listed[]; };
layout(set = 0, binding = 4) uniform samplerBuffer field_poses;
layout(push_constant) uniform Constants {
    uint result; // row of the list's head
    uint vertices; // welded
    uint fields; // that a part has room for
    uint round; // of iterations, from the frame's beginning on
} constants;

void main() {
    uint i = gl_GlobalInvocationID.x, last = set_blocks(constants.vertices) * 128u - 1u;
    uint block = i >> 7, shift = 8u * (i & 3u), first = set_part(constants.vertices);
    bool over = float(constants.round) > fetch(field_poses, part(FIELD_HEAD + FIELD_TEXELS * constants.fields) + TURN).x;
    uint here = set_word(8u * i), bits = i <= last && !over ? word(members, first + here) : 0u;
    uint mine = (bits >> shift) & 0xffu;
    if (mine == 0u && i != last) {
        return;
    }
    uint at = bitCount(bits & ((1u << shift) - 1u));
    for (uint b = 0u; b < block; b++) {
        at += word(members, first + SET_BLOCK * b + 32u);
    }
    for (uint w = SET_BLOCK * block; w < here; w++) {
        at += bitCount(word(members, first + w));
    }
    while (mine != 0u) {
        listed[part(constants.vertices) + at] = word(seeds, 8u * i + uint(findLSB(mine)));
        mine &= mine - 1u;
        at++;
    }
    if (i == last) {
        uint count = over ? 0u : at, groups = (count + 63u) / 64u;
        heads[count_at(constants.result)] = count;
        if (gl_NumWorkGroups.y == 1u) {
            heads[head_of(constants.result)] = groups;
        } else {
            atomicMax(heads[head_of(constants.result)], groups); // the same in any order
        }
    }
}
