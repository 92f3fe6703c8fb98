// Moves each contact vertex close to the discontinuity that its last step crossed, by bisection between its anchor and
// where it stopped, and leaves it on the anchor's side.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRST_FIELD_BINDING 6
#include "shared/field.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer list;
layout(set = 0, binding = 1) uniform usamplerBuffer dispatches;
layout(set = 0, binding = 2) uniform samplerBuffer anchors;
layout(set = 0, binding = 3) uniform samplerBuffer gradients;
layout(set = 0, binding = 4) uniform usamplerBuffer iso_values;
layout(set = 0, binding = 5, std430) buffer Positions { vec4 position[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint vertices; // welded
    uint fields; // that a part has room for
    float cos_contact; // cosine of the angle that counts as a discontinuity
} constants;

const uint HALVINGS = 4u; // of a step of a tenth of the radius

void main() {
    if (gl_GlobalInvocationID.x >= list_count(dispatches, constants.dispatch)) {
        return;
    }
    find_fields(constants.fields);
    uint first = part(constants.vertices), v = word(list, first + gl_GlobalInvocationID.x);
    vec4 slope = fetch(gradients, first + v);
    vec4 last = fetch(anchors, first + v);
    vec3 near = last.xyz, far = position[first + v].xyz;
    float off = last.w, field = slope.w, iso = number(iso_values, v);
    for (uint k = 0u; k < HALVINGS; k++) {
        vec3 middle = 0.5 * (near + far);
        vec4 sampled = evaluate(middle);
        vec3 g = sampled.yzw;
        bool turned = dot(g, slope.xyz) < constants.cos_contact * length(g) * length(slope.xyz);
        float distance = abs(sampled.x - iso);
        if (turned || distance > off) {
            far = middle;
        } else {
            near = middle;
            off = distance;
            field = sampled.x;
        }
    }
    position[first + v] = vec4(near, field);
}
