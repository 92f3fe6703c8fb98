//! Devices for tests: validated, and a test fails when the layers said anything.

use std::{ops::Deref, sync::Arc};

use super::{Features, Gpu, GpuOptions, instance::Canary};

/// A validated device; dropping it checks that the layers stayed silent to the device's end.
pub(crate) struct TestGpu {
    gpu: Option<Gpu>,
    canary: Arc<Canary>,
}

/// A validated device, or `None` where `DERMIS_NO_GPU=1` asks for the skip.
pub(crate) fn gpu() -> Option<TestGpu> {
    with(&GpuOptions::default(), Features::ALL)
}

/// As [`gpu`], with options and features.
pub(crate) fn with(options: &GpuOptions, features: Features) -> Option<TestGpu> {
    if std::env::var("DERMIS_NO_GPU").is_ok_and(|v| v == "1") {
        eprintln!("skipped: DERMIS_NO_GPU=1");
        return None;
    }
    let options = GpuOptions {
        validation: true,
        ..options.clone()
    };
    match Gpu::with_features(&options, features) {
        Ok(gpu) => {
            let canary = gpu.shared.instance.canary.clone();
            Some(TestGpu {
                gpu: Some(gpu),
                canary,
            })
        }
        Err(error) => panic!("{error} (DERMIS_NO_GPU=1 skips tests that need a device)"),
    }
}

impl TestGpu {
    /// Messages so far; also forgets them, for tests that provoke one.
    pub(crate) fn take_messages(&self) -> Vec<String> {
        self.canary.take()
    }
}

impl Deref for TestGpu {
    type Target = Gpu;

    fn deref(&self) -> &Gpu {
        self.gpu.as_ref().expect("present until dropped")
    }
}

impl Drop for TestGpu {
    fn drop(&mut self) {
        self.gpu = None;
        let messages = self.canary.messages();
        if !messages.is_empty() && !std::thread::panicking() {
            panic!("validation: {messages:#?}");
        }
    }
}
