//! Twin of `shaders/shared/boxes.glsl`, `around.glsl` and `field.glsl`: boxes, the fields around a point, the composed field and its gradient.

use glam::{Vec3, Vec4, Vec4Swizzles};

use crate::{
    layout::{
        CELLS, FieldPose, FieldsHead, NO_MOTION, OPENING_ROWS, composition, unpack,
        unpack_last_cell,
    },
    twin::{Args, Image, cast},
};

const NULL_GRADIENT: f32 = 1e-6;
const UNION: u32 = 0;
/// Lesser fields leave others as they are.
const FAINT: f32 = 1e-5;
/// How far in a contact sheet a place is in contact.
pub const IN_CONTACT: f32 = 0.5;
/// Over which share of a box a field fades out, inverted.
const FADING: f32 = 8.0;
/// Number of the contact operator.
const CONTACT: u32 = 1;

/// The first three bindings of a composed field: where its fields are.
#[derive(Clone, Copy)]
pub struct Boxes<'a> {
    head: FieldsHead,
    fields: &'a [FieldPose],
    index: &'a [u32],
}

impl<'a> Boxes<'a> {
    /// Reads the bindings, from `first` on.
    pub fn new(args: &Args<'a>, first: usize) -> Self {
        let words = args.read::<u32>(first);
        let head = size_of::<FieldsHead>() / 4;
        Self {
            head: cast(&words[..head])[0],
            fields: cast(&words[head..]),
            index: args.read(first + 2),
        }
    }

    /// The skin is carried on in this step.
    pub fn is_carried(&self) -> bool {
        self.head.turn[1] != 0.0
    }

    /// Model units a rest unit.
    pub fn scale(&self) -> f32 {
        self.head.box_scale[3]
    }

    /// Number of the fields whose boxes hold `x`.
    pub fn around(&self, x: Vec3) -> u32 {
        let held = self.near(x).filter(|i| self.place(*i, x).is_some());
        held.count() as u32
    }

    /// The same where all of them have this motion since the pose before; 0 where one has another.
    pub fn moving_as(&self, motion: u32, x: Vec3) -> u32 {
        self.all_of(motion, |field| field.tile, x)
    }

    /// The same for motions since rest.
    pub fn moved_as(&self, motion: u32, x: Vec3) -> u32 {
        self.all_of(motion, |field| field.first_cell, x)
    }

    fn all_of(&self, motion: u32, word: impl Fn(&FieldPose) -> u32, x: Vec3) -> u32 {
        let mut held = self.near(x).filter(|i| self.place(*i, x).is_some());
        let as_one = held.all(|i| word(&self.fields[i]) >> 24 == motion);
        if as_one && motion != NO_MOTION {
            self.around(x)
        } else {
            0
        }
    }

    /// How far the fields around `x` moved against what `x` was carried by, where `moved` tells to where a joint's change
    /// carries the place before; a field that moves like nothing else counts as `far`.
    pub fn stir(&self, x: Vec3, far: f32, moved: impl Fn(u32) -> Vec3) -> f32 {
        let of = |i: usize| {
            let field = &self.fields[i];
            let at = self.in_box(i, x);
            let presence = (FADING * at.min(1.0 - at).min_element()).clamp(0.0, 1.0);
            let (_, joint) = unpack_last_cell(field.last_cell);
            let apart = if field.tile >> 24 == NO_MOTION {
                far
            } else {
                moved(joint).distance(x)
            };
            presence * apart
        };
        self.near(x).map(of).fold(0.0, f32::max)
    }

    /// Fields in the index cell that holds `x`, ascending.
    fn near(&self, x: Vec3) -> impl Iterator<Item = usize> {
        let words = self.cell(x).unwrap_or(&[]);
        words.iter().enumerate().flat_map(|(word, &bits)| {
            let set = (0..32).filter(move |bit| bits >> bit & 1 != 0);
            set.map(move |bit| word * 32 + bit)
        })
    }

    /// Mask words of the cell that holds `x`.
    fn cell(&self, x: Vec3) -> Option<&'a [u32]> {
        let origin = Vec3::from_slice(&self.head.grid_origin);
        let at = (x - origin) * Vec3::from_slice(&self.head.grid_inverse);
        if !(at.cmpge(Vec3::ZERO).all() && at.cmplt(Vec3::splat(CELLS as f32)).all()) {
            return None;
        }
        let c = at.as_uvec3();
        let words = self.head.grid_origin[3] as usize;
        let first = ((c.z * CELLS + c.y) * CELLS + c.x) as usize * words;
        Some(&self.index[first..first + words])
    }

    /// Box coordinates of `x` in field `i`.
    fn in_box(&self, i: usize, x: Vec3) -> Vec3 {
        let rows = self.fields[i].rows.map(Vec4::from_array);
        Vec3::from_array(rows.map(|r| r.truncate().dot(x) + r.w))
    }

    /// The same, where its box holds `x`.
    fn place(&self, i: usize, x: Vec3) -> Option<Vec3> {
        let at = self.in_box(i, x);
        (at == at.clamp(Vec3::ZERO, Vec3::ONE)).then_some(at)
    }
}

/// The six bindings that every pass with a composed field has, from `first` on.
#[derive(Clone, Copy)]
pub struct Composite<'a> {
    boxes: Boxes<'a>,
    atlas: &'a Image,
    operators: &'a Image,
    opening: &'a [f32],
    composition: u32,
}

impl<'a> Composite<'a> {
    /// Reads the bindings.
    pub fn new(args: &Args<'a>, first: usize) -> Self {
        Self {
            boxes: Boxes::new(args, first),
            atlas: args.image(first + 3),
            operators: args.image(first + 4),
            opening: args.read(first + 5),
            composition: args.variant(),
        }
    }

    /// Model units a rest unit.
    pub fn scale(&self) -> f32 {
        self.boxes.scale()
    }

    /// The furthest that any joint turns in the frame, degrees.
    pub fn turn(&self) -> f32 {
        self.boxes.head.turn[3]
    }

    /// Number of the fields whose boxes hold `x`.
    pub fn around(&self, x: Vec3) -> u32 {
        self.boxes.around(x)
    }

    /// f and its gradient at `x` in model space; counts texture fetches.
    pub fn evaluate(&self, x: Vec3, fetches: &mut u32) -> (f32, Vec3) {
        let mut tally = Tally::default();
        let f = self.composed(x, &mut tally);
        *fetches += tally.fetches;
        (f.x, gradient(f))
    }

    /// f and its gradient, and how far `x` lies in a contact sheet: depth of the contact, times the lesser field over the
    /// greater.
    pub fn evaluate_sheet(&self, x: Vec3) -> ((f32, Vec3), f32) {
        let mut tally = Tally::default();
        let f = self.composed(x, &mut tally);
        ((f.x, gradient(f)), tally.sheet)
    }

    fn composed(&self, x: Vec3, tally: &mut Tally) -> Vec4 {
        if self.composition >= composition::CONTACTS {
            self.fold(x, tally)
        } else {
            self.greatest(x, &mut tally.fetches)
        }
    }

    fn greatest(&self, x: Vec3, fetches: &mut u32) -> Vec4 {
        let mut best = Vec4::ZERO;
        for i in self.boxes.near(x) {
            let s = self.at_joint(i, x, fetches);
            if s.x > best.x {
                best = s;
            }
        }
        best
    }

    /// The walk over the leaves; a leaf's group goes into the total when the next group begins.
    fn fold(&self, x: Vec3, tally: &mut Tally) -> Vec4 {
        let (mut total, mut group) = (Vec4::ZERO, Vec4::ZERO);
        let (mut of, mut depth) = (0xff, 0);
        for i in self.boxes.near(x) {
            if self.boxes.place(i, x).is_none() {
                continue;
            }
            let s = self.sample(i, x, &mut tally.fetches);
            let link = self.boxes.fields[i].link;
            let [own, against, kind, curve] = link.to_le_bytes().map(u32::from);
            if self.composition == composition::CONTACTS {
                total = self.meet(CONTACT, against, total, s, tally);
            } else if own == of {
                group = self.meet(kind, curve, group, s, tally);
            } else {
                total = self.meet(CONTACT, depth, total, group, tally);
                (group, of, depth) = (s, own, against);
            }
        }
        if self.composition == composition::CONTACTS {
            total
        } else {
            self.meet(CONTACT, depth, total, group, tally)
        }
    }

    /// Contact of two samples to a depth that a controller gives.
    fn meet(&self, kind: u32, curve: u32, a: Vec4, b: Vec4, tally: &mut Tally) -> Vec4 {
        let (ga, gb) = (gradient(a), gradient(b));
        let lengths = (ga.length_squared() * gb.length_squared()).sqrt();
        let defined = lengths > NULL_GRADIENT * NULL_GRADIENT;
        let cosine = if defined { ga.dot(gb) / lengths } else { 1.0 };
        let inside = (10.0 * (0.9 - a.x.min(b.x))).clamp(0.0, 1.0);
        let depth = inside * self.on_curve(curve, cosine);
        let (least, most) = (a.x.min(b.x), a.x.max(b.x));
        tally.sheet = tally.sheet.max(depth * least / most.max(FAINT));
        let g = self.operate(kind, a.x, b.x, depth, &mut tally.fetches);
        if b.x < FAINT {
            a
        } else if a.x < FAINT {
            b
        } else {
            (g[1] * ga + g[2] * gb).extend(g[0]).wxyz()
        }
    }

    /// Field `i`, combined with its parent where their joint has an operator other than the union.
    fn at_joint(&self, i: usize, x: Vec3, fetches: &mut u32) -> Vec4 {
        let s = self.sample(i, x, fetches);
        let link = self.boxes.fields[i].link;
        let kind = (link >> 16) & 0xff;
        if kind != UNION && s.x > 0.0 {
            let parent = self.sample((link & 0xffff) as usize, x, fetches);
            if parent.x > 0.0 {
                return self.combine(kind, link >> 24, s, parent, fetches);
            }
        }
        s
    }

    fn sample(&self, i: usize, x: Vec3, fetches: &mut u32) -> Vec4 {
        let Some(at) = self.boxes.place(i, x) else {
            return Vec4::ZERO;
        };
        let pose = &self.boxes.fields[i];
        let rows = pose.rows.map(Vec4::from_array);
        *fetches += 1;
        // Texel i of a tile of 32 lies at box coordinate i / 31.
        let tile = (Vec3::from(unpack(pose.tile).map(|t| t as f32)) * 32.0 + 0.5) / 31.0;
        let scale = Vec3::from_slice(&self.boxes.head.box_scale);
        let t = self.atlas.sample(((tile + at) * scale).to_array());
        let g = t[1] * rows[0].truncate() + t[2] * rows[1].truncate() + t[3] * rows[2].truncate();
        Vec4::new(t[0], g.x, g.y, g.z)
    }

    fn combine(&self, kind: u32, curve: u32, a: Vec4, b: Vec4, fetches: &mut u32) -> Vec4 {
        let (ga, gb) = (gradient(a), gradient(b));
        let (la, lb) = (ga.length(), gb.length());
        if la.min(lb) < NULL_GRADIENT {
            return if a.x >= b.x { a } else { b };
        }
        let angle = self.on_curve(curve, ga.dot(gb) / (la * lb));
        let g = self.operate(kind, a.x, b.x, angle, fetches);
        (g[1] * ga + g[2] * gb).extend(g[0]).wxyz()
    }

    /// Operator number `kind` at two values and a third coordinate.
    fn operate(&self, kind: u32, a: f32, b: f32, third: f32, fetches: &mut u32) -> [f32; 4] {
        let at = Vec3::new(a, b, third).clamp(Vec3::ZERO, Vec3::ONE) * 127.0 + 0.5;
        let z = at.z + 128.0 * (kind - 1) as f32;
        let size = self.operators.extent.map(|e| e as f32);
        *fetches += 1;
        let place = [at.x / size[0], at.y / size[1], z / size[2]];
        self.operators.sample(place)
    }

    /// A curve's table at the cosine of an angle between two gradients.
    fn on_curve(&self, curve: u32, cosine: f32) -> f32 {
        let at = (cosine * 0.5 + 0.5).clamp(0.0, 1.0) * (OPENING_ROWS - 1) as f32;
        let row = (at as usize).min(OPENING_ROWS - 2);
        let base = curve as usize * OPENING_ROWS + row;
        let t = at - row as f32;
        self.opening[base] * (1.0 - t) + self.opening[base + 1] * t
    }
}

/// What an evaluation tells besides.
#[derive(Default)]
struct Tally {
    fetches: u32,
    sheet: f32,
}

/// ∇f of a sample (f, ∇f).
fn gradient(sample: Vec4) -> Vec3 {
    sample.yzw()
}
