// One iteration of tracking (2014, section 5.2): a relaxation step within the tangent plane, then a damped Newton step towards
// the iso-value.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRST_FIELD_BINDING 12
#include "shared/field.glsl"
#include "shared/newton.glsl"
#include "shared/set.glsl"
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
layout(set = 0, binding = 9) uniform samplerBuffer slopes; // gradients of the last iteration; 0 where there was none
layout(set = 0, binding = 10, std430) writeonly buffer Tracks { vec4 tracks[]; }; // w: movement over the radius
layout(set = 0, binding = 11, std430) writeonly buffer Gradients { vec4 gradients[]; }; // w: field
layout(set = 0, binding = 18, std430) buffer LiveSet { uint live_set[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint vertices; // welded
    uint fields; // that a part has room for
    uint enter; // 1: those that still move enter the set for the next list, with their neighbours
    float omega; // of the semi-iteration, 1 for none of it
    float sigma; // share of the Newton step
    float stillness; // movement that counts as rest, over the radius
} constants;

// A pose carries two limbs' skins into each other past the contact sheet between their fields, and the gradient points away from
// the sheet on both sides: each would come to rest on its far side, and the skins would have changed places. So what is inside a
// sheet and has its gradient turned goes on past the sheet.
const float RETURN = 2.0; // share of the Newton step

#include "shared/relaxation.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= list_count(dispatches, constants.dispatch)) {
        return;
    }
    find_fields(constants.fields);
    uint first = part(constants.vertices), v = word(list, first + gl_GlobalInvocationID.x);
    vec4 body = fetch(bodies, v);
    float radius = body.y * fields.box_scale.w;
    vec3 x = fetch(starts, first + v).xyz, slope = fetch(slopes, first + v).xyz;
    vec3 normal = slope / max(length(slope), 1e-20);
    vec4 goal = fetch(goals, first + v);
    vec3 y = relaxed(v, goal, normal, body.z, constants.omega, radius);

    vec4 sampled = evaluate(y);
    bool crossed = sheet > IN_CONTACT && sampled.x > body.x && dot(slope, sampled.yzw) < 0.0;
    vec3 to = y + goal.w * newton(body.x, sampled, crossed ? RETURN : constants.sigma, radius, LEAP);
    float moved = length(to - x) / radius;
    tracks[first + v] = vec4(to, moved);
    gradients[first + v] = vec4(crossed ? -sampled.yzw : sampled.yzw, sampled.x); // that of its own side
    if (constants.enter != 0u && moved > constants.stillness) {
        uint seed = uint(body.w);
        ENTER(live_set, seed);
        uint end = word(ring_offsets, v + 1u);
        for (uint k = word(ring_offsets, v); k < end; k++) {
            float rank = fetch(bodies, word(rings, k)).w;
            if (rank >= 0.0) {
                uint near = uint(rank);
                ENTER(live_set, near);
            }
        }
    }
}
