//! Chrome's trace event format, which Perfetto and chrome://tracing open.

use serde::Serialize;
use serde_json::{Value, json};

/// Rows of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Track {
    /// What the program does.
    Cpu,
    /// What the device does, a span a pass.
    Gpu,
}

impl Track {
    /// Process and thread numbers.
    fn ids(self) -> (u32, u32) {
        match self {
            Self::Cpu => (1, 1),
            Self::Gpu => (2, 1),
        }
    }
}

/// A trace under construction; times in microseconds from its beginning.
#[derive(Debug, Serialize)]
pub(crate) struct Trace {
    #[serde(rename = "traceEvents")]
    events: Vec<Value>,
    #[serde(rename = "displayTimeUnit")]
    unit: &'static str,
    #[serde(rename = "otherData")]
    data: Value,
}

impl Trace {
    /// An empty trace with named tracks; `data` describes it.
    pub(crate) fn new(device: &str, data: Value) -> Self {
        let mut trace = Self {
            events: Vec::new(),
            unit: "ms",
            data,
        };
        let tracks = [
            (Track::Cpu, "CPU", "main thread"),
            (Track::Gpu, device, "compute queue"),
        ];
        for (order, (track, process, thread)) in tracks.into_iter().enumerate() {
            trace.name(track, "process_name", json!({ "name": process }));
            trace.name(track, "thread_name", json!({ "name": thread }));
            trace.name(track, "process_sort_index", json!({ "sort_index": order }));
        }
        trace
    }

    fn name(&mut self, track: Track, what: &str, args: Value) {
        let (pid, tid) = track.ids();
        self.events
            .push(json!({ "ph": "M", "name": what, "pid": pid, "tid": tid, "args": args }));
    }

    /// A span; one that lies within another on its track is drawn below it.
    pub(crate) fn span(
        &mut self,
        track: Track,
        name: &str,
        begin_us: f64,
        end_us: f64,
        args: Value,
    ) {
        let (pid, tid) = track.ids();
        let dur = (end_us - begin_us).max(0.0);
        self.events.push(json!({
            "ph": "X", "name": name, "cat": "dermis", "pid": pid, "tid": tid,
            "ts": begin_us, "dur": dur, "args": args,
        }));
    }

    /// Values of a counter at a time; `values` is an object of numbers, drawn on top of each other.
    pub(crate) fn counter(&mut self, name: &str, at_us: f64, values: Value) {
        let (pid, _) = Track::Gpu.ids();
        self.events
            .push(json!({ "ph": "C", "name": name, "pid": pid, "ts": at_us, "args": values }));
    }

    /// Number of spans on a track.
    pub(crate) fn spans(&self, track: Track) -> usize {
        let (pid, _) = track.ids();
        let here = |e: &&Value| e["ph"] == "X" && e["pid"] == pid;
        self.events.iter().filter(here).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tracks_are_named_and_spans_keep_their_times() {
        let mut trace = Trace::new("llvmpipe", json!({}));
        trace.span(Track::Gpu, "project", 10.0, 12.5, json!({ "frame": 3 }));
        trace.counter("memory", 0.0, json!({ "fields": 5 }));
        let value = json!(trace);
        let events = value["traceEvents"].as_array().map_or(&[][..], |e| e);
        assert!(
            events
                .iter()
                .any(|e| e["ph"] == "M" && e["args"]["name"] == "llvmpipe" && e["pid"] == 2)
        );
        let spans: Vec<_> = events.iter().filter(|e| e["ph"] == "X").collect();
        assert_eq!(spans.len(), 1);
        assert_eq!(
            (&spans[0]["ts"], &spans[0]["dur"]),
            (&json!(10.0), &json!(2.5))
        );
        assert_eq!((trace.spans(Track::Gpu), trace.spans(Track::Cpu)), (1, 0));
    }
}
