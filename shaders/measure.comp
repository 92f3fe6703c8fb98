// The composed field at every vertex of the rest pose: iso-values, the directions of the gradients, and how many fields
// are around it. Instances share them: one is enough.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRST_FIELD_BINDING 3
#include "shared/field.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform samplerBuffer positions;
layout(set = 0, binding = 1, std430) writeonly buffer Values { float value[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Directions { vec4 direction[]; }; // unit, or 0 without a gradient; w: fields
layout(push_constant) uniform Constants {
    uint vertices;
    uint fields; // that a part has room for
} constants;

void main() {
    find_fields(constants.fields);
    uint v = gl_GlobalInvocationID.x;
    if (v < constants.vertices) {
        vec3 x = fetch(positions, v).xyz;
        vec4 sampled = evaluate(x);
        value[v] = sampled.x;
        direction[v] = vec4(sampled.yzw / max(length(sampled.yzw), 1e-20), float(fields_around(x)));
    }
}
