// Marks the neighbourhood of every listed (contact) vertex: where β and the smoothing may act.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer List { uint list[]; };
layout(set = 0, binding = 1, std430) readonly buffer Dispatches { Dispatch dispatches[]; };
layout(set = 0, binding = 2, std430) readonly buffer NeighbourhoodOffsets { uint neighbourhood_offset[]; };
layout(set = 0, binding = 3, std430) readonly buffer Neighbourhoods { uint neighbourhood[]; };
layout(set = 0, binding = 4, std430) buffer Region { uint region[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
} constants;

void main() {
    if (gl_GlobalInvocationID.x >= dispatches[constants.dispatch].count) {
        return;
    }
    uint v = list[gl_GlobalInvocationID.x];
    for (uint k = neighbourhood_offset[v]; k < neighbourhood_offset[v + 1u]; k++) {
        atomicOr(region[neighbourhood[k]], 1u); // several vertices mark one: the same bit in any order
    }
}
