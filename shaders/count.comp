// Counts, a workgroup, the listed vertices whose flags match; the compaction that follows needs these counts.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer List { uint list[]; };
layout(set = 0, binding = 1, std430) readonly buffer Dispatches { Dispatch dispatches[]; };
layout(set = 0, binding = 2, std430) readonly buffer Flags { uint flags[]; };
layout(set = 0, binding = 3, std430) writeonly buffer GroupCounts { uint group_count[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint wanted; // low byte of a matching flag
} constants;

shared uint matches;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        matches = 0u;
    }
    barrier();
    uint i = gl_GlobalInvocationID.x;
    if (i < dispatches[constants.dispatch].count && (flags[list[i]] & 0xffu) == constants.wanted) {
        atomicAdd(matches, 1u);
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        group_count[gl_WorkGroupID.x] = matches;
    }
}
