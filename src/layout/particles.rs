//! What `shaders/particles.comp` reads of a sphere-mesh that moves (`shaders/shared/solid.glsl`): same fields, same order.

use bytemuck::{Pod, Zeroable};

/// A sphere, a capsule or a thick triangle, in the pose that the frame ends with: 18 texels. A capsule has its second sphere
/// twice, a sphere itself three times.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Primitive {
    /// A sphere around it in all the frame: centre, radius.
    pub bound: [f32; 4],
    /// Its spheres: centre, radius.
    pub balls: [[f32; 4]; 3],
    /// How far each comes in the frame; 0.
    pub moves: [[f32; 4]; 3],
    /// The cone from each sphere to the next: unit axis, length; zeros where there is none.
    pub sides: [[f32; 4]; 3],
    /// Of each cone the sine of φ, the angle by which its normals lean along the axis; 0.
    pub sines: [f32; 4],
    /// Of each cone cos² φ; 0.
    pub squares: [f32; 4],
    /// The two planes that touch all spheres.
    pub faces: [Face; 2],
}

/// A plane that touches three spheres; zeros where there is none.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Face {
    /// Unit normal, outwards; 1.
    pub normal: [f32; 4],
    /// Times a place relative to the first sphere's centre: share of the second sphere; how much the shares grow with a place at
    /// most.
    pub u: [f32; 4],
    /// The same for the third sphere; 0.
    pub v: [f32; 4],
}
