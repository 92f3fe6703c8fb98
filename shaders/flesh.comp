// Fleshing (2013): rows of the file that follow a spine of joints go where it bends them, blended with the method's skin.
//
// The spine goes through points that joints carry; a row has their weights in the curve C(t) and its first three derivatives. From
// the rest spine the frame is turned by the joints' rotations, then by the least rotation onto the tangent. Where the curve is
// stretched by λ the cross-section has 1/λ of its area, so that volume is kept in bends and stretches.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/flesh_map.glsl"
#include "shared/rotation.glsl"
#include "shared/texels.glsl"
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform samplerBuffer flesh_rows;
layout(set = 0, binding = 1) uniform usamplerBuffer flesh_words;
layout(set = 0, binding = 2) uniform samplerBuffer spine_weights;
layout(set = 0, binding = 3) uniform samplerBuffer spine_points; // w: joint
layout(set = 0, binding = 4) uniform samplerBuffer palette;
layout(set = 0, binding = 5, std430) buffer SkinPositions { vec4 skin_position[]; };
layout(set = 0, binding = 6, std430) buffer SkinNormals { vec4 skin_normal[]; }; // w: 1 past the limit, else 0
layout(push_constant) uniform Constants {
    uint count; // rows that follow a spine
    uint rows; // of the file
    uint joints;
} constants;

#include "shared/carry.glsl"

const float WHOLE_ROOM = 0.3; // of the way to the limit that is left; with less, skin goes back to the method's
const float LEAST_ROOM = 1e-3; // of what is left towards the centre of curvature, in a normal

vec3 spine_point(uint i) {
    vec4 point = fetch(spine_points, i);
    return carry(uint(point.w) * JOINT_TEXELS, vec4(point.xyz, 1.0));
}

// Cube root of a joint's volume: characters may be scaled as a whole.
float scale_of(uint joint) {
    uint at = part(JOINT_TEXELS * constants.joints) + joint * JOINT_TEXELS;
    vec3 a = fetch(palette, at).xyz, b = fetch(palette, at + 1u).xyz, c = fetch(palette, at + 2u).xyz;
    return pow(abs(dot(a, cross(b, c))), 1.0 / 3.0);
}

void main() {
    if (gl_GlobalInvocationID.x >= constants.count) {
        return;
    }
    uint at = FLESH_TEXELS * gl_GlobalInvocationID.x, words = 4u * at + 24u;
    vec4 tangent = fetch(flesh_rows, at), side = fetch(flesh_rows, at + 1u), straight = fetch(flesh_rows, at + 2u);
    vec4 covector = fetch(flesh_rows, at + 3u), frame = fetch(flesh_rows, at + 4u), turning = fetch(flesh_rows, at + 5u);
    uint row = word(flesh_words, words), weight = word(flesh_words, words + 1u);
    uint point = word(flesh_words, words + 2u), points = word(flesh_words, words + 3u);

    // Weights add up to 1, those of derivatives to 0: all relative to the first point.
    vec3 origin = spine_point(point), spot = vec3(0.0), first = vec3(0.0), second = vec3(0.0), third = vec3(0.0);
    for (uint k = 1u; k < points; k++) {
        vec3 p = spine_point(point + k) - origin;
        vec4 w = fetch(spine_weights, weight + k);
        spot += w.x * p;
        first += w.y * p;
        second += w.z * p;
        third += w.w * p;
    }
    spot += origin;
    float speed = max(length(first), 1e-20), stretch = speed / tangent.w;
    vec3 t = first / speed;
    float along = dot(second, t);
    vec3 across = second - along * t, bend_vector = across / (speed * speed);
    vec3 bend_rate = (third - 3.0 * along / speed * across) / (speed * speed * speed);

    // The frame, and how it turns about the tangent a unit of the spine's length.
    uint joint_a = uint(frame.x), joint_b = uint(frame.y), joints = part(JOINT_TEXELS * constants.joints);
    vec4 qa = fetch(palette, joints + joint_a * JOINT_TEXELS + REAL), qb = fetch(palette, joints + joint_b * JOINT_TEXELS + REAL);
    qb = dot(qa, qb) < 0.0 ? -qb : qb;
    vec4 q = mix(qa, qb, covector.w), q_rate = frame.z * (qb - qa);
    float q_length = max(length(q), 1e-20);
    q /= q_length;
    q_rate = (q_rate - q * dot(q, q_rate)) / q_length;
    vec3 spin = 2.0 * (q.w * q_rate.xyz - q_rate.w * q.xyz - cross(q_rate.xyz, q.xyz));
    vec3 rest_rate = turning.x * side.xyz + turning.y * cross(tangent.xyz, side.xyz);
    vec3 carried = rotate(q, tangent.xyz), carried_rate = cross(spin, carried) + rotate(q, rest_rate);
    vec3 i = rotate_between(carried, t, rotate(q, side.xyz));
    i = normalize(i - dot(i, t) * t);
    vec3 j = cross(t, i);
    // The least rotation between two moving directions turns about them by the solid angle that they sweep (Bishop's frame).
    vec3 tangent_rate = across / speed;
    float sweep = (dot(t, cross(carried, carried_rate)) - dot(carried, cross(t, tangent_rate))) / max(1.0 + dot(carried, t), 1e-4);
    float twist = (dot(spin, carried) + sweep) / speed;

    vec2 curvature = vec2(dot(bend_vector, i), dot(bend_vector, j));
    vec2 rate = vec2(dot(bend_rate, i), dot(bend_rate, j)) + twist * vec2(curvature.y, -curvature.x);
    float scale = mix(scale_of(joint_a), scale_of(joint_b), covector.w);
    float thin = scale * sqrt(scale / max(stretch, 1e-20));
    vec2 offset = thin * straight.xy;
    Shift shift = bend(uint(frame.w), offset, curvature, rate);
    vec3 place = spot + side.w * stretch * t + shift.offset.x * i + shift.offset.y * j;

    // The covector n of positions goes to m with m · ∂x/∂(s, η) = n · ∂X/∂(s, η), up to its length.
    float thinning = -0.5 * (along / speed - straight.w) / speed;
    float room = max(1.0 - dot(curvature, shift.offset), LEAST_ROOM);
    vec2 slide = shift.along + twist * vec2(-shift.offset.y, shift.offset.x) + thinning * (shift.by_offset * offset);
    mat2 b = shift.by_offset;
    // Cofactors: determinant times the inverse's transpose.
    mat2 cofactor = mat2(b[1][1], -b[1][0], -b[0][1], b[0][0]);
    vec2 m = cofactor * covector.yz / thin;
    float m_along = covector.x * determinant(b) / stretch - dot(m, slide);
    vec3 normal = m_along * t + room * (m.x * i + m.y * j);

    // Past its limit the map keeps no volume: there the skin goes back to that of the method.
    uint to = part(constants.rows) + row;
    float left = 1.0 - dot(curvature, offset) / limit_of(uint(frame.w));
    float w = straight.z * smoothstep(0.0, WHOLE_ROOM, left);
    vec4 skin = skin_position[to];
    vec3 n = mix(skin_normal[to].xyz, normal / max(length(normal), 1e-20), w);
    skin_position[to] = vec4(mix(skin.xyz, place, w), skin.w);
    skin_normal[to] = vec4(n / max(length(n), 1e-20), left > 0.0 ? 0.0 : 1.0);
}
