// Decides whether a step of tracking is done again in two halves: where it left more faults than the mesh has at rest. Writes
// the workgroups of the pass that begins a half, or none.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
layout(local_size_x = 1) in;

layout(set = 0, binding = 0, std430) readonly buffer Faults { uint faults[]; };
layout(set = 0, binding = 1, std430) buffer Dispatches { Dispatch dispatches[]; };
layout(push_constant) uniform Constants {
    uint redo; // row of the halves' head; its count is the number of faults at rest
    uint vertices; // welded
    uint allowed; // faults more than at rest
} constants;

void main() {
    bool again = faults[0] > dispatches[constants.redo].count + constants.allowed;
    dispatches[constants.redo].x = again ? (constants.vertices + 63u) / 64u : 0u;
}
