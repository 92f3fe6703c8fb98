// The composed field f and its gradient at a point of model space: index cell → fields → operators → maximum (Eq. 3).
// The including shader defines FIRST_FIELD_BINDING: five bindings from there on are used here.
//
// Software rasterisers run both sides of a branch and a loop's body at least once; so loops test at their end.
#ifndef DERMIS_FIELD
#define DERMIS_FIELD
#include "shared/types.glsl"

layout(set = 0, binding = FIRST_FIELD_BINDING) uniform Fields {
    vec4 grid_origin; // w: words of a cell
    vec4 grid_inverse; // cells a unit; w: fields
    vec4 box_scale; // texture coordinates a box coordinate; w: model units a rest unit
    FieldPose field[MAX_FIELDS];
} fields;
layout(set = 0, binding = FIRST_FIELD_BINDING + 1, std430) readonly buffer Index { uvec2 index[]; };
layout(set = 0, binding = FIRST_FIELD_BINDING + 2) uniform sampler3D atlas;
layout(set = 0, binding = FIRST_FIELD_BINDING + 3) uniform sampler3D operators;
layout(set = 0, binding = FIRST_FIELD_BINDING + 4, std430) readonly buffer Opening { float opening[]; };

layout(constant_id = 0) const uint OPERATORS = 0u; // 0: every joint is a union

const float NULL_GRADIENT = 1e-6; // shorter gradients have no direction
const float OPENING_ROWS = 128.0;

uint fetches = 0u;

// f and ∂f/∂x of one field; zero outside its box.
vec4 sample_field(uint i, vec3 x) {
    vec4 row0 = fields.field[i].row0, row1 = fields.field[i].row1, row2 = fields.field[i].row2;
    vec3 box = vec3(dot(row0.xyz, x) + row0.w, dot(row1.xyz, x) + row1.w, dot(row2.xyz, x) + row2.w);
    // Texel i of a tile of 32 lies at box coordinate i / 31.
    vec3 tile = (vec3(unpack(fields.field[i].tile)) * 32.0 + 0.5) / 31.0;
    vec4 t = textureLod(atlas, (tile + clamp(box, 0.0, 1.0)) * fields.box_scale.xyz, 0.0);
    if (any(notEqual(box, clamp(box, 0.0, 1.0)))) {
        return vec4(0.0);
    }
    fetches++;
    return vec4(t.x, t.y * row0.xyz + t.z * row1.xyz + t.w * row2.xyz);
}

// tan θ of an opening curve for the angle between two gradients (section 4.2), from its table over cos α.
float tan_opening(uint curve, float cosine) {
    float at = clamp(cosine * 0.5 + 0.5, 0.0, 1.0) * (OPENING_ROWS - 1.0);
    uint row = min(uint(at), uint(OPENING_ROWS) - 2u);
    uint base = curve * uint(OPENING_ROWS) + row;
    return mix(opening[base], opening[base + 1u], at - float(row));
}

// Operator number `kind` (from 1) on two samples. The operators' volumes of 128³ lie above each other in z.
vec4 combine(uint kind, uint curve, vec4 a, vec4 b) {
    float la = length(a.yzw), lb = length(b.yzw);
    if (min(la, lb) < NULL_GRADIENT) {
        return a.x >= b.x ? a : b;
    }
    float angle = tan_opening(curve, dot(a.yzw, b.yzw) / (la * lb));
    vec3 at = clamp(vec3(a.x, b.x, angle), 0.0, 1.0) * 127.0 + 0.5;
    at.z += 128.0 * float(kind - 1u);
    fetches++;
    vec4 g = textureLod(operators, at / vec3(textureSize(operators, 0)), 0.0);
    return vec4(g.x, g.y * a.yzw + g.z * b.yzw);
}

// Field i, combined with its parent where their joint has an operator other than the union.
vec4 sample_joint(uint i, vec3 x) {
    vec4 s = sample_field(i, x);
    if (OPERATORS != 0u) {
        uint link = fields.field[i].link;
        uint kind = (link >> 16) & 0xffu;
        if (kind != UNION && s.x > 0.0) {
            vec4 parent = sample_field(link & 0xffffu, x);
            if (parent.x > 0.0) {
                s = combine(kind, link >> 24, s, parent);
            }
        }
    }
    return s;
}

// f and its gradient; zero in empty cells and outside the index.
vec4 evaluate(vec3 x) {
    vec4 best = vec4(0.0);
    vec3 at = (x - fields.grid_origin.xyz) * fields.grid_inverse.xyz;
    bool inside = all(greaterThanEqual(at, vec3(0.0))) && all(lessThan(at, vec3(CELLS)));
    uvec3 c = uvec3(clamp(at, vec3(0.0), vec3(CELLS - 1)));
    // Not from the uniform block: a loop limit from there makes lavapipe compile the shader at every dispatch.
    uint pairs = uint(index.length()) / uint(CELLS * CELLS * CELLS);
    uint cell = ((c.z * uint(CELLS) + c.y) * uint(CELLS) + c.x) * pairs;
    uint pair = 0u;
    do {
        uvec2 bits = inside ? index[cell + pair] : uvec2(0u);
        do {
            bool low = bits.x != 0u;
            uint mask = low ? bits.x : bits.y;
            uint i = pair * 64u + (low ? 0u : 32u) + uint(max(findLSB(mask), 0));
            bits = low ? uvec2(bits.x & (bits.x - 1u), bits.y) : uvec2(0u, bits.y & (bits.y - 1u));
            if (mask != 0u) {
                vec4 s = sample_joint(i, x);
                best = s.x > best.x ? s : best;
            }
        } while ((bits.x | bits.y) != 0u);
        pair++;
    } while (pair < pairs);
    return best;
}

#endif
