// Copies the listed vertices whose flags match to a new list, in order, and writes that list's head.
// A workgroup's offset is the sum of the counts before it, so no workgroup waits for another.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer List { uint list[]; };
layout(set = 0, binding = 1, std430) buffer Dispatches { Dispatch dispatches[]; };
layout(set = 0, binding = 2, std430) readonly buffer Flags { uint flags[]; };
layout(set = 0, binding = 3, std430) readonly buffer GroupCounts { uint group_count[]; };
layout(set = 0, binding = 4, std430) writeonly buffer Kept { uint kept[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint result; // row of the new list's head
    uint wanted; // low byte of a matching flag
} constants;

shared uint before; // matches in earlier workgroups
shared uint matching[2]; // a bit a lane

void main() {
    uint lane = gl_LocalInvocationIndex, i = gl_GlobalInvocationID.x;
    if (lane == 0u) {
        before = 0u;
        matching[0] = 0u;
        matching[1] = 0u;
    }
    barrier();
    uint sum = 0u;
    for (uint g = lane; g < gl_WorkGroupID.x; g += 64u) {
        sum += group_count[g];
    }
    if (sum != 0u) {
        atomicAdd(before, sum);
    }
    uint v = 0u;
    bool match = i < dispatches[constants.dispatch].count;
    if (match) {
        v = list[i];
        match = (flags[v] & 0xffu) == constants.wanted;
    }
    if (match) {
        atomicOr(matching[lane >> 5], 1u << (lane & 31u));
    }
    barrier();
    uint low = matching[0], high = matching[1];
    if (match) {
        uint mine = (1u << (lane & 31u)) - 1u;
        uint rank = lane < 32u ? bitCount(low & mine) : bitCount(low) + bitCount(high & mine);
        kept[before + rank] = v;
    }
    if (lane == 0u && gl_WorkGroupID.x == gl_NumWorkGroups.x - 1u) {
        uint total = before + bitCount(low) + bitCount(high);
        dispatches[constants.result] = Dispatch((total + 63u) / 64u, 1u, 1u, total);
    }
}
