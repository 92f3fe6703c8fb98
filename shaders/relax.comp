// Tangential relaxation (Eqs. 5, 6): live vertices move towards where the mean value coordinates of the rest pose put
// them among their neighbours, within the plane normal to the field's gradient.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer List { uint list[]; };
layout(set = 0, binding = 1, std430) readonly buffer Dispatches { Dispatch dispatches[]; };
layout(set = 0, binding = 2, std430) readonly buffer RingOffsets { uint ring_offset[]; };
layout(set = 0, binding = 3, std430) readonly buffer Rings { uint ring[]; };
layout(set = 0, binding = 4, std430) readonly buffer MeanValues { float mean_value[]; };
layout(set = 0, binding = 5, std430) readonly buffer Positions { vec4 position[]; };
layout(set = 0, binding = 6, std430) readonly buffer Anchors { vec4 anchor[]; };
layout(set = 0, binding = 7, std430) readonly buffer Gradients { vec4 gradient[]; };
layout(set = 0, binding = 8, std430) writeonly buffer Relaxed { vec4 relaxed[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
} constants;

void main() {
    if (gl_GlobalInvocationID.x >= dispatches[constants.dispatch].count) {
        return;
    }
    uint v = list[gl_GlobalInvocationID.x];
    vec3 x = position[v].xyz, goal = vec3(0.0);
    float sum = 0.0;
    for (uint k = ring_offset[v]; k < ring_offset[v + 1u]; k++) {
        float w = mean_value[k];
        goal += w * position[ring[k]].xyz;
        sum += w;
    }
    vec3 move = goal - sum * x; // the weights sum to 1, or to 0 where a vertex is not to be relaxed
    vec3 g = gradient[v].xyz;
    move -= g * (dot(g, move) / max(dot(g, g), 1e-20));
    float rest = anchor[v].w - 1.0; // |f − iso| − 1
    relaxed[v] = vec4(x + max(0.0, 1.0 - rest * rest * rest * rest) * move, 0.0);
}
