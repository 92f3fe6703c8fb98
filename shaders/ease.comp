// Ends a frame of tracking: the settled and smoothed skin follows the tracked one at the pace of what moves around it. What a vertex
// has of settling and smoothing is kept from frame to frame, turned back to rest with its part.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRST_FIELD_BINDING 10
#include "shared/field.glsl"
#include "shared/newton.glsl"
#include "shared/pace.glsl"
#include "shared/rotation.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer list;
layout(set = 0, binding = 1) uniform usamplerBuffer dispatches;
layout(set = 0, binding = 2) uniform samplerBuffer tracked;
layout(set = 0, binding = 3) uniform usamplerBuffer stirs;
layout(set = 0, binding = 4) uniform samplerBuffer bodies; // iso-value, radius, freedom, rank of the seed or -1
layout(set = 0, binding = 5) uniform samplerBuffer vertices;
layout(set = 0, binding = 6) uniform samplerBuffer palette;
layout(set = 0, binding = 7, std430) buffer Corrections { vec4 corrections[]; };
layout(set = 0, binding = 8, std430) buffer Positions { vec4 position[]; }; // w: field
layout(set = 0, binding = 9, std430) buffer Status { uint status[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint vertices; // welded
    uint joints;
    uint fields; // that a part has room for
    float tolerance; // |f − iso| that counts as settled
} constants;

const float NEAR = 5e-4; // way over the radius on which the field does not change to speak of
const float NUDGE = 7e-3; // longest step back to the iso-value over the radius; longer ones would be jumps again

void main() {
    if (gl_GlobalInvocationID.x >= list_count(dispatches, constants.dispatch)) {
        return;
    }
    find_fields(constants.fields);
    uint first = part(constants.vertices), v = word(list, gl_GlobalInvocationID.x), at = first + v;
    uint joint = part(JOINT_TEXELS * constants.joints) + uint(fetch(vertices, 2u * v + 1u).w) * JOINT_TEXELS;
    vec4 body = fetch(bodies, v), end = position[at], turn = fetch(palette, joint + REAL);
    vec3 start = fetch(tracked, at).xyz, wanted = end.xyz - start, last = rotate(turn, corrections[at].xyz);
    float radius = body.y * fields.box_scale.w, easing = easing_of(number(stirs, 2u * at + 1u), fields.turn.w);
    vec3 correction = easing < 1.0 ? mix(last, wanted, easing) : wanted;
    corrections[at] = vec4(rotate(vec4(-turn.xyz, turn.w), correction), 0.0);
    if (easing < 1.0) {
        end.xyz = start + correction;
    }
    bool open = distance(correction, wanted) > NEAR * radius, onto = state_of(status[at]) == ON_ISO, nudged = false;
    do {
        if (open) {
            vec4 sampled = evaluate(end.xyz);
            end.w = sampled.x;
            bool off = abs(sampled.x - body.x) > constants.tolerance;
            open = onto && off && !nudged;
            end.xyz += open ? newton(body.x, sampled, 1.0, radius, NUDGE) : vec3(0.0);
            if (nudged && off) {
                status[at] = status[at] - ON_ISO + (sheet > IN_CONTACT ? CONTACT : LIMIT);
            }
            nudged = open;
        }
    } while (open);
    position[at] = end;
}
