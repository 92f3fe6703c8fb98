// Decides whether a step of tracking is done again in two halves: where it left more faults than the mesh has at rest. Writes
// the workgroups of the pass that begins a half, or none; they count for every instance.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/texels.glsl"
layout(local_size_x = 1) in;

layout(set = 0, binding = 0, std430) readonly buffer Faults { uint faults[]; };
layout(set = 0, binding = 1) uniform usamplerBuffer seed_dispatches;
layout(set = 0, binding = 2, std430) buffer Dispatches { uint heads[]; };
layout(push_constant) uniform Constants {
    uint redo; // row of the halves' head; of the seeds' heads, its number of items is that of the faults at rest
    uint vertices; // welded
    uint allowed; // faults more than at rest
} constants;

void main() {
    bool again = faults[gl_WorkGroupID.y] > list_count(seed_dispatches, constants.redo) + constants.allowed;
    heads[count_at(constants.redo)] = again ? constants.vertices : 0u;
    if (again) {
        atomicMax(heads[head_of(constants.redo)], (constants.vertices + 63u) / 64u); // 0 before, and the same in any order
    }
}
