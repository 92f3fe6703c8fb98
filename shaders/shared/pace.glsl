// A skin keeps pace with its surroundings. Contacts and the iteration's momentum have no fixed point: left to itself a skin at
// rest trembles between states that are equally good. So what follows a slow motion follows it slowly, and settles instead.
//
// The stir of a vertex is how far the fields around it moved against its part, over the part's radius: in a sub-step for the
// iterations, in a frame for what ends it.
#ifndef DERMIS_PACE
#define DERMIS_PACE

const float BRISK = 0.05; // stir at which the iterations take whole steps
const float SWIFT = 0.15; // stir at which the skin is at once where it settles
const float LARGE_TURN = 6.0; // degrees of a joint at which all of the skin is at once where it settles
const float LEAST_PACE = 0.03;

// Share of an iteration's step. Quadratic: whole steps down to small motions, which contacts need to keep their sides.
float pace_of(float stir) {
    float s = stir / BRISK;
    return clamp(s * s, LEAST_PACE, 1.0);
}

// Share that the settled skin goes on of its way from the frame before. A joint that turns far in a frame changes contacts where
// nothing stirs, too.
float easing_of(float stir, float turn) {
    float s = turn / LARGE_TURN;
    return clamp(max(stir / SWIFT, s * s), LEAST_PACE, 1.0);
}

#endif
