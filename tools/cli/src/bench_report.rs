//! The result of a bench, for people and for programs.

use std::collections::BTreeMap;

use dermis::report::{Ceiling, DeviceReport, MemoryReport};
use serde::Serialize;

use crate::{
    bench_run::Measured,
    samples::Samples,
    session::Session,
    stats::Spread,
    table::{Table, bytes, count},
};

/// The JSON of `bench`.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    device: Device,
    model: Model,
    method: &'static str,
    instances: u32,
    frames: usize,
    passes: Vec<Pass>,
    frame: Frame,
    instance: Instance,
    iterations: Iterations,
    memory: BTreeMap<String, u64>,
    ceiling: Option<Ceiling>,
    fetches_per_frame: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    profiling: Option<Profiling>,
    #[serde(skip)]
    stamp_us: f64,
    #[serde(skip)]
    excess_us: f64,
    #[serde(skip)]
    fetching: Option<Fetching>,
}

#[derive(Debug, Serialize)]
struct Device {
    name: String,
    driver: String,
    api: String,
    #[serde(rename = "type")]
    kind: String,
}

#[derive(Debug, Serialize)]
struct Model {
    file: String,
    vertices: usize,
    welded_vertices: usize,
    triangles: usize,
    joints: usize,
    fields: usize,
}

#[derive(Debug, Serialize)]
struct Pass {
    name: String,
    calls: u64,
    gpu_ms: Spread,
}

#[derive(Debug, Serialize)]
struct Frame {
    gpu_ms: Spread,
    cpu_record_ms: Spread,
    wall_ms: Spread,
}

/// The share of one instance in a frame.
#[derive(Debug, Serialize)]
struct Instance {
    gpu_ms: Spread,
    wall_ms: Spread,
}

#[derive(Debug, Serialize)]
struct Iterations {
    newton_mean: f64,
    newton_max: u32,
    substeps_mean: f64,
    /// Jacobi iterations a sub-step until nothing moved, or all that it may have.
    jacobi_mean: f64,
    /// Sub-steps done again in halves.
    halved: u32,
    /// Frames that would have needed more sub-steps than they may have.
    capped: u32,
}

impl Iterations {
    /// A line on what only tracking has.
    fn tracking(&self) -> String {
        if self.jacobi_mean == 0.0 {
            return String::new();
        }
        format!(
            "\n{:.1} sub-steps a frame of {:.1} iterations each; {} done again in halves, {} frames at the cap",
            self.substeps_mean, self.jacobi_mean, self.halved, self.capped
        )
    }
}

/// Wall-clock of frames with and without timestamps.
#[derive(Debug, Serialize)]
pub(crate) struct Profiling {
    on_ms: Spread,
    off_ms: Spread,
    /// Share by which frames grow: the median for every turn of the profile, and the mean over the turns.
    cost: f64,
}

impl Profiling {
    /// Of the same frames; their turns follow each other.
    fn new(on: &[u64], off: &[u64], turns: usize) -> Self {
        let pairs = || on.iter().zip(off).map(|(on, off)| *on as f64 / *off as f64);
        let turns = turns.max(1);
        let medians = (0..turns).filter_map(|turn| median(pairs().skip(turn).step_by(turns)));
        let costs: Vec<f64> = medians.collect();
        Self {
            on_ms: Spread::of_ns(on),
            off_ms: Spread::of_ns(off),
            cost: costs.iter().sum::<f64>() / costs.len().max(1) as f64 - 1.0,
        }
    }
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// What the projection fetches a second, beside the ceiling.
#[derive(Debug)]
struct Fetching {
    per_s: f64,
    /// Of the ceiling, median over median.
    share: f64,
    /// Of the rate at the same places, median over median.
    in_place: f64,
}

impl Fetching {
    fn new(measured: &Measured) -> Option<Self> {
        let rates = measured.samples.fetch_rates();
        let ceiling = |of: fn(&Ceiling) -> f64| {
            median(measured.ceilings.iter().map(of)).filter(|rate| *rate > 0.0)
        };
        let per_s = median(rates.iter().copied())?;
        Some(Self {
            per_s,
            share: per_s / ceiling(|c| c.fetch3d_per_s)?,
            in_place: per_s / ceiling(|c| c.replay3d_per_s)?,
        })
    }
}

impl Report {
    pub(crate) fn new(session: &Session, method: &'static str, measured: &Measured) -> Self {
        let samples = &measured.samples;
        let (on, off) = (&samples.wall_ns, &measured.plain_ns);
        let compared = !off.is_empty();
        let frame = Frame {
            gpu_ms: Spread::of_ns(&samples.gpu_ns),
            cpu_record_ms: Spread::of_ns(&samples.cpu_record_ns),
            wall_ms: Spread::of_ns(&samples.wall_ns),
        };
        Self {
            device: device(session.device_report()),
            model: model(session),
            method,
            instances: measured.instances,
            frames: samples.wall_ns.len(),
            passes: passes(samples),
            instance: Instance {
                gpu_ms: frame.gpu_ms.over(measured.instances),
                wall_ms: frame.wall_ms.over(measured.instances),
            },
            frame,
            iterations: iterations(samples),
            memory: classes(measured.memory.clone()),
            ceiling: measured.ceilings.iter().copied().reduce(Ceiling::max),
            fetches_per_frame: mean(samples, |i| i.fetches as f64),
            profiling: compared.then(|| Profiling::new(on, off, samples.turns)),
            stamp_us: samples.stamp_ns as f64 / 1e3,
            excess_us: samples.excess_ns as f64 / 1e3,
            fetching: Fetching::new(measured),
        }
    }

    /// The tables; `source` says which poses were played.
    pub(crate) fn text(&self, source: &str) -> String {
        let model = &self.model;
        let mut lines = vec![
            format!(
                "{} ({}, Vulkan {}, {})",
                self.device.name, self.device.kind, self.device.api, self.device.driver
            ),
            format!(
                "{}: {} vertices ({} welded), {} triangles, {} joints, {} fields",
                model.file,
                count(model.vertices),
                count(model.welded_vertices),
                count(model.triangles),
                model.joints,
                model.fields
            ),
            format!(
                "{}, {source}, {} frames{}",
                self.method,
                self.frames,
                match self.instances {
                    1 => String::new(),
                    n => format!(" of {n} instances"),
                }
            ),
            String::new(),
            self.pass_table(),
            self.verdict() + &self.sum_line(),
            String::new(),
            self.memory_table(),
        ];
        lines.extend(self.ceiling_line());
        lines.extend(self.profiling.as_ref().map(profiling_line));
        lines.join("\n")
    }

    fn pass_table(&self) -> String {
        let whole = self.frame.gpu_ms.mean;
        let mut table = Table::new(
            1,
            ["GPU", "calls", "min ms", "p50 ms", "p95 ms", "mean share"],
        );
        let mut row = |name: &str, calls: String, ms: Spread, share: String| {
            let [min, p50, p95] = [ms.min, ms.p50, ms.p95].map(|ms| format!("{ms:.3}"));
            table.row([name.into(), calls, min, p50, p95, share]);
        };
        let mut sum = 0.0;
        for pass in &self.passes {
            sum += pass.gpu_ms.mean;
            let share = percent(pass.gpu_ms.mean, whole);
            row(&pass.name, pass.calls.to_string(), pass.gpu_ms, share);
        }
        let frame = &self.frame;
        row("frame", String::new(), frame.gpu_ms, percent(sum, whole));
        row(
            "cpu record",
            String::new(),
            frame.cpu_record_ms,
            String::new(),
        );
        row("wall", String::new(), frame.wall_ms, String::new());
        if self.instances > 1 {
            let wall = self.instance.wall_ms;
            row("an instance", String::new(), wall, String::new());
        }
        table.to_string()
    }

    fn verdict(&self) -> String {
        let wall = self.instance.wall_ms.p50 * 1e6;
        let per_vertex = wall / self.model.vertices.max(1) as f64;
        let welded = wall / self.model.welded_vertices.max(1) as f64;
        let iterations = &self.iterations;
        format!(
            "{per_vertex:.0} ns a vertex and frame ({welded:.0} a welded one), wall p50\n\
             {:.2} field evaluations a projected vertex on average, {} at most{}",
            iterations.newton_mean,
            iterations.newton_max,
            iterations.tracking()
        )
    }

    /// Whether the passes account for the frame.
    fn sum_line(&self) -> String {
        let sum: f64 = self.passes.iter().map(|p| p.gpu_ms.mean).sum();
        let whole = self.frame.gpu_ms.mean;
        if sum > 0.0 && whole > 0.0 {
            let share = percent(sum, whole);
            format!(
                "\npasses add up to {share} of the frame, sum of means over mean; \
                 {:.1} µs a timestamp and {:.1} µs an interval are taken off",
                self.stamp_us, self.excess_us
            )
        } else {
            String::new()
        }
    }

    fn memory_table(&self) -> String {
        let mut table = Table::new(1, ["memory", "", "share"]);
        let total = self.memory.get("total").copied().unwrap_or(0);
        let classes = self.memory.iter().filter(|(class, _)| *class != "total");
        for (class, &size) in classes {
            let share = percent(size as f64, total as f64);
            table.row([class.clone(), bytes(size), share]);
        }
        table.row(["total".into(), bytes(total), String::new()]);
        table.to_string()
    }

    fn ceiling_line(&self) -> Option<String> {
        let ceiling = self.ceiling?;
        let mega = |rate: f64| format!("{:.0} M", rate * 1e-6);
        let in_place = Some(ceiling.replay3d_per_s).filter(|rate| *rate > 0.0);
        let in_place = in_place.map(|rate| format!(" ({} at the projection's places)", mega(rate)));
        let mut line = format!(
            "ceiling of this device: {} 3D fetches/s{}, {:.1} GB/s copied",
            mega(ceiling.fetch3d_per_s),
            in_place.unwrap_or_default(),
            ceiling.copy_bytes_per_s * 1e-9
        );
        if let Some(fetches) = self.fetches_per_frame {
            line += &format!("\n{:.2} M fetches a frame", fetches * 1e-6);
        }
        if let Some(fetching) = &self.fetching {
            line += &format!(
                "\nproject: {:.0} M fetches/s, {:.1} % of that ceiling; {:.1} % of what the device reaches at the \
                 same places of the fields with nothing else to do (medians)",
                fetching.per_s * 1e-6,
                fetching.share * 100.0,
                fetching.in_place * 100.0
            );
        }
        Some(line)
    }
}

fn profiling_line(profiling: &Profiling) -> String {
    format!(
        "profiling costs {:+.1} %, mean over its turns (wall p50 {:.3} ms with timestamps, {:.3} ms without; least {:.3} and {:.3})",
        100.0 * profiling.cost,
        profiling.on_ms.p50,
        profiling.off_ms.p50,
        profiling.on_ms.min,
        profiling.off_ms.min
    )
}

fn percent(part: f64, whole: f64) -> String {
    if whole > 0.0 {
        format!("{:.1} %", 100.0 * part / whole)
    } else {
        String::new()
    }
}

fn device(report: DeviceReport) -> Device {
    Device {
        name: report.name,
        driver: report.driver,
        api: report.api,
        kind: report.kind,
    }
}

fn model(session: &Session) -> Model {
    let rig = &session.rig;
    Model {
        file: session.model.path.display().to_string(),
        vertices: rig.rows.vertex.len(),
        welded_vertices: rig.mesh.positions.len(),
        triangles: rig.rows.triangles.len(),
        joints: rig.skeleton.joints.len(),
        fields: rig.fields.len(),
    }
}

fn passes(samples: &Samples) -> Vec<Pass> {
    samples
        .passes()
        .map(|pass| Pass {
            name: pass.name.clone(),
            calls: pass.calls(),
            gpu_ms: pass.spread(),
        })
        .collect()
}

fn iterations(samples: &Samples) -> Iterations {
    let max = samples.iterations.iter().map(|i| i.newton_max).max();
    Iterations {
        newton_mean: mean(samples, |i| i.newton_mean).unwrap_or(0.0),
        newton_max: max.unwrap_or(0),
        substeps_mean: mean(samples, |i| f64::from(i.substeps)).unwrap_or(0.0),
        jacobi_mean: mean(samples, |i| {
            f64::from(i.jacobi) / f64::from(i.substeps.max(1))
        })
        .unwrap_or(0.0),
        halved: samples.iterations.iter().map(|i| i.halved).sum(),
        capped: samples.iterations.iter().map(|i| u32::from(i.capped)).sum(),
    }
}

fn mean(samples: &Samples, value: impl Fn(&dermis::report::Iterations) -> f64) -> Option<f64> {
    let count = samples.iterations.len();
    let sum: f64 = samples.iterations.iter().map(value).sum();
    (count > 0).then(|| sum / count as f64)
}

fn classes(memory: MemoryReport) -> BTreeMap<String, u64> {
    let mut classes = memory.classes;
    classes.insert("total".into(), memory.total);
    classes
}
