// Three soft lights that go with the camera and a sky that does not.

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

vec3 to_srgb(vec3 c) {
    c = clamp(c, 0, 1);
    return mix(1.055 * pow(c, vec3(1 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}
