// The skin of a tracked frame: puts listed vertices onto their iso-values by undamped Newton steps, measures the field there and
// tells their states. A vertex is in contact where a step turns the gradient (2013, section 5) or leads away from the iso-value;
// it stays where it was before that step.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRST_FIELD_BINDING 8
#include "shared/field.glsl"
#include "shared/newton.glsl"
#include "shared/set.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer list;
layout(set = 0, binding = 1) uniform usamplerBuffer dispatches;
layout(set = 0, binding = 2) uniform samplerBuffer starts;
layout(set = 0, binding = 3) uniform samplerBuffer bodies;
layout(set = 0, binding = 4) uniform usamplerBuffer seed_ranks;
layout(set = 0, binding = 5, std430) writeonly buffer Positions { vec4 position[]; }; // w: field
layout(set = 0, binding = 6, std430) buffer Status { uint status[]; };
layout(set = 0, binding = 7, std430) buffer ContactSet { uint contact_set[]; };
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint vertices; // welded
    uint fields; // that a part has room for
    uint listed; // length of an instance's part of the list; 0 where all instances share it
    uint steps;
    uint hold; // 1: vertices in contact stay where they are and are only measured
    float sigma; // share of a step
    float tolerance; // |f − iso| that counts as settled
    float cos_contact; // cosine of the angle that counts as a discontinuity
} constants;

const float EMPTY = 1e-4; // f below which a place without direction is outside

void main() {
    if (gl_GlobalInvocationID.x >= list_count(dispatches, constants.dispatch)) {
        return;
    }
    find_fields(constants.fields);
    uint first = part(constants.vertices), v = word(list, part(constants.listed) + gl_GlobalInvocationID.x);
    uint before = status[first + v], evaluations = (before >> 8) & 0xffu;
    fetches = (before >> 16) & 0x7fffu;
    bool held = constants.hold != 0u && state_of(before) == CONTACT;
    vec4 body = fetch(bodies, v);
    float iso = body.x, radius = body.y * fields.box_scale.w;
    vec3 x = fetch(starts, first + v).xyz, last = x, slope = vec3(0.0);
    float off = 3.402823466e38, field = 0.0;
    uint state = LIVE, s = 0u;
    do {
        vec4 sampled = evaluate(x);
        evaluations++;
        vec3 g = sampled.yzw;
        float now = abs(sampled.x - iso), steep = length(g);
        if (s > 0u && (now > off + PIT || dot(g, slope) < constants.cos_contact * steep * length(slope))) {
            state = CONTACT;
        } else {
            last = x;
            slope = g;
            off = now;
            field = sampled.x;
            if (held) {
                state = CONTACT;
            } else if (off < constants.tolerance) {
                state = ON_ISO;
            } else if (steep * radius < FLAT) {
                state = field < EMPTY ? OUTSIDE : CONTACT;
            } else if (s < constants.steps) {
                x += shorten(constants.sigma * (iso - field) / (steep * steep) * g, LEAP * radius);
            } else {
                state = LIMIT;
            }
        }
        s++;
    } while (state == LIVE);
    position[first + v] = vec4(last, field);
    status[first + v] = state | min(evaluations, 255u) << 8 | min(fetches, 0x7fffu) << 16;
    uint seed = word(seed_ranks, v);
    if (state == CONTACT && constants.hold == 0u) {
        ENTER(contact_set, seed);
    }
}
