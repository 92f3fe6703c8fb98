// The constant part of the Jacobi iteration on the relaxation energy (2014, Eq. 3): Σ w R_ij (p_i − p_j) over the one-ring, p at
// rest. What the weights lack of 1 ties the vertex to where its rotation carries it.
//
// R_ij is the rotation half-way between those of the blended dual quaternions. The paper has their mean (R_i + R_j)/2, which
// shortens an edge by the cosine of half the angle between them: to .71 at a joint bent by 90° with rigid weights.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/pace.glsl"
#include "shared/rotation.glsl"
#include "shared/texels.glsl"
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer ring_offsets;
layout(set = 0, binding = 1) uniform usamplerBuffer rings;
layout(set = 0, binding = 2) uniform usamplerBuffer ring_weights;
layout(set = 0, binding = 3) uniform samplerBuffer vertices;
layout(set = 0, binding = 4) uniform samplerBuffer rotations;
layout(set = 0, binding = 5) uniform samplerBuffer field_poses;
layout(set = 0, binding = 6) uniform samplerBuffer geometric;
layout(set = 0, binding = 7) uniform usamplerBuffer stirs;
layout(set = 0, binding = 8, std430) writeonly buffer Goals { vec4 goals[]; }; // w: pace
layout(push_constant) uniform Constants {
    uint vertices; // welded
    uint fields; // that a part has room for
} constants;

void main() {
    uint v = gl_GlobalInvocationID.x;
    if (v >= constants.vertices) {
        return;
    }
    uint first = part(constants.vertices);
    vec3 p = fetch(vertices, 2u * v).xyz, goal = vec3(0.0);
    float tie = 1.0;
    vec4 turn = fetch(rotations, first + v);
    uint end = word(ring_offsets, v + 1u);
    for (uint k = word(ring_offsets, v); k < end; k++) {
        uint j = word(rings, k);
        vec3 edge = p - fetch(vertices, 2u * j).xyz;
        float weight = number(ring_weights, k);
        tie -= weight;
        goal += weight * rotate(half_way(turn, fetch(rotations, first + j)), edge);
    }
    float scale = fetch(field_poses, part(FIELD_HEAD + FIELD_TEXELS * constants.fields) + BOX_SCALE).w;
    goals[first + v] = vec4(scale * goal + tie * fetch(geometric, first + v).xyz, pace_of(number(stirs, 2u * (first + v))));
}
