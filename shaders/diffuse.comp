// One step of the diffusion of β (section 5): the mean of the one-ring. The first step starts from 1 in contact, 0 elsewhere.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/texels.glsl"
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer list;
layout(set = 0, binding = 1) uniform usamplerBuffer dispatches;
layout(set = 0, binding = 2) uniform usamplerBuffer ring_offsets;
layout(set = 0, binding = 3) uniform usamplerBuffer rings;
layout(set = 0, binding = 4) uniform usamplerBuffer status;
layout(set = 0, binding = 5) uniform usamplerBuffer betas;
layout(set = 0, binding = 6, std430) writeonly buffer Diffused { float diffused[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint vertices; // welded
    uint first; // β is the contact state
} constants;

// β of an instance's vertex before this step; outside the region it stays 0.
float beta_of(uint v) {
    if (constants.first != 0u) {
        return state_of(word(status, v)) == CONTACT ? 1.0 : 0.0;
    }
    return number(betas, v);
}

void main() {
    if (gl_GlobalInvocationID.x >= list_count(dispatches, constants.dispatch)) {
        return;
    }
    uint first = part(constants.vertices), v = word(list, first + gl_GlobalInvocationID.x);
    uint begin = word(ring_offsets, v), end = word(ring_offsets, v + 1u);
    float sum = beta_of(first + v);
    for (uint k = begin; k < end; k++) {
        sum += beta_of(first + word(rings, k));
    }
    diffused[first + v] = sum / float(end - begin + 1u);
}
