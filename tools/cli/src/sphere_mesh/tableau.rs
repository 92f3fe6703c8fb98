//! Levels in a frame, side by side: what each style shows of them.

use dermis::{
    Result,
    gpu::Gpu,
    mesh,
    render::{
        self, Background, Bounds, Camera, Picture, Projection, Renderer, Scene, Shading, Spheres,
    },
    sphere_mesh::{self, Hierarchy, Level, Shape, Skin},
};
use glam::{Quat, Vec3};

use super::render::{Look, Shot, Style};
use crate::render::Tile;

/// Radius of a skeleton's spheres against the diagonal of the sequence, where there are not many.
const JOINT: f64 = 0.008;
/// More spheres are drawn smaller, so that all of them cover the same area.
const MANY: f64 = 60.0;

/// Draws levels, all from the same distance.
pub(super) struct Tableau<'a> {
    hierarchy: &'a Hierarchy,
    levels: Vec<Level>,
    /// Of each sphere of each level.
    colours: Vec<Vec<Vec3>>,
    look: Look,
    renderer: Renderer,
    camera: Camera,
}

/// A mesh to be drawn.
#[derive(Default)]
struct Surface {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    colours: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl<'a> Tableau<'a> {
    /// With a camera that sees mesh and spheres in every shot.
    pub(super) fn open(
        gpu: &Gpu,
        hierarchy: &'a Hierarchy,
        levels: Vec<Level>,
        look: Look,
        shots: &[Shot],
    ) -> Result<Self> {
        let renderer = Renderer::new(gpu, look.size.0, look.size.1)?;
        let bounds = bounds(hierarchy, &levels, &look, shots)?;
        let projection = match look.orthographic {
            true => Projection::Orthographic { height: 0.0 },
            false => Projection::default(),
        };
        let colours = |level: &Level| {
            let near = (0..level.nodes.len()).map(|row| level.near.row(row));
            render::region_colours(near)
        };
        Ok(Self {
            camera: Camera::framing(&bounds, look.view, projection, renderer.aspect()),
            colours: levels.iter().map(colours).collect(),
            hierarchy,
            levels,
            look,
            renderer,
        })
    }

    pub(super) fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Rows of a sheet: one a level, but only one where a level is a single picture.
    pub(super) fn rows(&self) -> usize {
        let own = self.look.styles.iter().filter(|s| **s != Style::Mesh);
        if own.count() > 1 {
            self.levels.len()
        } else {
            1
        }
    }

    /// The extracted surfaces of the levels, where a style shows them.
    pub(super) fn prepare(&self, frame: usize) -> Result<Vec<Skin>> {
        let wanted = self.look.styles.contains(&Style::Extracted);
        let levels = self.levels.iter().filter(|_| wanted);
        let extract = |level| {
            let shape = Shape::new(self.hierarchy, level, frame);
            sphere_mesh::extract(&shape, self.look.cells)
        };
        levels.map(extract).collect()
    }

    /// A labelled picture of each style of each level; `several` shots tell theirs.
    pub(super) fn draw(
        &mut self,
        shot: Shot,
        extracted: &[Skin],
        several: bool,
    ) -> Result<Vec<Tile>> {
        let one_row = self.rows() == 1;
        let mut tiles = Vec::new();
        for row in 0..self.levels.len() {
            for style in self.look.styles.clone() {
                // The mesh is the same for all levels; in one row it is seen once.
                if style == Style::Mesh && row > 0 && one_row {
                    continue;
                }
                let picture = self.one(style, row, shot, extracted.get(row))?;
                tiles.push((self.label(style, row, shot, several), picture));
            }
        }
        Ok(tiles)
    }

    fn label(&self, style: Style, row: usize, shot: Shot, several: bool) -> String {
        let spheres = self.levels[row].nodes.len();
        let what = match style {
            Style::Mesh => format!("mesh, {}", self.hierarchy.vertices),
            _ => format!("{}, {spheres}", style.name()),
        };
        match several {
            false => what,
            true if shot.orbit != 0.0 => format!("{what}, {:.0} deg", shot.orbit),
            true => format!("{what}, frame {}", shot.frame),
        }
    }

    fn one(
        &mut self,
        style: Style,
        row: usize,
        shot: Shot,
        skin: Option<&Skin>,
    ) -> Result<Picture> {
        let level = &self.levels[row];
        let colours = &self.colours[row];
        let shape = shape(self.hierarchy, level, shot.frame, self.look.upright);
        let mut spheres = Spheres::default();
        let mut surface = Surface::default();
        match style {
            Style::Mesh => surface = self.mesh(shot.frame)?,
            Style::Regions => {
                let mesh = self.mesh(shot.frame)?;
                surface = regions(&mesh, &level.labels, colours)?;
            }
            Style::Skeleton => {
                let share = (MANY / shape.balls.len() as f64).sqrt().min(1.0);
                let radius = JOINT * share * self.hierarchy.diagonal;
                spheres.skeleton(&shape, colours, radius)?;
            }
            Style::Surface => spheres.surface(&shape, colours)?,
            Style::Extracted => {
                if let Some(skin) = skin {
                    surface = extracted(skin, self.look.upright)?;
                }
            }
        }
        let scene = Scene {
            positions: &surface.positions,
            normals: &surface.normals,
            colours: &surface.colours,
            triangles: &surface.triangles,
            camera: self.camera.orbit(shot.orbit),
            wireframe: false,
            background: Background::default(),
        };
        self.renderer.draw_with(&scene, &spheres)
    }

    /// The mesh of the sequence.
    fn mesh(&self, frame: usize) -> Result<Surface> {
        let positions = positions(self.hierarchy, frame, self.look.upright);
        clay(positions, self.hierarchy.triangles.clone())
    }
}

fn positions(hierarchy: &Hierarchy, frame: usize, upright: Quat) -> Vec<Vec3> {
    let vertices = 0..hierarchy.vertices;
    vertices
        .map(|v| upright * hierarchy.position(v, frame))
        .collect()
}

fn shape(hierarchy: &Hierarchy, level: &Level, frame: usize, upright: Quat) -> Shape {
    let mut shape = Shape::new(hierarchy, level, frame);
    let upright = upright.as_dquat();
    shape
        .balls
        .iter_mut()
        .for_each(|b| b.centre = upright * b.centre);
    shape
}

/// How far the mesh and the levels reach in all shots.
fn bounds(hierarchy: &Hierarchy, levels: &[Level], look: &Look, shots: &[Shot]) -> Result<Bounds> {
    let mut frames: Vec<usize> = shots.iter().map(|s| s.frame).collect();
    frames.sort_unstable();
    frames.dedup();
    let mut all = Vec::new();
    for frame in frames {
        all.push(Bounds::of(&positions(hierarchy, frame, look.upright)));
        for level in levels {
            let shape = shape(hierarchy, level, frame, look.upright);
            let colours = vec![Vec3::ONE; shape.balls.len()];
            let mut spheres = Spheres::default();
            spheres.loose(&shape.balls, &colours)?;
            all.push(spheres.bounds());
        }
    }
    let union = all.into_iter().reduce(|a, b| a.union(&b));
    let union = union.unwrap_or_else(|| Bounds::of(&[]));
    Ok(if look.turntable {
        union.turned()
    } else {
        union
    })
}

/// A mesh in one colour.
fn clay(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Surface> {
    let normals = mesh::normals(&positions, &triangles);
    let attributes = render::Attributes {
        normals: &normals,
        ..Default::default()
    };
    Ok(Surface {
        colours: render::colours(Shading::Skin, &attributes)?,
        positions,
        normals,
        triangles,
    })
}

fn regions(mesh: &Surface, labels: &[u32], colours: &[Vec3]) -> Result<Surface> {
    let cut = render::cut_regions(
        &mesh.positions,
        &mesh.normals,
        labels,
        &mesh.triangles,
        colours,
    )?;
    Ok(Surface {
        positions: cut.positions,
        normals: cut.normals,
        colours: cut.colours,
        triangles: cut.triangles,
    })
}

fn extracted(skin: &Skin, upright: Quat) -> Result<Surface> {
    let positions = skin.positions.iter().map(|p| upright * p.as_vec3());
    clay(positions.collect(), skin.triangles.clone())
}
