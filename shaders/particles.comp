// Particles fall for a frame and bounce off a sphere-mesh that moves (sphere-meshes 2016, section 6.1 and appendix B).
//
// A particle is a sphere. Each flight is the chord of its parabola, so that no energy is gained. Solids are met in the pose that the
// frame ends with: what moves with their surface stands still there, so that a particle has the solid's own way taken off its path,
// that of the interpolated sphere nearest to it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/solid.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform samplerBuffer particle_solids;
layout(set = 0, binding = 1, std430) buffer Particles { vec4 particle_position[]; }; // w: radius
layout(set = 0, binding = 2, std430) buffer Velocities { vec4 particle_velocity[]; }; // w: contacts so far
layout(push_constant) uniform Constants {
    vec3 gravity;
    float seconds; // of the frame
    float restitution;
    float friction;
    float size; // of the sphere-mesh
    uint count; // particles
    uint solids;
    uint contacts; // of a particle in a frame, at most
    uint carries; // rounds in which a particle's place on a solid is found; 0 where nothing moves
} constants;

// What counts as touching, against sizes and coordinates: less than that inside is on the surface.
const float TOUCH = 4e-6;
// Share of a way that goes inwards by rounding.
const float SLIDE = 1e-6;

struct Contact {
    uint solid; // NONE where nothing is met
    float time; // 0 to 1, of the flight
    vec3 carried; // the solid's own way during the flight
};
const uint NONE = 0xffffffffu;

float touch(vec3 p, float radius) {
    return TOUCH * (constants.size + radius + max(abs(p.x), max(abs(p.y), abs(p.z))));
}

// Number of the next solid from `row` on that a sphere may meet between `p` and the share `best` of `flight`.
uint next_near(uint row, vec3 p, vec3 flight, float radius, float best) {
    float square = max(dot(flight, flight), 1e-30);
    for (; row < constants.solids; row++) {
        vec4 bound = fetch(particle_solids, row * SOLID_TEXELS);
        float reach = bound.w + radius;
        vec3 from = bound.xyz - p;
        from -= flight * clamp(dot(from, flight) / square, 0.0, best);
        if (dot(from, from) <= reach * reach) {
            break;
        }
    }
    return row;
}

// The first solid that is met.
Contact meet(vec3 p, vec3 flight, float radius, float left) {
    Contact contact = Contact(NONE, 1.0, vec3(0.0));
    float slack = touch(p, radius), deepest = FAR;
    for (uint row = next_near(0u, p, flight, radius, 1.0); row < constants.solids;
         row = next_near(row + 1u, p, flight, radius, contact.time)) {
        uint solid = row * SOLID_TEXELS;
        vec3 carried = vec3(0.0);
        for (uint k = 0u; k < constants.carries; k++) {
            carried = left * way_of(particle_solids, solid, nearest(particle_solids, solid, p + carried));
        }
        vec3 start = p + carried, way = flight - carried;
        vec4 ball = ball_of(particle_solids, solid, nearest(particle_solids, solid, start));
        vec3 from = start - ball.xyz;
        float away = length(from) - ball.w - radius, far = length(way);
        if (away <= slack) {
            // On the surface or in: what goes out leaves a convex solid for good, and what slides along it is free.
            float inwards = -dot(way, way_out(particle_solids, solid, from));
            if (inwards > clamp(SLIDE * far, 0.0, max(slack + away, 0.0)) && ball.w + radius > slack && away < deepest) {
                deepest = away;
                contact = Contact(solid, 0.0, carried);
            }
        } else if (far > 0.0) {
            float at = enter(particle_solids, solid, start, way / far, radius) / far;
            if (at >= 0.0 && at <= contact.time) {
                contact = Contact(solid, at, carried);
            }
        }
    }
    return contact;
}

// What is left of a velocity relative to the surface after a contact, and of the pull for the rest of the frame: of the normal part
// the share of the restitution, of the rest what Coulomb's friction leaves. A bounce that the pull would end within the frame is
// none: the surface bears the particle.
void bounce(vec3 normal, float seconds, inout vec3 velocity, inout vec3 pull) {
    float before = dot(velocity, normal), press = max(-dot(pull, normal), 0.0);
    vec3 slide = velocity - before * normal;
    float after = -constants.restitution * min(before, 0.0), given = after - min(before, 0.0);
    if (2.0 * after <= press * seconds) {
        given += press * seconds - after;
        after = 0.0;
        pull += press * normal;
    }
    float slip = length(slide);
    velocity = slide * (slip > 0.0 ? max(1.0 - constants.friction * given / slip, 0.0) : 0.0) + after * normal;
}

// The solid that holds a sphere deepest; NONE where none does by more than touching.
uint holding(vec3 p, float radius) {
    float deepest = -touch(p, radius);
    uint found = NONE;
    for (uint row = next_near(0u, p, vec3(0.0), radius, 0.0); row < constants.solids;
         row = next_near(row + 1u, p, vec3(0.0), radius, 0.0)) {
        uint solid = row * SOLID_TEXELS;
        vec4 ball = ball_of(particle_solids, solid, nearest(particle_solids, solid, p));
        float away = length(p - ball.xyz) - ball.w - radius;
        if (away < deepest) {
            deepest = away;
            found = solid;
        }
    }
    return found;
}

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= constants.count) {
        return;
    }
    vec4 position = particle_position[row], velocity = particle_velocity[row];
    vec3 p = position.xyz, v = velocity.xyz, pull = constants.gravity, resting = p;
    float radius = position.w, left = 1.0, contacts = velocity.w;
    for (uint k = 0u; k < constants.contacts && left > 0.0; k++) {
        float seconds = left * constants.seconds;
        vec3 flight = (v + 0.5 * seconds * pull) * seconds;
        Contact contact = meet(p, flight, radius, left);
        v += contact.time * seconds * pull;
        if (contact.solid == NONE) {
            p += flight;
            left = 0.0;
        } else {
            // Where it is met in the final pose, to rounding; then where that is now.
            vec3 spot = p + contact.carried + contact.time * (flight - contact.carried);
            vec3 share = nearest(particle_solids, contact.solid, spot);
            vec4 ball = ball_of(particle_solids, contact.solid, share);
            vec3 normal = way_out(particle_solids, contact.solid, spot - ball.xyz);
            if (ball.w + radius <= touch(spot, radius) && dot(normal, flight - contact.carried) > 0.0) {
                normal = -normal; // a point on a sheet without thickness: on the side that it came from
            }
            resting = ball.xyz + (ball.w + radius) * normal;
            p = resting - (1.0 - contact.time) * contact.carried;
            left *= 1.0 - contact.time;
            vec3 surface = way_of(particle_solids, contact.solid, share) / constants.seconds;
            v -= surface;
            bounce(normal, left * constants.seconds, v, pull);
            v += surface;
            contacts += 1.0;
        }
    }
    // After its last contact the surface takes it along.
    p = left > 0.0 ? resting : p;

    // Out of everything along the normal of the solid that holds it deepest. Solids are convex: none is left twice.
    uint held = holding(p, radius);
    if (held != NONE) {
        vec4 ball = ball_of(particle_solids, held, nearest(particle_solids, held, p));
        vec3 direction = way_out(particle_solids, held, p - ball.xyz), start = p;
        float way = 0.0;
        uint last = held;
        for (uint k = 0u; k <= constants.solids && held != NONE; k++) {
            // Where the line leaves is where it enters from the other end.
            vec4 bound = fetch(particle_solids, held);
            float beyond = dot(bound.xyz - start, direction) + 2.0 * (bound.w + radius);
            way = max(way, beyond - enter(particle_solids, held, start + beyond * direction, -direction, radius));
            p = start + way * direction;
            last = held;
            held = holding(p, radius);
        }
        vec3 share = nearest(particle_solids, last, p);
        ball = ball_of(particle_solids, last, share);
        vec3 normal = way_out(particle_solids, last, p - ball.xyz);
        vec3 surface = way_of(particle_solids, last, share) / constants.seconds;
        float inwards = min(dot(v - surface, normal), 0.0);
        v -= (1.0 + constants.restitution) * inwards * normal;
        contacts += 1.0;
    }
    particle_position[row] = vec4(p, radius);
    particle_velocity[row] = vec4(v, contacts);
}
