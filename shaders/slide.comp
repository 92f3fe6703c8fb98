// An iteration of tracking without its Newton step: the relaxation alone, beside the gradient of the last evaluation. The field
// is what costs, and a vertex hardly leaves its tangent plane in a few iterations.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/newton.glsl"
#include "shared/texels.glsl"
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer list;
layout(set = 0, binding = 1) uniform usamplerBuffer dispatches;
layout(set = 0, binding = 2) uniform usamplerBuffer ring_offsets;
layout(set = 0, binding = 3) uniform usamplerBuffer rings;
layout(set = 0, binding = 4) uniform usamplerBuffer ring_weights;
layout(set = 0, binding = 5) uniform samplerBuffer bodies; // iso-value, radius, freedom, rank of the seed or -1
layout(set = 0, binding = 6) uniform samplerBuffer goals; // w: pace
layout(set = 0, binding = 7) uniform samplerBuffer starts;
layout(set = 0, binding = 8) uniform samplerBuffer befores; // one iteration ago
layout(set = 0, binding = 9) uniform samplerBuffer slopes; // gradients of the last evaluation; 0 where there was none
layout(set = 0, binding = 10) uniform samplerBuffer field_poses;
layout(set = 0, binding = 11, std430) writeonly buffer Tracks { vec4 tracks[]; }; // w: movement over the radius
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint vertices; // welded
    uint fields; // that a part has room for
    float omega; // of the semi-iteration, 1 for none of it
} constants;

#include "shared/relaxation.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= list_count(dispatches, constants.dispatch)) {
        return;
    }
    uint first = part(constants.vertices), v = word(list, first + gl_GlobalInvocationID.x);
    vec4 body = fetch(bodies, v);
    float radius = body.y * fetch(field_poses, part(FIELD_HEAD + FIELD_TEXELS * constants.fields) + BOX_SCALE).w;
    vec3 slope = fetch(slopes, first + v).xyz;
    vec3 normal = slope / max(length(slope), 1e-20);
    vec4 goal = fetch(goals, first + v);
    vec3 y = relaxed(v, goal, normal, body.z, constants.omega, radius);
    tracks[first + v] = vec4(y, length(y - fetch(starts, first + v).xyz) / radius);
}
