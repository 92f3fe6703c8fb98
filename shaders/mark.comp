// Enters the neighbourhood of every listed (contact) vertex into the region where β and the smoothing may act.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/set.glsl"
#include "shared/texels.glsl"
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer list;
layout(set = 0, binding = 1) uniform usamplerBuffer dispatches;
layout(set = 0, binding = 2) uniform usamplerBuffer neighbourhood_offsets;
// Long, and read for contacts alone: not for the texel buffers of small devices.
layout(set = 0, binding = 3, std430) readonly buffer Neighbourhoods { uint neighbourhood[]; };
layout(set = 0, binding = 4) uniform usamplerBuffer seed_ranks;
layout(set = 0, binding = 5, std430) buffer RegionSet { uint region_set[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint vertices; // welded
} constants;

void main() {
    if (gl_GlobalInvocationID.x >= list_count(dispatches, constants.dispatch)) {
        return;
    }
    uint first = part(constants.vertices), v = word(list, first + gl_GlobalInvocationID.x);
    uint begin = word(neighbourhood_offsets, v), end = word(neighbourhood_offsets, v + 1u);
    for (uint k = begin; k < end; k++) {
        uint seed = word(seed_ranks, neighbourhood[k]);
        if (seed != NO_SEED) {
            ENTER(region_set, seed);
        }
    }
}
