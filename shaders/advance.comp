// Begins a step of tracking: every vertex goes on with the change of its part's joint (2014, section 5, stage 1). Wakes those
// around which anything else changes than their place, and those that had not come to rest.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRST_FIELD_BINDING 19
#include "shared/around.glsl"
#include "shared/set.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform samplerBuffer tracked; // w: movement in its last iteration
layout(set = 0, binding = 1) uniform samplerBuffer tracked_before; // one iteration ago
layout(set = 0, binding = 2) uniform samplerBuffer tracked_slopes; // gradients of its last evaluation
layout(set = 0, binding = 3) uniform samplerBuffer geometric;
layout(set = 0, binding = 4) uniform samplerBuffer vertices;
layout(set = 0, binding = 5) uniform samplerBuffer bodies;
layout(set = 0, binding = 6) uniform usamplerBuffer influence_joints;
layout(set = 0, binding = 7) uniform usamplerBuffer influence_weights;
layout(set = 0, binding = 8) uniform samplerBuffer palette;
layout(set = 0, binding = 9) uniform samplerBuffer directions; // w: fields around the vertex at rest
layout(set = 0, binding = 10, std430) writeonly buffer TrackA { vec4 track_a[]; };
layout(set = 0, binding = 11, std430) writeonly buffer TrackB { vec4 track_b[]; };
layout(set = 0, binding = 12, std430) writeonly buffer TrackC { vec4 track_c[]; };
layout(set = 0, binding = 13, std430) writeonly buffer SlopesA { vec4 slopes_a[]; };
layout(set = 0, binding = 14, std430) writeonly buffer SlopesB { vec4 slopes_b[]; };
layout(set = 0, binding = 15, std430) buffer Around { uint around[]; }; // fields that moved with the vertex, or 0
layout(set = 0, binding = 16, std430) buffer Stirs { float stirs[]; }; // a vertex: in this sub-step, and in all of the frame
layout(set = 0, binding = 17, std430) buffer LiveSet { uint live_set[]; };
layout(set = 0, binding = 18) uniform usamplerBuffer dispatches;
layout(push_constant) uniform Constants {
    uint vertices; // welded
    uint width; // influences a vertex
    float stillness; // movement that counts as rest, over the part's radius
    uint joints;
    uint fields; // that a part has room for
    uint redo; // row whose number of items says whether the skin is carried on into a half; NO_ROW for a whole step
} constants;

const uint NO_ROW = 0xffffffffu;

#include "shared/carry.glsl"
#include "shared/motion.glsl"

const float FADING = 8.0; // over which share of a box a field fades out, inverted

// How far the fields around x moved against what it was carried by from its place before; a field fades out towards the faces
// of its box. One that moves like nothing else, as a muscle that swells, counts as far.
float stir_around(vec3 x, vec3 before, float far) {
    uint pairs = cell_pairs(), pair = 0u;
    float stir = 0.0;
    do {
        uvec2 bits = cell_pair(x, pair, pairs);
        do {
            bool any_left = (bits.x | bits.y) != 0u;
            uint i = pair * 64u + take_bit(bits);
            vec3 at = in_box(field_box(i), x), inside = min(at, 1.0 - at);
            float presence = clamp(FADING * min(inside.x, min(inside.y, inside.z)), 0.0, 1.0);
            uint joint = joint_of(field_word(i, LAST_CELL)) * JOINT_TEXELS;
            float apart = field_word(i, TILE) >> 24 == NO_MOTION ? far : distance(carry(joint + CHANGE, vec4(before, 1.0)), x);
            stir = any_left ? max(stir, presence * apart) : stir;
        } while ((bits.x | bits.y) != 0u);
        pair++;
    } while (pair < pairs);
    return stir;
}

void main() {
    uint v = gl_GlobalInvocationID.x;
    if (v >= constants.vertices) {
        return;
    }
    find_fields(constants.fields);
    bool whole = constants.redo == NO_ROW;
    if (whole ? fetch(field_poses, field_first + TURN).y == 0.0 : list_count(dispatches, whole ? 0u : constants.redo) == 0u) {
        return; // other instances have more steps, or faults
    }
    uint at = part(constants.vertices) + v;
    vec4 body = fetch(bodies, v), state = fetch(tracked, at);
    uint joint = uint(fetch(vertices, 2u * v + 1u).w) * JOINT_TEXELS;
    // Without freedom a vertex keeps no history: its joint carries it from its place at rest.
    bool free = body.z > 0.0, follows = body.w >= 0.0;
    vec3 carried = carry(free ? joint + CHANGE : joint, vec4(free ? state.xyz : fetch(vertices, 2u * v).xyz, 1.0));
    vec3 home = fetch(geometric, at).xyz;
    uvec2 motions = motions_of(v, constants.width);
    // Where all around has moved as one since rest, the vertex is where its joints carry it, unless its neighbours draw it.
    bool at_home = fields_moving_as(motions.y, FIRST_CELL, home) == uint(fetch(directions, v).w);
    vec3 x = at_home || !follows ? home : carried;
    uint count = fields_moving_as(motions.x, TILE, x);
    bool still = count != 0u && count == around[at] && state.w <= constants.stillness;
    // A skin that keeps up with its joints keeps no momentum: every frame begins at home.
    vec3 before = at_home ? x : x - carried + carry(joint + CHANGE, vec4(fetch(tracked_before, at).xyz, 1.0));
    vec3 slope = carry(joint + CHANGE, vec4(fetch(tracked_slopes, at).xyz, 0.0));
    float radius = body.y * fields.box_scale.w;
    bool settled = at_home || !follows;
    float stir = settled ? 1.0 : count != 0u ? 0.0 : stir_around(x, state.xyz, radius) / radius;
    around[at] = count;
    stirs[2u * at] = stir;
    stirs[2u * at + 1u] += stir;
    track_a[at] = vec4(x, state.w);
    track_b[at] = vec4(x, state.w);
    track_c[at] = vec4(before, 0.0);
    slopes_a[at] = vec4(slope, 0.0);
    slopes_b[at] = vec4(slope, 0.0);
    if (follows && !at_home && !still) {
        uint seed = uint(body.w);
        ENTER(live_set, seed);
    }
}
