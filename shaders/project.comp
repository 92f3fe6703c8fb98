// Projection of live vertices onto their iso-values by clamped Newton steps (Eq. 4 with its sign put right).
// A vertex stops in contact where the gradient turns (section 5) or where the distance to the iso-value grows (a pit);
// the last accepted point stays its anchor. One that went sideways out of a deep fold, at right angles
// to its skin, or arrives inside out stays in contact where its joints carried it. Survivors and
// contacts are entered into sets, for the compactions that follow.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRST_FIELD_BINDING 15
#include "shared/field.glsl"
#include "shared/newton.glsl"
#include "shared/rotation.glsl"
#include "shared/set.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer list;
layout(set = 0, binding = 1) uniform usamplerBuffer dispatches;
layout(set = 0, binding = 2) uniform samplerBuffer starts;
layout(set = 0, binding = 3) uniform samplerBuffer geometric;
layout(set = 0, binding = 4) uniform samplerBuffer vertices;
layout(set = 0, binding = 5) uniform usamplerBuffer iso_values;
layout(set = 0, binding = 6, std430) writeonly buffer Positions { vec4 position[]; }; // w: field
layout(set = 0, binding = 7, std430) buffer Anchors { vec4 anchor[]; }; // last accepted point; w: distance to the iso-value there
layout(set = 0, binding = 8, std430) buffer Gradients { vec4 gradient[]; }; // at the anchor; w: field
layout(set = 0, binding = 9, std430) buffer Status { uint status[]; };
layout(set = 0, binding = 10, std430) buffer LiveSet { uint live_set[]; };
layout(set = 0, binding = 11) uniform samplerBuffer directions; // of the gradient at rest
layout(set = 0, binding = 12) uniform samplerBuffer rotations;
layout(set = 0, binding = 13, std430) buffer ContactSet { uint contact_set[]; };
layout(set = 0, binding = 14) uniform usamplerBuffer seed_ranks;
layout(push_constant) uniform Constants {
    uint dispatch; // row of the list's head
    uint vertices; // welded
    uint fields; // that a part has room for
    uint steps; // Newton steps of this call
    uint evaluations; // of the field; the one after the last step is the next call's first, if there is one
    uint flags; // FRESH, LAST, HOLD
    float sigma; // step size
    float tolerance; // |f − iso| that counts as settled
    float cos_contact; // cosine of the angle that counts as a discontinuity
} constants;

const uint FRESH = 1u; // no anchor from an earlier call
const uint LAST = 2u; // survivors have hit the iteration limit
const uint HOLD = 4u; // vertices in contact stay where they are and are only measured; new ones stay at their anchor

const float SIDEWAYS = 0.35; // |cosine| between the gradient and its direction at rest, carried along, that is neither way
const float DEEP = 0.02; // |f − iso| from which on sideways steps lead astray
const float RELAXED_PIT = 0.02; // growth that a relaxation in between explains

void main() {
    if (gl_GlobalInvocationID.x < list_count(dispatches, constants.dispatch)) {
        find_fields(constants.fields);
        uint first = part(constants.vertices), v = word(list, first + gl_GlobalInvocationID.x), at = first + v;
        uint before = status[at];
        uint evaluations = (before >> 8) & 0xffu;
        fetches = (before >> 16) & 0x7fffu;
        bool strayed = (before & STRAYED) != 0u;
        float iso = number(iso_values, v), radius = fetch(vertices, 2u * v).w * fields.box_scale.w;
        vec3 start = fetch(starts, at).xyz;
        vec3 x = start, home = fetch(geometric, at).xyz;
        vec3 expected = rotate(fetch(rotations, at), fetch(directions, v).xyz);
        bool known = (constants.flags & FRESH) == 0u;
        vec4 last = vec4(0.0), slope = vec4(0.0);
        if (known) {
            last = anchor[at];
            slope = gradient[at];
        }
        bool hold = (constants.flags & HOLD) != 0u;
        bool held = hold && state_of(before) == CONTACT;
        float allowed = known ? RELAXED_PIT : PIT;
        uint state = LIVE, s = 0u;
        do {
            vec4 sampled = evaluate(x);
            evaluations++;
            vec3 g = sampled.yzw;
            float off = abs(sampled.x - iso), steep = length(g);
            bool turned = dot(g, slope.xyz) < constants.cos_contact * steep * length(slope.xyz);
            if (known && (turned || off > last.w + allowed)) {
                state = CONTACT;
                x = hold ? last.xyz : x;
            } else {
                last = vec4(x, off);
                slope = vec4(g, sampled.x);
                known = true;
                allowed = PIT;
                strayed = strayed || (off > DEEP && abs(dot(g, expected)) < SIDEWAYS * steep);
                if (held) {
                    state = CONTACT;
                } else if (off < constants.tolerance && (strayed || dot(g, expected) < 0.0)) {
                    state = CONTACT;
                    x = hold ? start : home;
                    last.xyz = x;
                } else if (off < constants.tolerance) {
                    state = ON_ISO;
                } else if (steep * radius < FLAT) {
                    state = OUTSIDE;
                } else if (s < constants.steps) {
                    x += shorten(constants.sigma * (iso - sampled.x) / (steep * steep) * g, LEAP * radius);
                    x = home + shorten(x - home, radius);
                } else {
                    state = LIMIT;
                }
            }
            s++;
        } while (s < constants.evaluations && state == LIVE);
        position[at] = vec4(x, slope.w);
        anchor[at] = last;
        gradient[at] = slope;
        status[at] = state | min(evaluations, 255u) << 8 | min(fetches, 0x7fffu) << 16 | (strayed ? STRAYED : 0u);
        uint seed = word(seed_ranks, v);
        if (state == LIVE) {
            ENTER(live_set, seed);
        }
        if (state == CONTACT && !hold) {
            ENTER(contact_set, seed);
        }
    }
}
