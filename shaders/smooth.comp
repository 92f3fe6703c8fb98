// One Laplacian smoothing step at and around contacts (Eq. 7). Vertices of valence 3 and less stay.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/texels.glsl"
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer list;
layout(set = 0, binding = 1) uniform usamplerBuffer dispatches;
layout(set = 0, binding = 2) uniform usamplerBuffer ring_offsets;
layout(set = 0, binding = 3) uniform usamplerBuffer rings;
layout(set = 0, binding = 4) uniform usamplerBuffer betas;
layout(set = 0, binding = 5) uniform samplerBuffer starts;
layout(set = 0, binding = 6, std430) writeonly buffer Smoothed { vec4 smoothed[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint vertices; // welded
} constants;

void main() {
    if (gl_GlobalInvocationID.x >= list_count(dispatches, constants.dispatch)) {
        return;
    }
    uint first = part(constants.vertices), v = word(list, first + gl_GlobalInvocationID.x);
    uint begin = word(ring_offsets, v), end = word(ring_offsets, v + 1u);
    vec4 x = fetch(starts, first + v);
    vec3 sum = vec3(0.0);
    for (uint k = begin; k < end; k++) {
        sum += fetch(starts, first + word(rings, k)).xyz;
    }
    if (end - begin > 3u) {
        x.xyz = mix(x.xyz, sum / float(end - begin), number(betas, first + v));
    }
    smoothed[first + v] = x;
}
