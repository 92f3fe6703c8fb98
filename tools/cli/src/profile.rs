//! `dermis profile`: where the milliseconds and the megabytes go, as a trace.

use std::{
    path::PathBuf,
    time::{Duration, Instant},
};

use dermis::{
    Error, Result,
    deformer::{Deformer, Device},
    gpu::{Gpu, Profile},
    report::{FrameTimings, MemoryReport},
};
use serde_json::{Value, json};

use crate::{
    console::{self, Console},
    options::{DeviceOptions, MethodName, PoseOptions, ReportOptions, RigOptions},
    output::Partial,
    poses::{Fallback, Frame, Frames},
    session::{Character, Session},
    table::bytes,
    trace::{Trace, Track},
};

/// Write a trace of the preparation and of some frames, which opens in ui.perfetto.dev.
#[derive(clap::Args)]
#[command(after_help = "\
The CPU track has the stages of the preparation and, a frame, advance (record and submit) and wait; the GPU track has
one span a pass, by calibrated clocks where the device has them. Counters hold the memory, by budget class.

Examples:
  dermis profile human-male.glb -o trace.json
  dermis profile arm.glb -o trace.json --random 10 --method dqs")]
pub(crate) struct Args {
    /// glTF or GLB file.
    file: PathBuf,
    /// The trace, as JSON.
    #[arg(long, short, value_name = "OUT")]
    output: PathBuf,
    /// Frames to trace, from the chosen poses in turn.
    #[arg(long, short = 'n', value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    count: u32,
    /// How to deform.
    #[arg(long, value_enum, default_value = "implicit")]
    method: MethodName,
    #[command(flatten)]
    poses: PoseOptions,
    #[command(flatten)]
    rig: RigOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    report: ReportOptions,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let console = Console::new(&args.report);
    let method = args.method.method();
    let output = Partial::file(&args.output)?;
    let character = Character::load(&args.file)?;
    let frames = Frames::choose(
        &args.poses,
        &character,
        Fallback::Random(args.count),
        45.0,
        &console,
    )?;
    let session = Session::open(character, &args.rig, &args.device, Profile::Full, &console)?;
    let mut recorder = Recorder::new(start, &session, args.method, &frames);
    let begin = Instant::now();
    let mut deformer = session.deformer(method)?;
    recorder.cpu("create deformer", begin, Instant::now(), json!({}));
    recorder.memory(&deformer.memory());
    for i in 0..args.count as usize {
        let frame = &frames.frames[i % frames.frames.len()];
        recorder.frame(&mut deformer, frame)?;
    }
    recorder.memory(&deformer.memory());
    session.finish()?;
    let trace = recorder.trace;
    let text = serde_json::to_vec(&trace)
        .map_err(|e| Error::asset(&args.output, "trace", e.to_string()))?;
    std::fs::write(output.path(), &text).map_err(|e| Error::file(&args.output, e))?;
    output.keep()?;
    console.text(format_args!(
        "{}: {} frames, {} CPU and {} GPU spans, {}; open it in https://ui.perfetto.dev",
        args.output.display(),
        args.count,
        trace.spans(Track::Cpu),
        trace.spans(Track::Gpu),
        bytes(text.len() as u64)
    ))?;
    console::json(&args.report, &trace)
}

/// Fills the trace; times count from `start`.
struct Recorder {
    start: Instant,
    gpu: Option<Gpu>,
    trace: Trace,
}

impl Recorder {
    fn new(start: Instant, session: &Session, method: MethodName, frames: &Frames) -> Self {
        let device = session.device_report();
        let data = json!({
            "file": session.model.path.display().to_string(),
            "method": method.name(),
            "poses": frames.source,
            "driver": device.driver,
            "version": env!("CARGO_PKG_VERSION"),
        });
        let gpu = match &session.device {
            Device::Gpu(gpu) => Some(gpu.clone()),
            Device::Cpu => None,
        };
        let mut recorder = Self {
            start,
            gpu,
            trace: Trace::new(&device.name, data),
        };
        for stage in &session.stages {
            let name = format!("prepare: {}", stage.name);
            recorder.cpu(&name, stage.begin, stage.end, json!({}));
        }
        recorder
    }

    fn us(&self, at: Instant) -> f64 {
        at.saturating_duration_since(self.start).as_secs_f64() * 1e6
    }

    fn cpu(&mut self, name: &str, begin: Instant, end: Instant, args: Value) {
        let (begin, end) = (self.us(begin), self.us(end));
        self.trace.span(Track::Cpu, name, begin, end, args);
    }

    fn memory(&mut self, memory: &MemoryReport) {
        let now = self.us(Instant::now());
        let classes: serde_json::Map<String, Value> = memory
            .classes
            .iter()
            .map(|(class, bytes)| (class.to_string(), json!(bytes)))
            .collect();
        self.trace
            .counter("device memory, bytes", now, Value::Object(classes));
    }

    fn frame(&mut self, deformer: &mut Deformer, frame: &Frame) -> Result<()> {
        let args = json!({ "frame": frame.number, "seconds": frame.seconds });
        let begin = Instant::now();
        deformer.advance(&frame.pose)?;
        let submitted = Instant::now();
        deformer.wait()?;
        let end = Instant::now();
        self.cpu(&format!("frame {}", frame.number), begin, end, args);
        self.cpu("advance", begin, submitted, json!({}));
        self.cpu("wait", submitted, end, json!({}));
        // What advance does last: it records and submits.
        let posed = submitted.checked_sub(Duration::from_nanos(deformer.record_ns()));
        let posed = posed.unwrap_or(begin).max(begin);
        self.cpu("pose", begin, posed, json!({}));
        if let Some(timings) = deformer.timings() {
            let recorded = posed + Duration::from_nanos(timings.cpu_record_ns);
            self.cpu("record", posed, recorded.min(submitted), json!({}));
            self.cpu("submit", recorded.min(submitted), submitted, json!({}));
            self.passes(&timings, end, frame.number);
        } else {
            self.cpu("deform", posed, submitted, json!({}));
        }
        Ok(())
    }

    /// One span a pass, by the device's clock; where that cannot be compared with the CPU's, the last timestamp is laid
    /// on `end`, when the wait came back.
    fn passes(&mut self, timings: &FrameTimings, end: Instant, number: usize) {
        let last = timings.passes.iter().map(|p| p.end_ns).max().unwrap_or(0);
        let (device_ns, cpu) = self
            .gpu
            .as_ref()
            .and_then(Gpu::clock)
            .unwrap_or((last, end));
        let cpu_us = self.us(cpu);
        let at = |ns: u64| cpu_us + (ns as f64 - device_ns as f64) * 1e-3;
        for pass in &timings.passes {
            let args = json!({ "label": pass.label, "frame": number });
            let (begin, end) = (at(pass.begin_ns), at(pass.end_ns));
            self.trace.span(Track::Gpu, &pass.name, begin, end, args);
        }
    }
}
