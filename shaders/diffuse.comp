// One step of the diffusion of β (section 5): the mean of the one-ring. The first step starts from 1 in contact, 0 elsewhere.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer List { uint list[]; };
layout(set = 0, binding = 1, std430) readonly buffer Dispatches { Dispatch dispatches[]; };
layout(set = 0, binding = 2, std430) readonly buffer RingOffsets { uint ring_offset[]; };
layout(set = 0, binding = 3, std430) readonly buffer Rings { uint ring[]; };
layout(set = 0, binding = 4, std430) readonly buffer Status { uint status[]; };
layout(set = 0, binding = 5, std430) readonly buffer Region { uint region[]; };
layout(set = 0, binding = 6, std430) readonly buffer Betas { float beta[]; };
layout(set = 0, binding = 7, std430) writeonly buffer Diffused { float diffused[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint first; // β is the contact state
} constants;

// β of a vertex before this step; 0 outside the marked region, whose β is never written.
float beta_of(uint v) {
    if (constants.first != 0u) {
        return state_of(status[v]) == CONTACT ? 1.0 : 0.0;
    }
    return region[v] != 0u ? beta[v] : 0.0;
}

void main() {
    if (gl_GlobalInvocationID.x >= dispatches[constants.dispatch].count) {
        return;
    }
    uint v = list[gl_GlobalInvocationID.x];
    uint begin = ring_offset[v], end = ring_offset[v + 1u];
    float sum = beta_of(v);
    for (uint k = begin; k < end; k++) {
        sum += beta_of(ring[k]);
    }
    diffused[v] = sum / float(end - begin + 1u);
}
