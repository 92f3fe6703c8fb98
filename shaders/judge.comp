// Counts the faults of a step of tracking. A vertex that went further than half its radius from where its joint carried it may
// have been projected to the far side of another part. One with a triangle whose normal faces along the gradient, which points
// inward, is folded over; off its iso-value or without a clear gradient it is in contact, where sheets lie on each other, and
// does not count.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/texels.glsl"
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer list; // the seeds: all instances share them
layout(set = 0, binding = 1) uniform usamplerBuffer dispatches;
layout(set = 0, binding = 2) uniform usamplerBuffer corner_offsets;
layout(set = 0, binding = 3) uniform usamplerBuffer corners;
layout(set = 0, binding = 4) uniform samplerBuffer bodies; // iso-value, radius, freedom, rank of the seed or -1
layout(set = 0, binding = 5) uniform samplerBuffer tracks;
layout(set = 0, binding = 6) uniform samplerBuffer slopes; // w: field, where it was evaluated in this step
layout(set = 0, binding = 7) uniform samplerBuffer field_poses;
layout(set = 0, binding = 8) uniform samplerBuffer tracked; // before the step
layout(set = 0, binding = 9) uniform samplerBuffer vertices;
layout(set = 0, binding = 10) uniform samplerBuffer palette;
layout(set = 0, binding = 11, std430) buffer Faults { uint faults[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint vertices; // welded
    uint joints;
    uint fields; // that a part has room for
} constants;

const float ON = 5e-3; // |f − iso| of a vertex that is on its iso-value
const float CLEAR = 0.3; // |∇f| r of a clear gradient
const float INVERTED = 0.5; // cosine between a triangle's normal and the gradient
const float FAR = 0.5; // way over the radius that may lead through another part

#include "shared/carry.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= list_count(dispatches, constants.dispatch)) {
        return;
    }
    uint first = part(constants.vertices), v = word(list, gl_GlobalInvocationID.x);
    uint head = part(FIELD_HEAD + FIELD_TEXELS * constants.fields);
    if (fetch(field_poses, head + TURN).z == 0.0) {
        return; // another instance's step is that large
    }
    vec4 body = fetch(bodies, v), slope = fetch(slopes, first + v);
    float radius = body.y * fetch(field_poses, head + BOX_SCALE).w, steep = length(slope.xyz);
    vec3 x = fetch(tracks, first + v).xyz;
    bool inverted = false;
    uint end = word(corner_offsets, v + 1u);
    for (uint k = word(corner_offsets, v); k < end; k += 2u) {
        vec3 a = fetch(tracks, first + word(corners, k)).xyz - x, b = fetch(tracks, first + word(corners, k + 1u)).xyz - x;
        vec3 n = cross(a, b);
        inverted = inverted || dot(n, slope.xyz) > INVERTED * length(n) * steep;
    }
    inverted = inverted && abs(slope.w - body.x) < ON && steep * radius > CLEAR;
    uint joint = uint(fetch(vertices, 2u * v + 1u).w) * JOINT_TEXELS;
    bool far = distance(x, carry(joint + CHANGE, vec4(fetch(tracked, first + v).xyz, 1.0))) > FAR * radius;
    if (inverted || far) {
        atomicAdd(faults[gl_WorkGroupID.y], 1u); // a sum in any order
    }
}
