#version 460
#extension GL_GOOGLE_include_directive : require
// Where the ray through a sample meets a sphere, the cone between two spheres or a face of the slab between three.
// Conditions are written so that what is not a number fails them: such a sample is not drawn.

#include "shared/light.glsl"
#include "shared/spheres.glsl"

layout(location = 0) flat in vec4 ball[3];
layout(location = 3) flat in vec4 colour[3];
layout(location = 6) flat in uint count;
layout(location = 7) flat in vec3 face;

layout(location = 0) out vec4 pixel;

// A point of the surface, its unit normal and how much each sphere has to do with it.
struct Hit {
    bool found;
    vec3 position;
    vec3 normal;
    vec3 weights;
};

const Hit MISS = Hit(false, vec3(0), vec3(0), vec3(0));

struct Ray {
    vec3 from;
    vec3 along;
};

Ray ray_of_sample() {
    vec2 at = gl_FragCoord.xy * constants.pixel.xy - 1;
    vec3 across = at.x * constants.right.w * constants.right.xyz - at.y * constants.up.w * constants.up.xyz;
    vec3 front = cross(constants.up.xyz, constants.right.xyz);
    if (constants.eye.w > 0) {
        return Ray(constants.eye.xyz, normalize(front + across));
    }
    return Ray(constants.eye.xyz + across, front);
}

// The ray from its point next to `there`, so that the numbers near the solid are small.
Ray near(Ray ray, vec3 there) {
    return Ray(ray.from + dot(there - ray.from, ray.along) * ray.along, ray.along);
}

Hit of_ball(Ray ray) {
    vec3 side = near(ray, ball[0].xyz).from - ball[0].xyz;
    float square = ball[0].w * ball[0].w - dot(side, side);
    if (!(square > 0)) {
        return MISS;
    }
    vec3 out_there = side - sqrt(square) * ray.along;
    return Hit(true, ball[0].xyz + out_there, normalize(out_there), vec3(1, 0, 0));
}

// With sin = (r0 - r1) / |c0 c1| a point at y along the axis and x beside it is on the cone through the circles where it
// touches the spheres if cos x = r0 - sin y, and the sphere that it belongs to is at (y - r0 sin) / cos² along the axis.
Hit of_cone(Ray ray) {
    vec3 axis = ball[1].xyz - ball[0].xyz;
    float distance = length(axis);
    float sine = (ball[0].w - ball[1].w) / distance;
    if (!(abs(sine) < 1)) {
        return MISS; // one sphere holds the other
    }
    axis /= distance;
    float cosine2 = (1 - sine) * (1 + sine);
    float dy = dot(ray.along, axis);
    vec3 dx = ray.along - dy * axis;
    vec3 start = near(ray, 0.5 * (ball[0].xyz + ball[1].xyz)).from - ball[0].xyz;
    // From there on to the point next to the axis, but not far away where they are almost parallel.
    float dx2 = dot(dx, dx);
    start -= clamp(dot(start - dot(start, axis) * axis, dx) / max(dx2, 1e-12), -distance, distance) * ray.along;
    float y = dot(start, axis);
    vec3 x = start - y * axis;
    float r = ball[0].w - sine * y;
    float a = cosine2 * dx2 - sine * sine * dy * dy;
    float b = cosine2 * dot(x, dx) + sine * dy * r;
    float c = cosine2 * dot(x, x) - r * r;
    float root = b * b - a * c;
    if (!(root > 0)) {
        return MISS;
    }
    float q = -(b + (b < 0 ? -1 : 1) * sqrt(root));
    float t[2] = float[2](q / a, c / q);
    Hit best = MISS;
    float nearest = 0;
    for (int i = 0; i < 2; i++) {
        float scaled = r - sine * dy * t[i]; // x cos
        float share = (y + dy * t[i] - ball[0].w * sine) / (cosine2 * distance);
        if (!(scaled > 0 && share >= 0 && share <= 1 && (!best.found || t[i] < nearest))) {
            continue;
        }
        vec3 normal = (x + t[i] * dx) * (cosine2 / scaled) + sine * axis;
        if (dot(normal, ray.along) < 0) {
            best = Hit(true, ball[0].xyz + start + t[i] * ray.along, normalize(normal), vec3(1 - share, share, 0));
            nearest = t[i];
        }
    }
    return best;
}

// The face is a triangle; rounding may put the ray beside it, but not the hit.
Hit of_face(Ray ray) {
    float slope = dot(face, ray.along);
    if (!(slope < 0)) {
        return MISS; // the back of a face is inside
    }
    vec3 corner = ball[0].xyz + ball[0].w * face;
    vec3 b = ball[1].xyz + ball[1].w * face - corner;
    vec3 c = ball[2].xyz + ball[2].w * face - corner;
    Ray close = near(ray, corner + (b + c) / 3);
    vec3 p = close.from + dot(corner - close.from, face) / slope * ray.along - corner;
    vec3 across = cross(b, c);
    float square = max(dot(across, across), 1e-30);
    vec2 share = vec2(dot(cross(p, c), across), dot(cross(b, p), across)) / square;
    share = clamp(share, 0, 1);
    share /= max(share.x + share.y, 1);
    return Hit(true, corner + share.x * b + share.y * c, face, vec3(1 - share.x - share.y, share));
}

// Each point has the colour of the sphere that has most to do with it.
vec4 colour_of(vec3 weights) {
    int most = weights.y > weights.x ? 1 : 0;
    return colour[weights.z > weights[most] ? 2 : most];
}

void main() {
    Ray ray = ray_of_sample();
    Hit hit = count == 1 ? of_ball(ray) : count == 2 ? of_cone(ray) : of_face(ray);
    vec4 clip = constants.clip_from_model * vec4(hit.position, 1);
    if (!(hit.found && clip.w > 0 && clip.z >= 0 && clip.z <= clip.w)) {
        discard;
    }
    gl_FragDepth = clip.z / clip.w;
    mat3 axes = mat3(constants.right.xyz, constants.up.xyz, cross(constants.right.xyz, constants.up.xyz));
    vec4 albedo = colour_of(hit.weights);
    vec3 shaded = lit(albedo.rgb, hit.normal * axes, -ray.along * axes, hit.normal);
    pixel = vec4(to_srgb(shaded), albedo.a);
}
