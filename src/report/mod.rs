//! Timings, memory and device as plain data.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// A Vulkan device, or the CPU in its place.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DeviceReport {
    /// Row in the list of devices, what `--device INDEX` takes.
    pub index: usize,
    /// Name that the driver gives.
    pub name: String,
    /// Driver and its version.
    pub driver: String,
    /// Vulkan version, `major.minor.patch`; empty for the CPU device.
    pub api: String,
    /// `discrete`, `integrated`, `virtual`, `cpu` or `other`.
    #[serde(rename = "type")]
    pub kind: String,
}

/// Bytes in use by budget class and by name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemoryReport {
    /// Bytes a budget class, classes without bytes left out.
    pub classes: BTreeMap<String, u64>,
    /// Bytes a name, greatest first.
    pub names: Vec<NamedMemory>,
    /// Sum of all bytes.
    pub total: u64,
    /// Most bytes that may be in use at once.
    pub budget: Option<u64>,
}

/// Bytes of all allocations of one name and class.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedMemory {
    /// Name of the allocations.
    pub name: String,
    /// Budget class.
    pub class: String,
    /// Bytes, alignment included.
    pub bytes: u64,
}

impl MemoryReport {
    /// Sums `(name, class, bytes)` rows.
    pub fn sum<'a>(rows: impl IntoIterator<Item = (&'a str, &'a str, u64)>) -> Self {
        let mut report = Self::default();
        let mut names = BTreeMap::<(&str, &str), u64>::new();
        for (name, class, bytes) in rows {
            *report.classes.entry(class.to_owned()).or_default() += bytes;
            *names.entry((name, class)).or_default() += bytes;
            report.total += bytes;
        }
        let named = |((name, class), bytes): ((&str, &str), u64)| NamedMemory {
            name: name.to_owned(),
            class: class.to_owned(),
            bytes,
        };
        report.names = names.into_iter().map(named).collect();
        report.names.sort_by_key(|n| std::cmp::Reverse(n.bytes));
        report
    }
}

/// When the steps of one frame ran on the device.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameTimings {
    /// One a timed step, or one a run of steps of one name; in the order of the frame. A sampled profile has only the
    /// names of one turn, each with all its steps.
    pub passes: Vec<PassTiming>,
    /// From the frame's begin to its end without the timestamps in between, nanoseconds.
    pub gpu_ns: u64,
    /// What a timestamp costs, nanoseconds: the median time between two with nothing between them. It is taken off all
    /// times here; on a device that drains its queue at every timestamp it is as long as a short pass.
    pub stamp_ns: u64,
    /// Frames in a row that time every name at least once: 1 where every step is timed.
    pub turns: u32,
    /// Recording of the command buffer on the CPU, nanoseconds.
    pub cpu_record_ns: u64,
}

impl FrameTimings {
    /// Name, number of steps and nanoseconds of all steps of one name, in order of first appearance.
    pub fn by_name(&self) -> Vec<(&str, usize, u64)> {
        let mut sums = Vec::<(&str, usize, u64)>::new();
        for pass in &self.passes {
            match sums.iter_mut().find(|s| s.0 == pass.name) {
                Some(sum) => {
                    (sum.1, sum.2) = (sum.1 + pass.steps as usize, sum.2 + pass.nanoseconds())
                }
                None => sums.push((&pass.name, pass.steps as usize, pass.nanoseconds())),
            }
        }
        sums
    }
}

/// When one step ran, on the device's own clock.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PassTiming {
    /// Name of the pass; `fill` and `copy` for transfers.
    pub name: String,
    /// Finer label of the (first) step, the pass name where none was given.
    pub label: String,
    /// Steps that ran in this time, one after the other.
    pub steps: u32,
    /// Begin, nanoseconds on the device's clock.
    pub begin_ns: u64,
    /// End, nanoseconds on the device's clock, without the timestamp that tells it.
    pub end_ns: u64,
}

impl PassTiming {
    /// Length in nanoseconds.
    pub fn nanoseconds(&self) -> u64 {
        self.end_ns.saturating_sub(self.begin_ns)
    }
}

/// How much work the iterative passes of one frame did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Iterations {
    /// Mean field evaluations a vertex in reach of a field.
    pub newton_mean: f64,
    /// Most field evaluations of a vertex.
    pub newton_max: u32,
    /// Rounds of projection and relaxation.
    pub rounds: u32,
    /// Jacobi iterations of all sub-steps.
    #[serde(default)]
    pub jacobi: u32,
    /// Sub-steps of the frame.
    pub substeps: u32,
    /// Sub-steps that were done again in two halves, because the whole left faults.
    #[serde(default)]
    pub halved: u32,
    /// The frame would have needed more sub-steps than it may have.
    #[serde(default)]
    pub capped: bool,
    /// Field evaluations of all vertices in the iterations.
    #[serde(default)]
    pub evaluations: u64,
    /// Texture fetches of all vertices.
    pub fetches: u64,
}

/// What the device can do at best, measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ceiling {
    /// Linearly filtered samples a second from a 3D half-float RGBA atlas.
    pub fetch3d_per_s: f64,
    /// Bytes read plus bytes written a second by a vec4 copy.
    pub copy_bytes_per_s: f64,
    /// Samples a second at the places where a projection takes them, with nothing else to do; 0 where there is none.
    #[serde(default)]
    pub replay3d_per_s: f64,
}

impl Ceiling {
    /// The greater of both, each for itself.
    pub fn max(self, other: Self) -> Self {
        Self {
            fetch3d_per_s: self.fetch3d_per_s.max(other.fetch3d_per_s),
            copy_bytes_per_s: self.copy_bytes_per_s.max(other.copy_bytes_per_s),
            replay3d_per_s: self.replay3d_per_s.max(other.replay3d_per_s),
        }
    }
}

/// How far a long task is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Progress {
    /// What is being done.
    pub stage: &'static str,
    /// Items done.
    pub done: usize,
    /// Items in all.
    pub total: usize,
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn memory_sums_by_class_and_name() {
        let rows = [("a", "mesh", 1), ("b", "mesh", 8), ("a", "mesh", 4)];
        let report = MemoryReport::sum(rows);
        assert_eq!((report.total, report.classes["mesh"]), (13, 13));
        let names: Vec<_> = report.names.iter().map(|n| (&*n.name, n.bytes)).collect();
        assert_eq!(names, [("b", 8), ("a", 5)]);
    }

    #[test]
    fn timings_sum_by_name_in_order_of_appearance() {
        let pass = |name: &str, begin_ns, end_ns| PassTiming {
            name: name.into(),
            label: name.into(),
            steps: 1,
            begin_ns,
            end_ns,
        };
        let passes = vec![pass("b", 0, 2), pass("a", 2, 7), pass("b", 7, 8)];
        let timings = FrameTimings {
            passes,
            ..Default::default()
        };
        assert_eq!(timings.by_name(), [("b", 2, 3), ("a", 1, 5)]);
    }

    #[test]
    fn device_kind_is_called_type_in_json() {
        let json = serde_json::to_value(DeviceReport::default()).unwrap();
        assert!(json.get("type").is_some());
    }
}
