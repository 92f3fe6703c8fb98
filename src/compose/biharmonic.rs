//! Biharmonic interpolation of one slice of an operator (2014, section 4.2), without a factorisation of its grid.
//!
//! On a grid of m by m cells the slice g minimises the sum of (L g)² over all vertices with f1 < 1 and f2 < 1, L being the 5-point
//! Laplacian times the cell's area, with the sides of Eq. 1. Beyond an axis the grid is mirrored (the normal derivative is 0), so that
//! L g = 2 (g(1, j) - g(0, j)) at vertex (0, j): g(0, ·) = f2 is linear and adds nothing.
//!
//! Three facts make this a small dense problem:
//! - f1 + f2 - f1 f2 meets Eq. 1 and is discretely harmonic. Write g = f1 + f2 - f1 f2 + v with v = 0 on the sides.
//! - The energy at the inner vertices is |S v|², S being the Laplacian with zero sides, diagonal in sines:
//!   s_a = √(2/m) sin(π a i/m), eigenvalues -(μ_a + μ_b), μ_a = 4 sin²(π a/2m). So S⁻² is known: the kernel
//!   K((i,j), (k,l)) = Σ_ab s_a(i) s_a(k) s_b(j) s_b(l) / (μ_a + μ_b)².
//! - All else is a handful of *conditions*: on the axes' neighbours, 4 (g(1, j) - f2)² of energy each; on the profile, g = 0.5.
//!   With c_p v the left side of condition p, r_p its value and 1/ε_p its weight in the energy, stationarity gives v = K Cᵀ λ with
//!   (C K Cᵀ + diag ε) λ = r: some 400 unknowns, dense, symmetric, positive definite.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::{
    condition::{Condition, Tap, axes, pinned},
    pins::Pin,
};

/// What all slices of one grid share.
pub(super) struct Biharmonic {
    cells: usize,
    /// M(u, v) = Σ_ab cos(π a u/m) cos(π b v/m) / (μ_a + μ_b)² / m², u and v from 0 to m.
    images: DMatrix<f64>,
    /// s_a(i) for a and i from 1 to m - 1: symmetric and its own inverse.
    sines: DMatrix<f64>,
    /// 1 / (μ_a + μ_b)².
    inverse: DMatrix<f64>,
}

impl Biharmonic {
    /// A grid of `cells` by `cells`.
    pub(super) fn new(cells: usize) -> Self {
        let m = cells as f64;
        let turn = |i: usize, a: usize| std::f64::consts::PI * (i * a % (2 * cells)) as f64 / m;
        let mu = |a: usize| 4.0 * (turn(1, a) * 0.5).sin().powi(2);
        let inner = cells - 1;
        let inverse = DMatrix::from_fn(inner, inner, |a, b| (mu(a + 1) + mu(b + 1)).powi(-2));
        let sines = DMatrix::from_fn(inner, inner, |i, a| {
            (2.0 / m).sqrt() * turn(i + 1, a + 1).sin()
        });
        let cosines = DMatrix::from_fn(cells + 1, inner, |u, a| turn(u, a + 1).cos() / m);
        let images = &cosines * &inverse * cosines.transpose();
        Self {
            cells,
            images,
            sines,
            inverse,
        }
    }

    /// g at the vertices, row i being f1 = i / cells and column j f2 = j / cells; none where rounding made the system indefinite.
    pub(super) fn slice(&self, pins: &[Pin]) -> Option<DMatrix<f64>> {
        let mut conditions = axes(self.cells);
        conditions.extend(pins.iter().map(|pin| pinned(pin, self.cells)));
        let count = conditions.len();
        // Only the lower triangle is read.
        let mut system = DMatrix::zeros(count, count);
        for (p, condition) in conditions.iter().enumerate() {
            for (q, other) in conditions[p..].iter().enumerate() {
                system[(p + q, p)] = self.kernel(&condition.taps, &other.taps);
            }
            system[(p, p)] += condition.compliance;
        }
        let wanted = conditions.iter().map(|c| {
            let harmonic = c.taps.iter().map(|t| t.weight * self.harmonic(t.i, t.j));
            c.value - harmonic.sum::<f64>()
        });
        let wanted = DVector::from_iterator(count, wanted);
        let forces = Cholesky::new(system)?.solve(&wanted);
        Some(self.bend(&conditions, &forces))
    }

    /// The harmonic function with the sides of Eq. 1.
    fn harmonic(&self, i: usize, j: usize) -> f64 {
        let [f1, f2] = [i, j].map(|i| i as f64 / self.cells as f64);
        f1 + f2 - f1 * f2
    }

    /// c_p K c_qᵀ. With s_a(i) s_a(k) = (cos(π a (i-k)/m) - cos(π a (i+k)/m)) / m the kernel is four entries of M.
    fn kernel(&self, a: &[Tap], b: &[Tap]) -> f64 {
        // M is even and of period 2m.
        let fold = |u: usize| u.min(2 * self.cells - u);
        let mut sum = 0.0;
        for p in a {
            for q in b {
                let (i, k) = (p.i.abs_diff(q.i), fold(p.i + q.i));
                let (j, l) = (p.j.abs_diff(q.j), fold(p.j + q.j));
                let m = &self.images;
                sum += p.weight * q.weight * (m[(i, j)] - m[(k, j)] - m[(i, l)] + m[(k, l)]);
            }
        }
        sum
    }

    /// The slice under the conditions' forces, f1 + f2 - f1 f2 + K Cᵀ λ: there and back by sines.
    fn bend(&self, conditions: &[Condition], forces: &DVector<f64>) -> DMatrix<f64> {
        let inner = 1..self.cells;
        let mut load = DMatrix::zeros(inner.len(), inner.len());
        for (condition, force) in conditions.iter().zip(forces.iter()) {
            for tap in &condition.taps {
                // A tap on a side has no say: v is 0 there.
                if inner.contains(&tap.i) && inner.contains(&tap.j) {
                    load[(tap.i - 1, tap.j - 1)] += tap.weight * force;
                }
            }
        }
        let modes = (&self.sines * load * &self.sines).component_mul(&self.inverse);
        let bent = &self.sines * modes * &self.sines;
        DMatrix::from_fn(self.cells + 1, self.cells + 1, |i, j| {
            let free = inner.contains(&i) && inner.contains(&j);
            self.harmonic(i, j) + if free { bent[(i - 1, j - 1)] } else { 0.0 }
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::{
        super::{Form, Level, Profile, pins::pins},
        *,
    };

    /// The contact operator's slice with the pins behind its line's tip alone.
    fn contact(cells: usize, depth: f64) -> DMatrix<f64> {
        let mut pins = pins(&[Profile::contact().outline(depth)], cells).remove(0);
        pins.retain(|pin| pin.share == 1.0);
        Biharmonic::new(cells).slice(&pins).unwrap()
    }

    /// Gradient of the energy by the value at an inner vertex: (Lᵀ L g)(i, j) with mirrored axes.
    fn bilaplacian(g: &DMatrix<f64>, i: usize, j: usize) -> f64 {
        let laplacian = |i: usize, j: usize| {
            let [before, below] = [i, j].map(|i| if i == 0 { 1 } else { i - 1 });
            g[(i + 1, j)] + g[(before, j)] + g[(i, j + 1)] + g[(i, below)] - 4.0 * g[(i, j)]
        };
        let last = g.nrows() - 1;
        // The value at (1, j) counts twice in the Laplacian at (0, j): once for the mirror.
        let from = |i: usize, j: usize, weight: f64| {
            let outside = i == last || j == last;
            if outside {
                0.0
            } else {
                weight * laplacian(i, j)
            }
        };
        let twice = |i: usize| if i == 1 { 2.0 } else { 1.0 };
        from(i - 1, j, twice(i))
            + from(i + 1, j, 1.0)
            + from(i, j - 1, twice(j))
            + from(i, j + 1, 1.0)
            - from(i, j, 4.0)
    }

    #[test]
    fn a_slice_is_stationary_wherever_no_pin_holds_it() {
        let pins = [
            Pin {
                at: [0.41, 0.33],
                share: 1.0,
            },
            Pin {
                at: [0.7, 0.55],
                share: 0.3,
            },
        ];
        let g = Biharmonic::new(40).slice(&pins).unwrap();
        let mut held = Vec::new();
        for i in 1..40 {
            for j in 1..40 {
                if bilaplacian(&g, i, j).abs() > 1e-9 {
                    held.push((i, j));
                }
            }
        }
        // 0.41 · 40 = 16.4, 0.33 · 40 = 13.2; 0.7 · 40 = 28, 0.55 · 40 = 22.
        assert_eq!(held, [(16, 13), (16, 14), (17, 13), (17, 14), (28, 22)]);
        assert!((g[(28, 22)] - 0.5).abs() > 1e-3, "a loose pin gives way");
    }

    /// Greatest distance from 0.5 of the bilinear interpolant at firm pins.
    fn slack(g: &DMatrix<f64>, pins: &[Pin]) -> f64 {
        let m = (g.nrows() - 1) as f64;
        let errors = pins.iter().filter(|p| p.share == 1.0).map(|pin| {
            let [(i, u), (j, v)] = pin.at.map(|f| ((f * m) as usize, (f * m).fract()));
            let row = |j: usize| g[(i, j)] * (1.0 - u) + g[(i + 1, j)] * u;
            (row(j) * (1.0 - v) + row(j + 1) * v - 0.5).abs()
        });
        errors.fold(0.0, f64::max)
    }

    /// A profile of one level, its contact line from (0.5, 0.45) to (0.8, 0.6).
    fn lopsided(form: Form, inner: &[[f64; 2]]) -> Vec<Pin> {
        let surface = [&[[0.0, 0.5]], inner, &[[0.5, 0.0]]].concat();
        let contact = vec![[0.5, 0.45], [0.8, 0.6]];
        let level = Level {
            depth: 0.0,
            surface,
            contact,
        };
        let profile = Profile::new(form, vec![level]).unwrap();
        pins(&[profile.outline(0.3)], 60).remove(0)
    }

    #[test]
    fn a_lopsided_profile_is_met_at_its_pins() {
        for form in [Form::Polyline, Form::Spline] {
            let pins = lopsided(
                form,
                &[
                    [0.2, 0.5],
                    [0.5, 0.45],
                    [0.5, 0.45],
                    [0.5, 0.45],
                    [0.45, 0.2],
                ],
            );
            let g = Biharmonic::new(60).slice(&pins).unwrap();
            let slack = slack(&g, &pins);
            assert!(slack < 1e-6, "{form:?}: {slack:e}");
            let [a, b] = [g[(40, 20)], g[(20, 40)]];
            assert!((a - b).abs() > 1e-3, "{form:?}: {a} {b} must differ");
        }
    }

    #[test]
    fn profiles_that_double_back_or_hug_a_side_still_have_a_solution() {
        for inner in [
            vec![[0.5, 0.5], [0.8, 0.8], [0.5, 0.5]],
            vec![[0.0, 0.3], [0.0, 0.0], [0.3, 0.0]],
            vec![[1.0, 1.0], [0.01, 0.01], [1.0, 0.0]],
            vec![],
        ] {
            for form in [Form::Polyline, Form::Spline] {
                let g = Biharmonic::new(60).slice(&lopsided(form, &inner)).unwrap();
                assert!(g.iter().all(|g| g.is_finite()), "{form:?} {inner:?}");
            }
        }
    }

    /// Vertices of a 65² slice.
    const PLACES: [(usize, usize); 10] = [
        (10, 10),
        (32, 40),
        (20, 50),
        (40, 40),
        (48, 44),
        (60, 33),
        (56, 60),
        (63, 62),
        (28, 31),
        (5, 30),
    ];
    /// Values there of the numpy prototype (a sparse direct solver on the whole grid) for d = 0, 0.5 and 1, each beside our depth at
    /// which the line's tip is the prototype's last vertex: it knows no tip between vertices, and none that grows ahead. Vertex 54 of 64 is (54/64 - 1/2) √2.
    const PROTOTYPE: [(f64, [f64; 10]); 3] = [
        (
            0.0,
            [
                0.213327717,
                0.588526867,
                0.75127123,
                0.649500014,
                0.785750382,
                0.92827129,
                0.975984305,
                0.998476117,
                0.494408622,
                0.469458504,
            ],
        ),
        (
            0.486135913,
            [
                0.214331135,
                0.522358793,
                0.719711069,
                0.5,
                0.511628892,
                0.873598885,
                0.786528802,
                0.984081009,
                0.49661345,
                0.469665407,
            ],
        ),
        (
            1.0,
            [
                0.214314479,
                0.52264736,
                0.720407694,
                0.5,
                0.512369173,
                0.874841759,
                0.597406677,
                0.722857334,
                0.496597524,
                0.469660875,
            ],
        ),
    ];

    #[test]
    fn slices_agree_with_the_prototype() {
        for (depth, values) in PROTOTYPE {
            let g = contact(64, depth);
            for ((i, j), value) in PLACES.into_iter().zip(values) {
                let ours = g[(i, j)];
                assert!((ours - value).abs() < 1e-7, "{depth} {i} {j}: {ours}");
                assert!((ours - g[(j, i)]).abs() < 1e-9, "{depth} {i} {j}");
            }
        }
    }
    /// Greatest |g(d + h) - 2 g(d) + g(d - h)| / h over some depths, away from the corner (1, 1): what the slope in d jumps by.
    fn jump(profile: &Profile, depths: &[f64], h: f64) -> f64 {
        const CELLS: usize = 32;
        let last = CELLS * 3 / 4;
        let solver = Biharmonic::new(CELLS);
        let jumps = depths.iter().map(|d| {
            let outlines = [d - h, *d, d + h].map(|d| profile.outline(d));
            let [a, b, c] = [0, 1, 2].map(|k| solver.slice(&pins(&outlines, CELLS)[k]).unwrap());
            let inner = (0..=last).flat_map(|i| (0..=last).map(move |j| (i, j)));
            inner.fold(0.0f64, |most, at| {
                most.max((a[at] - 2.0 * b[at] + c[at]).abs() / h)
            })
        });
        jumps.fold(0.0, f64::max)
    }

    #[test]
    fn slices_are_c1_in_their_depth() {
        // Between vertices, and where a pin begins or ends to grow: the line's tip on vertices 20 and 22 of 32.
        let ends = [20.0, 22.0].map(|i: f64| (i / 32.0 - 0.5) * 2f64.sqrt());
        let depths = [0.1, ends[0], 0.2, ends[1], 0.33];
        let h = 1e-3;
        for profile in [Profile::contact(), Profile::bulge(1.0).unwrap()] {
            let (coarse, fine) = (jump(&profile, &depths, h), jump(&profile, &depths, h / 8.0));
            // A kink would jump by as much at any step: 1.2 where pins grow evenly, one after the other.
            assert!(coarse < 0.05 && fine < coarse / 6.0, "{coarse} {fine}");
        }
    }
}
