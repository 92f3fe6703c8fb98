//! Twin of `shaders/shared/pace.glsl`.

const BRISK: f32 = 0.05;
const SWIFT: f32 = 0.15;
const LARGE_TURN: f32 = 6.0;
const LEAST_PACE: f32 = 0.03;

/// Share of an iteration's step.
pub fn pace_of(stir: f32) -> f32 {
    let s = stir / BRISK;
    (s * s).clamp(LEAST_PACE, 1.0)
}

/// Share that the settled skin goes on of its way from the frame before.
pub fn easing_of(stir: f32, turn: f32) -> f32 {
    let s = turn / LARGE_TURN;
    (stir / SWIFT).max(s * s).clamp(LEAST_PACE, 1.0)
}
