// One Laplacian smoothing step at and around contacts (Eq. 7). Vertices of valence 3 and less stay.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer List { uint list[]; };
layout(set = 0, binding = 1, std430) readonly buffer Dispatches { Dispatch dispatches[]; };
layout(set = 0, binding = 2, std430) readonly buffer RingOffsets { uint ring_offset[]; };
layout(set = 0, binding = 3, std430) readonly buffer Rings { uint ring[]; };
layout(set = 0, binding = 4, std430) readonly buffer Betas { float beta[]; };
layout(set = 0, binding = 5, std430) readonly buffer Starts { vec4 start[]; };
layout(set = 0, binding = 6, std430) writeonly buffer Smoothed { vec4 smoothed[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
} constants;

void main() {
    if (gl_GlobalInvocationID.x >= dispatches[constants.dispatch].count) {
        return;
    }
    uint v = list[gl_GlobalInvocationID.x];
    uint begin = ring_offset[v], end = ring_offset[v + 1u];
    vec4 x = start[v];
    vec3 sum = vec3(0.0);
    for (uint k = begin; k < end; k++) {
        sum += start[ring[k]].xyz;
    }
    if (end - begin > 3u) {
        x.xyz = mix(x.xyz, sum / float(end - begin), beta[v]);
    }
    smoothed[v] = x;
}
