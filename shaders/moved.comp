// Finds the seeds that have to be projected. Where the joints of a vertex and all fields around it move as one, the composed
// field moves with the vertex: it is on its iso-value where its joints carried it.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRST_FIELD_BINDING 12
#include "shared/around.glsl"
#include "shared/set.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer list; // the seeds: all instances share them
layout(set = 0, binding = 1) uniform usamplerBuffer dispatches;
layout(set = 0, binding = 2) uniform samplerBuffer geometric;
layout(set = 0, binding = 3) uniform usamplerBuffer iso_values;
layout(set = 0, binding = 4) uniform samplerBuffer directions; // w: fields around the vertex at rest
layout(set = 0, binding = 5) uniform usamplerBuffer influence_joints;
layout(set = 0, binding = 6) uniform usamplerBuffer influence_weights;
layout(set = 0, binding = 7) uniform samplerBuffer palette;
layout(set = 0, binding = 8) uniform usamplerBuffer seed_ranks;
layout(set = 0, binding = 9, std430) writeonly buffer Positions { vec4 position[]; }; // w: field
layout(set = 0, binding = 10, std430) writeonly buffer Status { uint status[]; };
layout(set = 0, binding = 11, std430) buffer LiveSet { uint live_set[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint vertices; // welded
    uint joints;
    uint fields; // that a part has room for
    uint width; // influences a vertex
} constants;

#include "shared/motion.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= list_count(dispatches, constants.dispatch)) {
        return;
    }
    find_fields(constants.fields);
    uint first = part(constants.vertices), v = word(list, gl_GlobalInvocationID.x);
    vec3 x = fetch(geometric, first + v).xyz;
    // A vertex to be projected has at least one field around it at rest.
    if (fields_moving_as(motions_of(v, constants.width).y, FIRST_CELL, x) == uint(fetch(directions, v).w)) {
        position[first + v] = vec4(x, number(iso_values, v));
        status[first + v] = ON_ISO;
    } else {
        ENTER(live_set, word(seed_ranks, v));
    }
}
