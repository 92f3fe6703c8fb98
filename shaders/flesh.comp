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

// The posed curve at a row's parameter.
struct Curve {
    vec3 spot;
    vec3 tangent;
    vec3 tangent_rate; // by the parameter
    float speed; // length a unit of the parameter
    float quicken; // derivative of its logarithm
    vec3 bend; // curvature vector
    vec3 bend_rate; // by length
};

// The posed frame there: side, and tangent × side.
struct Frame {
    vec3 side;
    vec3 lift;
    float twist; // turn about the tangent, a unit of length
    float scale; // model units a rest unit
};

Curve curve_at(uint weight, uint point, uint points) {
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
    float speed = max(length(first), 1e-20);
    vec3 tangent = first / speed;
    float quicken = dot(second, tangent) / speed;
    vec3 across = second - quicken * first;
    vec3 bend_rate = (third - 3.0 * quicken * across) / (speed * speed * speed);
    return Curve(origin + spot, tangent, across / speed, speed, quicken, across / (speed * speed), bend_rate);
}

// The rest frame, turned by the joints' rotations, then by the least rotation onto the tangent.
Frame frame_at(uint at, Curve curve) {
    vec3 tangent = fetch(flesh_rows, at).xyz, side = fetch(flesh_rows, at + 1u).xyz, t = curve.tangent;
    vec4 blend = fetch(flesh_rows, at + 4u), turning = fetch(flesh_rows, at + 5u);
    float share = fetch(flesh_rows, at + 3u).w;
    uint a = uint(blend.x), b = uint(blend.y), joints = part(JOINT_TEXELS * constants.joints);
    vec4 qa = fetch(palette, joints + a * JOINT_TEXELS + REAL), qb = fetch(palette, joints + b * JOINT_TEXELS + REAL);
    qb = dot(qa, qb) < 0.0 ? -qb : qb;
    vec4 q = mix(qa, qb, share), rate = blend.z * (qb - qa);
    float q_length = max(length(q), 1e-20);
    q /= q_length;
    rate = (rate - q * dot(q, rate)) / q_length;
    vec3 spin = 2.0 * (q.w * rate.xyz - rate.w * q.xyz - cross(rate.xyz, q.xyz));
    vec3 rest_rate = turning.x * side + turning.y * cross(tangent, side);
    vec3 carried = rotate(q, tangent), carried_rate = cross(spin, carried) + rotate(q, rest_rate);
    vec3 i = rotate_between(carried, t, rotate(q, side));
    i = normalize(i - dot(i, t) * t);
    // The least rotation between two moving directions turns about them by the solid angle that they sweep (Bishop's frame).
    float swept = dot(t, cross(carried, carried_rate)) - dot(carried, cross(t, curve.tangent_rate));
    float twist = (dot(spin, carried) + swept / max(1.0 + dot(carried, t), 1e-4)) / curve.speed;
    return Frame(i, cross(t, i), twist, mix(scale_of(a), scale_of(b), share));
}

void main() {
    if (gl_GlobalInvocationID.x >= constants.count) {
        return;
    }
    uint at = FLESH_TEXELS * gl_GlobalInvocationID.x, words = 4u * (at + FLESH_TEXELS - 1u);
    uint weight = word(flesh_words, words + 1u), point = word(flesh_words, words + 2u);
    Curve curve = curve_at(weight, point, word(flesh_words, words + 3u));
    Frame frame = frame_at(at, curve);
    vec4 straight = fetch(flesh_rows, at + 2u), covector = fetch(flesh_rows, at + 3u);
    float past = fetch(flesh_rows, at + 1u).w, stretch = curve.speed / fetch(flesh_rows, at).w;
    uint map = uint(fetch(flesh_rows, at + 4u).w);

    vec2 curvature = vec2(dot(curve.bend, frame.side), dot(curve.bend, frame.lift));
    vec2 rate = vec2(dot(curve.bend_rate, frame.side), dot(curve.bend_rate, frame.lift));
    rate += frame.twist * vec2(curvature.y, -curvature.x);
    float thin = frame.scale * sqrt(frame.scale / max(stretch, 1e-20));
    vec2 offset = thin * straight.xy;
    Shift shift = bend(map, offset, curvature, rate);
    vec3 place = curve.spot + past * stretch * curve.tangent + shift.offset.x * frame.side + shift.offset.y * frame.lift;

    // The covector n of positions goes to m with m · ∂x/∂(s, η) = n · ∂X/∂(s, η), up to its length.
    float thinning = -0.5 * (curve.quicken - straight.w) / curve.speed;
    float room = max(1.0 - dot(curvature, shift.offset), LEAST_ROOM);
    vec2 slide = shift.along + frame.twist * vec2(-shift.offset.y, shift.offset.x) + thinning * (shift.by_offset * offset);
    mat2 b = shift.by_offset;
    // Cofactors: determinant times the inverse's transpose.
    vec2 m = mat2(b[1][1], -b[1][0], -b[0][1], b[0][0]) * covector.yz / thin;
    float m_along = covector.x * determinant(b) / stretch - dot(m, slide);
    vec3 normal = m_along * curve.tangent + room * (m.x * frame.side + m.y * frame.lift);

    // Past its limit the map keeps no volume: there the skin goes back to that of the method.
    uint to = part(constants.rows) + word(flesh_words, words);
    float left = 1.0 - dot(curvature, offset) / limit_of(map);
    float w = straight.z * smoothstep(0.0, WHOLE_ROOM, left);
    vec4 skin = skin_position[to];
    vec3 n = mix(skin_normal[to].xyz, normal / max(length(normal), 1e-20), w);
    skin_position[to] = vec4(mix(skin.xyz, place, w), skin.w);
    skin_normal[to] = vec4(n / max(length(n), 1e-20), left > 0.0 ? 0.0 : 1.0);
}
