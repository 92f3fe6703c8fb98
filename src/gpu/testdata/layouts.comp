// Every kind of member that push constants of dermis may have, and a binding outside set 0.
#version 460
layout(local_size_x = 2, local_size_y = 3, local_size_z = 5) in;
struct Inner { vec2 a; float b; };
layout(push_constant) uniform Constants { mat4 m; vec3 v; float f; Inner inner[2]; uint last; };
layout(std430, set = 1, binding = 7) buffer Values { float values[]; };
void main() {
    values[0] = m[0].x + v.x + f + inner[1].b + float(last);
}
