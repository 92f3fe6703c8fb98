//! What a run tells: a line, a table with --report, and all of it as JSON.

use dermis::{
    Result,
    flesh::{AMBIGUOUS, PAST_BENT_LIMIT, PAST_END, PAST_REST_LIMIT, volume},
};
use serde::Serialize;

use super::{
    Args,
    bender::{Bender, Outcome, Way},
    measures::{Local, Pieces},
    shape::Shape,
};
use crate::{
    console::Console,
    table::{Table, count},
};

#[derive(Serialize)]
pub(super) struct Report {
    file: String,
    output: String,
    map: &'static str,
    strength: f64,
    stretch: bool,
    vertices: usize,
    triangles: usize,
    open_edges: usize,
    spines: Vec<SpineReport>,
    /// Of the mesh before.
    volume: f64,
    frames: Vec<FrameReport>,
    /// Relative error of the volume by plain skinning, with --report.
    #[serde(skip_serializing_if = "Option::is_none")]
    plain_volume_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    local: Option<Local>,
}

#[derive(Serialize)]
struct SpineReport {
    rest: String,
    bent: String,
    rest_length: f64,
    bent_length: f64,
    closed: [bool; 2],
}

#[derive(Serialize)]
struct FrameReport {
    slide: f64,
    volume: f64,
    /// Relative error of the volume.
    volume_error: f64,
    /// Vertices around which volume may not be kept.
    invalid_vertices: usize,
    past_rest_limit: usize,
    past_bent_limit: usize,
    ambiguous: usize,
    past_end: usize,
    torn_triangles: usize,
    /// Least distance to a limit, in units of the mesh; none where all is straight.
    limit: Option<f64>,
    register_ms: f64,
    bend_ms: f64,
}

impl Report {
    pub(super) fn new(args: &Args, shape: &Shape, bender: &Bender) -> Self {
        let spine = |pair: &super::bender::Pair| SpineReport {
            rest: pair.files[0].display().to_string(),
            bent: pair.files[1].display().to_string(),
            rest_length: pair.rest.length(),
            bent_length: pair.bent.length(),
            closed: [pair.rest.closed(), pair.bent.closed()],
        };
        Self {
            file: args.mesh.display().to_string(),
            output: args.output.display().to_string(),
            map: args.map.name(),
            strength: args.strength,
            stretch: args.stretch,
            vertices: shape.positions.len(),
            triangles: shape.triangles().len(),
            open_edges: shape.open_edges,
            spines: bender.pairs.iter().map(spine).collect(),
            volume: volume(&shape.positions, shape.triangles()),
            frames: Vec::new(),
            plain_volume_error: None,
            local: None,
        }
    }

    pub(super) fn add(&mut self, shape: &Shape, slide: f64, outcome: &Outcome) {
        let now = volume(&outcome.bent.positions, shape.triangles());
        let limit = outcome
            .bent
            .distances
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        self.frames.push(FrameReport {
            slide,
            volume: now,
            volume_error: now / self.volume - 1.0,
            invalid_vertices: outcome.invalid(),
            past_rest_limit: outcome.flagged(PAST_REST_LIMIT),
            past_bent_limit: outcome.flagged(PAST_BENT_LIMIT),
            ambiguous: outcome.flagged(AMBIGUOUS),
            past_end: outcome.flagged(PAST_END),
            torn_triangles: outcome.torn,
            limit: limit.is_finite().then_some(limit),
            register_ms: outcome.ms[0],
            bend_ms: outcome.ms[1],
        });
    }

    /// Adds what only --report tells.
    pub(super) fn measure(&mut self, shape: &Shape, bender: &Bender, way: &Way) -> Result<()> {
        let plain = Way {
            strength: 0.0,
            ..*way
        };
        let plain = bender.bend(shape, &plain)?;
        let now = volume(&plain.bent.positions, shape.triangles());
        self.plain_volume_error = Some(now / self.volume - 1.0);
        if bender.anywhere() {
            self.local = Some(Local::of(shape, bender, way)?);
        }
        Ok(())
    }

    pub(super) fn warn(&self, console: &Console) -> Result<()> {
        if self.open_edges > 0 {
            console.note(format_args!(
                "warning: the mesh is not closed ({} edges): its volume means little",
                count(self.open_edges)
            ))?;
        }
        let worst = |f: fn(&FrameReport) -> usize| self.frames.iter().map(f).max().unwrap_or(0);
        let invalid = worst(|f| f.invalid_vertices);
        if invalid > 0 {
            console.note(format_args!(
                "warning: {} vertices are past a limit or between two parts of the spine: volume is not kept there",
                count(invalid)
            ))?;
        }
        let torn = worst(|f| f.torn_triangles);
        if torn > 0 {
            console.note(format_args!(
                "warning: {} triangles are torn: their corners are nearest to different parts of the rest spine",
                count(torn)
            ))?;
        }
        Ok(())
    }

    /// A line, and the tables of --report.
    pub(super) fn text(&self, full: bool) -> String {
        let worst = |f: &&FrameReport| f.volume_error.abs();
        let worst = self.frames.iter().map(|f| worst(&f)).fold(0.0, f64::max);
        let mut text = format!(
            "{}: {} frames of {} ({}), {} vertices, volume off by {}\n",
            self.output,
            self.frames.len(),
            self.file,
            self.map,
            count(self.vertices),
            percent(worst)
        );
        if full {
            text += &format!("\n{}", self.volumes());
        }
        text
    }

    fn volumes(&self) -> String {
        let mut table = Table::new(1, ["volume", "pieces", "mean error", "worst", "plain mean"]);
        let plain = self.plain_volume_error.unwrap_or_default();
        let error = self.frames.first().map_or(0.0, |f| f.volume_error);
        table.row([
            "whole mesh".into(),
            "1".into(),
            percent(error),
            percent(error),
            percent(plain),
        ]);
        let mut add = |name: String, pieces: &Pieces| {
            table.row([
                name,
                count(pieces.cells),
                percent(pieces.mean_error),
                percent(pieces.worst_error),
                percent(pieces.plain_mean_error),
            ]);
        };
        if let Some(local) = &self.local {
            add("tetrahedra".into(), &local.surface);
            for cubes in &local.cubes {
                let size = cubes.size.unwrap_or_default();
                add(format!("cubes of {size:.4}"), cubes);
            }
        }
        table.to_string()
    }
}

fn percent(share: f64) -> String {
    format!("{:.4} %", 100.0 * share)
}
