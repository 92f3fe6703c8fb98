//! Interpolating polynomials by Neville's algorithm, with derivatives.

use glam::DVec3;

use super::{Jet, Path, chords};

/// The polynomial through points at given parameters.
pub(super) struct Polynomial {
    points: Vec<DVec3>,
    parameters: Vec<f64>,
}

impl Polynomial {
    pub(super) fn new(points: &[DVec3]) -> Self {
        Self {
            points: points.to_vec(),
            parameters: chords(points),
        }
    }
}

impl Path for Polynomial {
    fn breaks(&self) -> Vec<f64> {
        self.parameters.clone()
    }

    fn jet(&self, parameter: f64) -> Jet {
        neville(&self.points, &self.parameters, parameter)
    }
}

/// Neville's tableau P[i..j] = ((t - t_i) P[i+1..j] - (t - t_j) P[i..j-1]) / (t_j - t_i), and its derivatives by the product rule.
pub(super) fn neville(points: &[DVec3], parameters: &[f64], t: f64) -> Jet {
    let constant = |&point: &DVec3| Jet {
        point,
        ..Jet::default()
    };
    let mut row: Vec<Jet> = points.iter().map(constant).collect();
    for span in 1..points.len() {
        for i in 0..points.len() - span {
            let (from, to) = (parameters[i], parameters[i + span]);
            let (a, b) = (row[i], row[i + 1]);
            let (wa, wb) = ((to - t) / (to - from), (t - from) / (to - from));
            let slope = 1.0 / (to - from);
            row[i] = Jet {
                point: wa * a.point + wb * b.point,
                first: wa * a.first + wb * b.first + slope * (b.point - a.point),
                second: wa * a.second + wb * b.second + 2.0 * slope * (b.first - a.first),
            };
        }
    }
    row[0]
}
