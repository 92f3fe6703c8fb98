// Spheres, capsules and thick triangles as a moving sphere meets them, in closed form (sphere-meshes 2016, appendix B).
//
// A solid is the convex hull of three spheres, some of which may be the same. Its surface is made of patches of these spheres, of
// cones that touch two of them and of planes that touch three; each lies within the solid, so that the first meeting of a line with
// any of them is where it enters.
#ifndef DERMIS_SOLID
#define DERMIS_SOLID
#include "shared/texels.glsl"

// A solid (Primitive) is 18 texels, of which the first is a sphere that it is in all the frame.
const uint SOLID_TEXELS = 18u;
const uint BALLS = 1u; // centre, radius
const uint MOVES = 4u; // way in the frame
const uint SIDES = 7u; // of the cone from each sphere to the next: unit axis, length; 0 for none
const uint SINES = 10u; // of the angle by which a cone's normals lean along its axis
const uint SQUARES = 11u; // of the cosines
const uint FACES = 12u; // normal, 1; share of the second sphere, its growth; share of the third
const uint FACE_TEXELS = 3u;

const float FAR = 1e30;
// Room at the borders of a plane, in shares and against rounding: two planes that share one must not let anything through.
const float BORDER = 1e-6;
const float ROUNDING = 2.4e-7;

// A sphere of radius `radius` on its way from `origin` along the unit vector `direction`: how far until it touches, FAR for never.
// Negative for what lies behind.
float enter(samplerBuffer solids, uint solid, vec3 origin, vec3 direction, float radius) {
    float first = FAR;
    vec4 sines = fetch(solids, solid + SINES), squares = fetch(solids, solid + SQUARES);
    for (uint k = 0u; k < 3u; k++) {
        vec4 ball = fetch(solids, solid + BALLS + k), side = fetch(solids, solid + SIDES + k);
        // The line's point beside the centre: what is large is gone before anything is squared.
        vec3 from = origin - ball.xyz;
        float middle = -dot(from, direction), reach = ball.w + radius;
        from += direction * middle;
        float apart = dot(from, from) - reach * reach;
        if (apart <= 0.0) {
            first = min(first, middle - sqrt(-apart));
        }
        // Beside the axis at x and along it at y the cone is x cos φ + y sin φ = reach; squared, cos² φ (|p|² - reach²) = w² with
        // w = y - reach sin φ, and the centre of the sphere that touches there is at w / cos² φ along the axis.
        float along = dot(direction, side.xyz), w = dot(from, side.xyz) - reach * sines[k];
        float a = squares[k] - along * along, b = -along * w, c = squares[k] * apart - w * w, root = b * b - a * c;
        if (side.w > 0.0 && root >= 0.0) {
            float q = -(b + (b < 0.0 ? -sqrt(root) : sqrt(root))), end = side.w * squares[k];
            float near = q / a, far = c / q;
            // A root at infinity, or none, is in no interval.
            if (w + along * near >= 0.0 && w + along * near <= end) {
                first = min(first, middle + near);
            }
            if (w + along * far >= 0.0 && w + along * far <= end) {
                first = min(first, middle + far);
            }
        }
    }
    vec4 ball = fetch(solids, solid + BALLS);
    for (uint k = 0u; k < 2u; k++) {
        uint face = solid + FACES + k * FACE_TEXELS;
        vec3 normal = fetch(solids, face).xyz;
        vec4 u = fetch(solids, face + 1u), v = fetch(solids, face + 2u);
        float against = dot(normal, direction);
        vec3 from = origin - ball.xyz - normal * (ball.w + radius);
        float at = -dot(from, normal) / against;
        vec3 p = from + direction * at;
        vec2 share = vec2(dot(p, u.xyz), dot(p, v.xyz));
        float border = BORDER + ROUNDING * u.w * abs(at);
        if (against < 0.0 && min(share.x, share.y) >= -border && share.x + share.y <= 1.0 + border) {
            first = min(first, at);
        }
    }
    return first;
}

// Shares of the three spheres in the interpolated sphere whose surface is nearest to a point, or that holds it deepest: the least
// of |p - c| - r, which is convex.
vec3 nearest(samplerBuffer solids, uint solid, vec3 p) {
    vec4 sines = fetch(solids, solid + SINES), squares = fetch(solids, solid + SQUARES);
    vec3 best = vec3(1.0, 0.0, 0.0);
    float least = FAR;
    for (uint k = 0u; k < 3u; k++) {
        vec4 ball = fetch(solids, solid + BALLS + k), side = fetch(solids, solid + SIDES + k);
        vec3 from = p - ball.xyz, share = vec3(0.0);
        // A normal of the cone is cos φ outwards and sin φ along.
        float y = dot(from, side.xyz), x = length(from - side.xyz * y);
        float s = side.w > 0.0 ? clamp(y - x * sines[k] / sqrt(squares[k]), 0.0, side.w) : 0.0;
        float away = length(from - side.xyz * s) - ball.w + sines[k] * s;
        if (away < least) {
            float t = side.w > 0.0 ? s / side.w : 0.0;
            share[k] = 1.0 - t;
            share[(k + 1u) % 3u] = t;
            least = away;
            best = share;
        }
    }
    // Shares of a plane do not change along its normal.
    vec3 from = p - fetch(solids, solid + BALLS).xyz;
    vec3 across = fetch(solids, solid + FACES).xyz - fetch(solids, solid + FACES + FACE_TEXELS).xyz;
    uint face = solid + FACES + (dot(from, across) < 0.0 ? FACE_TEXELS : 0u);
    vec2 share = vec2(dot(from, fetch(solids, face + 1u).xyz), dot(from, fetch(solids, face + 2u).xyz));
    if (fetch(solids, face).w > 0.0 && min(share.x, share.y) >= 0.0 && share.x + share.y <= 1.0) {
        best = vec3(1.0 - share.x - share.y, share);
    }
    return best;
}

// The sphere that has these shares.
vec4 ball_of(samplerBuffer solids, uint solid, vec3 share) {
    uint at = solid + BALLS;
    return share.x * fetch(solids, at) + share.y * fetch(solids, at + 1u) + share.z * fetch(solids, at + 2u);
}

// Its way in the frame.
vec3 way_of(samplerBuffer solids, uint solid, vec3 share) {
    uint at = solid + MOVES;
    return share.x * fetch(solids, at).xyz + share.y * fetch(solids, at + 1u).xyz + share.z * fetch(solids, at + 2u).xyz;
}

// The direction in which the surface is nearest: away from the nearest sphere's centre; on the axis one is as good as any across.
vec3 way_out(samplerBuffer solids, uint solid, vec3 from) {
    float away = length(from);
    if (away > 1e-6 * fetch(solids, solid).w) {
        return from / away;
    }
    vec4 normal = fetch(solids, solid + FACES);
    vec3 axis = fetch(solids, solid + SIDES).xyz;
    vec3 across = abs(axis.x) < 0.6 ? vec3(0.0, axis.z, -axis.y) : vec3(-axis.z, 0.0, axis.x);
    return normal.w > 0.0 ? normal.xyz : dot(across, across) > 0.0 ? across / length(across) : vec3(0.0, 1.0, 0.0);
}

#endif
