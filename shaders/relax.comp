// Tangential relaxation (Eqs. 5, 6): live vertices move towards where the mean value coordinates of the rest pose put
// them among their neighbours, within the plane normal to the field's gradient.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/texels.glsl"
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer list;
layout(set = 0, binding = 1) uniform usamplerBuffer dispatches;
layout(set = 0, binding = 2) uniform usamplerBuffer ring_offsets;
layout(set = 0, binding = 3) uniform usamplerBuffer rings;
layout(set = 0, binding = 4) uniform usamplerBuffer mean_values;
layout(set = 0, binding = 5) uniform samplerBuffer positions;
layout(set = 0, binding = 6) uniform samplerBuffer anchors;
layout(set = 0, binding = 7) uniform samplerBuffer gradients;
layout(set = 0, binding = 8, std430) writeonly buffer Relaxed { vec4 relaxed[]; };
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
    vec3 x = fetch(positions, first + v).xyz, goal = vec3(0.0);
    float sum = 0.0;
    for (uint k = begin; k < end; k++) {
        float w = number(mean_values, k);
        goal += w * fetch(positions, first + word(rings, k)).xyz;
        sum += w;
    }
    vec3 move = goal - sum * x; // the weights sum to 1, or to 0 where a vertex is not to be relaxed
    vec3 g = fetch(gradients, first + v).xyz;
    move -= g * (dot(g, move) / max(dot(g, g), 1e-20));
    float rest = fetch(anchors, first + v).w - 1.0; // |f − iso| − 1
    relaxed[first + v] = vec4(x + max(0.0, 1.0 - rest * rest * rest * rest) * move, 0.0);
}
