// Samples every field's HRBF into its tile of the atlas: f = w(s) t_r(d) and its derivatives by the box coordinates.
// Texel i of a tile lies at box coordinate i / 31. Implicit skinning 2013, section 4.1, Eq. 1 with φ(t) = t³.
#version 460
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;

const uint GRID = 32u;

struct GridField {
    vec3 origin; // box coordinate (0,0,0); all in the HRBF's scaled coordinates
    float radius;
    vec3 edge_x; // box edges
    uint first_center;
    vec3 edge_y;
    uint centers;
    vec3 edge_z;
    uint first_segment;
    uvec3 tile;
    uint segments;
};

layout(set = 0, binding = 0, std430) readonly buffer Fields { GridField fields[]; };
layout(set = 0, binding = 1, std430) readonly buffer Centers { vec4 centers[]; }; // position and λ, β
layout(set = 0, binding = 2, std430) readonly buffer Segments { vec4 segments[]; }; // start, end
layout(set = 0, binding = 3, rgba16f) writeonly uniform image3D atlas;
layout(push_constant) uniform Constants {
    vec2 fade; // distances from the bone, in radii
    float snap; // lesser values become 0
} constants;

// Distance to the nearest segment, and the direction away from it.
vec4 from_bone(uint first, uint count, vec3 x) {
    float least = 3.402823466e38;
    vec3 away = vec3(0.0);
    for (uint i = first; i < first + count; i++) {
        vec3 start = segments[2u * i].xyz;
        vec3 axis = segments[2u * i + 1u].xyz - start;
        float t = dot(x - start, axis) / max(dot(axis, axis), 1e-30);
        vec3 from = x - start - clamp(t, 0.0, 1.0) * axis;
        float s = length(from);
        if (s < least) {
            least = s;
            away = from;
        }
    }
    return vec4(least > 0.0 ? away / least : vec3(0.0), least);
}

// ∇d and d.
vec4 hrbf(uint first, uint count, vec3 x) {
    float d = 0.0;
    vec3 gradient = vec3(0.0);
    for (uint i = first; i < first + count; i++) {
        vec4 center = centers[2u * i];
        vec3 beta = centers[2u * i + 1u].xyz;
        vec3 delta = x - center.xyz;
        float t = length(delta);
        float along = dot(beta, delta);
        d += t * (center.w * t * t + 3.0 * along);
        float radial = t > 0.0 ? along / t : 0.0;
        gradient += 3.0 * ((center.w * t + radial) * delta + t * beta);
    }
    return vec4(gradient, d);
}

void main() {
    GridField field = fields[gl_GlobalInvocationID.z / GRID];
    uvec3 texel = uvec3(gl_GlobalInvocationID.xy, gl_GlobalInvocationID.z % GRID);
    vec3 at = vec3(texel) / float(GRID - 1u);
    vec3 x = field.origin + at.x * field.edge_x + at.y * field.edge_y + at.z * field.edge_z;

    vec4 bone = from_bone(field.first_segment, field.segments, x);
    vec4 distance = hrbf(field.first_center, field.centers, x);

    float u = clamp(distance.w / field.radius, -1.0, 1.0);
    float q = u * u;
    float remapped = ((-0.1875 * q + 0.625) * q - 0.9375) * u + 0.5;
    float remap_slope = -0.9375 * (1.0 - q) * (1.0 - q) / field.radius;

    float width = (constants.fade.y - constants.fade.x) * field.radius;
    float v = clamp((constants.fade.y * field.radius - bone.w) / width, 0.0, 1.0);
    float weight = v * v * (3.0 - 2.0 * v);
    float weight_slope = -6.0 * v * (1.0 - v) / width;

    float f = weight * remapped;
    vec3 gradient = weight * remap_slope * distance.xyz + weight_slope * remapped * bone.xyz;
    vec4 value = vec4(f, dot(gradient, field.edge_x), dot(gradient, field.edge_y), dot(gradient, field.edge_z));
    imageStore(atlas, ivec3(field.tile * GRID + texel), f < constants.snap ? vec4(0.0) : value);
}
