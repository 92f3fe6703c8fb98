#version 460
#extension GL_GOOGLE_include_directive : require
// Skin under three soft lights that go with the camera and a sky that does not. Both sides are lit; the back has a
// colour of its own, so that inverted skin is seen at a glance.

#include "shared/skin.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 colour;
layout(location = 3) in vec3 barycentric;

layout(location = 0) out vec4 pixel;

const vec3 BACK = vec3(0.85, 0.03, 0.60);
const vec3 SKY = vec3(0.31, 0.335, 0.375);
const vec3 GROUND = vec3(0.12, 0.10, 0.095);

// Directions to the lights in the camera's axes: right, up, towards the viewer.
const vec3 KEY = normalize(vec3(-0.55, 0.65, 0.60));
const vec3 FILL = normalize(vec3(0.85, 0.05, 0.55));
const vec3 RIM = normalize(vec3(0.35, 0.55, -0.75));
const vec3 KEY_COLOUR = vec3(0.98, 0.93, 0.86);
const vec3 FILL_COLOUR = vec3(0.13, 0.15, 0.19);
const vec3 RIM_COLOUR = vec3(0.30, 0.31, 0.33);

// Light wraps past the terminator by `wrap`, squared so that it fades out softly.
float diffuse(vec3 n, vec3 light, float wrap) {
    float d = clamp((dot(n, light) + wrap) / (1 + wrap), 0, 1);
    return d * mix(1, d, wrap);
}

vec3 lit(vec3 albedo, vec3 n, vec3 view, vec3 n_model) {
    vec3 light = mix(GROUND, SKY, 0.5 + 0.5 * n_model.y);
    light += KEY_COLOUR * diffuse(n, KEY, 0.25);
    light += FILL_COLOUR * diffuse(n, FILL, 0.5);
    light += RIM_COLOUR * diffuse(n, RIM, 0.0);
    float grazing = pow(1 - clamp(dot(n, view), 0, 1), 4);
    float gloss = pow(clamp(dot(n, normalize(KEY + view)), 0, 1), 28);
    return albedo * light + 0.05 * gloss + 0.10 * grazing * SKY;
}

// How the surface bends along the picture, in normals turned per pixel: above 0 convex, below 0 concave.
float bend(vec3 n) {
    vec3 x = dFdx(position), y = dFdy(position);
    float curvature = dot(dFdx(n), x) / dot(x, x) + dot(dFdy(n), y) / dot(y, y);
    return curvature * length(fwidth(position));
}

vec3 to_srgb(vec3 c) {
    c = clamp(c, 0, 1);
    return mix(1.055 * pow(c, vec3(1 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

// Coverage of the nearest edge: barycentric distance over its screen-space slope is the distance in pixels.
float edge_cover(float width) {
    vec3 pixels = barycentric / max(fwidth(barycentric), vec3(1e-8));
    float nearest = min(pixels.x, min(pixels.y, pixels.z));
    return 1 - smoothstep(0.5 * width - 0.5, 0.5 * width + 0.5, nearest);
}

void main() {
    vec3 view = normalize(constants.eye.xyz - constants.eye.w * position);
    vec3 flat_normal = cross(dFdx(position), dFdy(position));
    vec3 n_model = dot(normal, normal) > 1e-12 ? normalize(normal) : normalize(flat_normal);
    n_model = gl_FrontFacing ? n_model : -n_model;
    mat3 axes = mat3(constants.right.xyz, constants.up.xyz, cross(constants.right.xyz, constants.up.xyz));
    vec3 albedo = gl_FrontFacing ? colour : BACK;
    // Less light gets into creases and a little more onto ridges; the former are what one looks for in skin.
    float ridge = clamp(6 * bend(n_model), -1, 1);
    albedo *= 1 + (ridge < 0 ? 0.35 : 0.07) * ridge;
    vec3 shaded = lit(albedo, n_model * axes, view * axes, n_model);
    if (constants.right.w > 0) {
        shaded = mix(shaded, constants.edge.rgb, constants.edge.a * edge_cover(constants.right.w));
    }
    pixel = vec4(to_srgb(shaded), 1);
}
