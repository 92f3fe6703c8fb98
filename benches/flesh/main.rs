//! Fleshing: Table 1's experiment, and how many vertices a second are registered and bent.
//!
//! `cargo bench --bench flesh -- [VERTICES]`
#![allow(missing_docs)]

mod table;

use std::time::Instant;

use dermis::flesh::{BendOptions, Bent, Curve, Map, Round, Spine, SpineDesc, bend_again, register};
use glam::{DVec2, DVec3};

const VERTICES: usize = 1_000_000;
const ROUNDS: usize = 7;

fn main() -> dermis::Result<()> {
    println!("{}", table::text(&table::lines()?));
    let count = std::env::args().skip(1).find_map(|a| a.parse().ok());
    let count: usize = count.unwrap_or(VERTICES);
    println!("{count} vertices, {} threads", rayon::current_num_threads());
    let round = Round {
        start: DVec3::ZERO,
        tangent: DVec3::X,
        normal: DVec3::Y,
        radius: 1.6,
        length: 6.0,
    };
    let at = |i: u32| {
        let t = 0.6 * f64::from(i);
        DVec3::new(t, 0.6 * t.sin(), 0.3 * (1.7 * t).cos())
    };
    let spline = Curve::BSpline((0..10).map(at).collect());
    let begin = Instant::now();
    let rest = Spine::new(&SpineDesc::new(spline))?;
    let middle = Instant::now();
    let helix = Curve::Helix { round, pitch: 3.0 };
    let bent = Spine::like(&SpineDesc::new(helix), &rest)?;
    let ms = [middle - begin, middle.elapsed()].map(|t| 1e3 * t.as_secs_f64());
    println!("preparing the spines: {:.2} and {:.2} ms", ms[0], ms[1]);
    let point = |i: usize| {
        let share = (i as f64 + 0.5) / count as f64;
        let angle = DVec2::from_angle(2.4 * i as f64);
        let across = 0.45 * (i as f64 * 0.618_034).fract().sqrt() * angle;
        rest.section(share * rest.length()).point(across)
    };
    let points: Vec<DVec3> = (0..count).map(point).collect();
    let normals: Vec<DVec3> = points.iter().map(|p| p.normalize_or(DVec3::X)).collect();
    for map in [Map::Radial, Map::Normal, Map::Binormal] {
        for normals in [&[][..], &normals] {
            let registering = best(|| register(&rest, map, &points, normals).map(drop))?;
            let registered = register(&rest, map, &points, normals)?;
            let mut out = Bent::default();
            let bending =
                best(|| bend_again(&registered, &bent, &BendOptions::default(), &mut out))?;
            println!(
                "{map:?}{}: {:.1} M vertices/s registered, {:.1} M/s bent",
                if normals.is_empty() {
                    ""
                } else {
                    " with normals"
                },
                count as f64 / registering / 1e6,
                count as f64 / bending / 1e6
            );
        }
    }
    Ok(())
}

/// Least time of some rounds, in seconds.
fn best(mut work: impl FnMut() -> dermis::Result<()>) -> dermis::Result<f64> {
    let mut least = f64::INFINITY;
    for _ in 0..ROUNDS {
        let begin = Instant::now();
        work()?;
        least = least.min(begin.elapsed().as_secs_f64());
    }
    Ok(least)
}
