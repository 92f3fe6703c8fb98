//! Offscreen pictures of deformed characters and of sphere-meshes.
//!
//! Data flow: attributes of a skin → [`colours`] → [`Scene`] → [`Renderer::draw`] → [`Picture`] → [`sheet`].
//! Sphere-meshes and loose spheres are collected in [`Spheres`] and drawn into a scene by [`Renderer::draw_with`].
//! Nothing here writes files: a picture is pixels, and who asked for it encodes them.

mod camera;
mod colour;
mod font;
mod legend;
mod picture;
mod regions;
mod renderer;
mod sphere_pass;
mod spheres;

pub use camera::{Bounds, Camera, Projection, View};
pub use colour::{Attributes, ERROR_SCALE, STATES, Shading, colours};
pub use legend::legend;
pub use picture::{Picture, sheet};
pub use regions::{Cut, cut_regions, region_colours};
pub use renderer::{Background, Renderer, Scene};
pub use spheres::Spheres;

#[cfg(test)]
mod sphere_tests;
#[cfg(test)]
mod tests;
