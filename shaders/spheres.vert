#version 460
#extension GL_GOOGLE_include_directive : require
// Six corners a primitive. A sphere or the cone between two is found by the fragment shader and gets the rectangle of the
// picture that holds it; of the slab between three spheres it is the two faces, triangles in planes that touch all three.

#include "shared/spheres.glsl"

// Centre and radius; colour and opacity of each; rows of a primitive's spheres and, in w, their number.
layout(std430, set = 0, binding = 0) readonly buffer Balls { vec4 balls[]; };
layout(std430, set = 0, binding = 1) readonly buffer Colours { vec4 colours[]; };
layout(std430, set = 0, binding = 2) readonly buffer Primitives { uvec4 primitives[]; };

layout(location = 0) flat out vec4 ball[3];
layout(location = 3) flat out vec4 colour[3];
layout(location = 6) flat out uint count;
layout(location = 7) flat out vec3 face;

// Nothing is drawn of a primitive all of whose corners are here.
const vec4 NOWHERE = vec4(2, 2, 2, 1);

vec4 row(int i) {
    mat4 m = constants.clip_from_model;
    return vec4(m[0][i], m[1][i], m[2][i], m[3][i]);
}

// From where to where a sphere reaches along a row of the picture: the planes row - x * last that touch it, which are
// those whose product with themselves in the sphere's dual quadric vanishes (Sigg et al. 2006).
vec2 reach(vec4 b, vec4 along, vec4 last) {
    vec4 centre = vec4(b.xyz, 1);
    float square = b.w * b.w;
    float l = dot(along, centre), w = dot(last, centre);
    float ll = dot(along.xyz, along.xyz), lw = dot(along.xyz, last.xyz), ww = dot(last.xyz, last.xyz);
    float slope = square * ww - w * w;
    // The squares of l * w, which are large, are cancelled by hand.
    float root = square * (ww * l * l - 2 * lw * l * w + ll * w * w + square * (lw * lw - ll * ww));
    float middle = square * lw - l * w;
    float half_width = sqrt(max(root, 0));
    return vec2(middle + half_width, middle - half_width) / slope;
}

// A corner of the rectangle that holds the primitive's spheres, and so all that is interpolated between them.
vec4 rectangle(vec2 corner) {
    vec4 last = row(3);
    float behind = length(last.xyz);
    vec2 low = vec2(1), high = vec2(-1);
    uint front = 0, hidden = 0;
    for (int i = 0; i < count; i++) {
        float depth = dot(last, vec4(ball[i].xyz, 1));
        if (depth > ball[i].w * behind * 1.001) {
            vec2 x = reach(ball[i], row(0), last), y = reach(ball[i], row(1), last);
            low = i == 0 ? vec2(x.x, y.x) : min(low, vec2(x.x, y.x));
            high = i == 0 ? vec2(x.y, y.y) : max(high, vec2(x.y, y.y));
            front++;
        } else if (depth < -ball[i].w * behind) {
            hidden++;
        }
    }
    if (hidden == count) {
        return NOWHERE;
    }
    if (front < count) {
        // It reaches through the plane of the eye, where rectangles have no end.
        low = vec2(-1);
        high = vec2(1);
    }
    // A pixel more on each side for what is rounded off.
    return vec4(mix(low - constants.pixel.xy, high + constants.pixel.xy, corner), 0.5, 1);
}

// Outward normal of a face: it leans against the gradient of the radius over the plane of the centres. Zero where those
// are collinear or the radius changes so fast that no plane touches all three.
vec3 normal_of(float side) {
    vec3 b = ball[1].xyz - ball[0].xyz, c = ball[2].xyz - ball[0].xyz;
    vec3 across = cross(b, c);
    float square = dot(across, across);
    if (!(square > 1e-11 * dot(b, b) * dot(c, c))) {
        return vec3(0);
    }
    vec2 radii = vec2(ball[1].w, ball[2].w) - ball[0].w;
    vec3 gradient = (cross(c, across) * radii.x + cross(across, b) * radii.y) / square;
    float rest = 1 - dot(gradient, gradient);
    return rest > 0 ? side * sqrt(rest) * across * inversesqrt(square) - gradient : vec3(0);
}

void main() {
    uvec4 primitive = primitives[gl_VertexIndex / 6];
    int corner = gl_VertexIndex % 6;
    count = primitive.w;
    for (int i = 0; i < 3; i++) {
        ball[i] = balls[primitive[i]];
        colour[i] = colours[primitive[i]];
    }
    if (count < 3) {
        face = vec3(0);
        int at = corner < 3 ? corner : 6 - corner;
        gl_Position = rectangle(vec2(at & 1, at >> 1));
        return;
    }
    face = normal_of(corner < 3 ? 1 : -1);
    vec4 at = ball[corner % 3];
    gl_Position = dot(face, face) > 0 ? constants.clip_from_model * vec4(at.xyz + at.w * face, 1) : NOWHERE;
}
