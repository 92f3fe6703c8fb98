//! dm_frame_record allocates nothing, from the first frame on, whatever the method and the number of sub-steps.
// Pointers are NULL or to what lives until the call returns; Vulkan's handles live as long as the host.
#![allow(clippy::unwrap_used, clippy::undocumented_unsafe_blocks)]

#[path = "../../../tests/common/allocations.rs"]
mod allocations;
#[allow(dead_code, reason = "the other tests use the rest")]
#[path = "abi/host_device.rs"]
mod host_device;
#[path = "shared/stage.rs"]
mod stage;

use dermis::capi::*;

use host_device::HostDevice;
use stage::Stage;

/// Turns of all joints but the root, in degrees: small ones, then further and further at once.
const TURNS: [f32; 8] = [5.0, 10.0, 8.0, 40.0, -20.0, 70.0, -90.0, 60.0];

#[test]
fn recording_a_frame_allocates_nothing() {
    if std::env::var("DERMIS_NO_GPU").is_ok_and(|v| v == "1") {
        eprintln!("skipped: DERMIS_NO_GPU=1");
        return;
    }
    let host = HostDevice::with_layers(&[]);
    for method in [DM_LBS, DM_DQS, DM_IMPLICIT, DM_TRACKING] {
        let stage = Stage::new(&host, "arm", method);
        let mut substeps = Vec::new();
        for (frame, turn) in TURNS.into_iter().enumerate() {
            let pose = stage.turned(turn);
            host.run(|| {
                let before = allocations::so_far();
                stage.record(frame as u32 % 2, &pose);
                let allocated = allocations::so_far() - before;
                assert_eq!(allocated, 0, "method {method}, frame {frame}");
            });
            substeps.push(stage.iterations().substeps);
        }
        if method == DM_TRACKING {
            assert!(substeps[TURNS.len() - 2] > 4, "{substeps:?}");
        }
        stage.end();
    }
    allocations::are_counted();
    host.end();
}
