//! `dermis devices`: what can compute here.

use dermis::{Error, Result, gpu::Gpu, report::DeviceReport};

use crate::{
    console::{self, Console},
    options::ReportOptions,
    table::Table,
};

/// List the devices that --device can name.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dermis devices
  dermis devices --json -                  as JSON, for scripts
  dermis bench arm.glb --device llvmpipe   by a part of its name
  dermis bench arm.glb --device 0          by its number")]
pub(crate) struct Args {
    #[command(flatten)]
    report: ReportOptions,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let console = Console::new(&args.report);
    let devices = match Gpu::enumerate() {
        Ok(devices) => devices,
        Err(Error::NoDevice { reason }) => {
            console.note(format_args!("no Vulkan device: {reason}"))?;
            Vec::new()
        }
        Err(error) => return Err(error),
    };
    let mut table = Table::new(5, ["--device", "name", "type", "Vulkan", "driver"]);
    for device in &devices {
        table.row(row(device.index.to_string(), device));
    }
    table.row(row("cpu".into(), &cpu_report()));
    console.text(format_args!("{}", table.to_string().trim_end()))?;
    console::json(&args.report, &devices)
}

fn row(number: String, device: &DeviceReport) -> [String; 5] {
    [
        number,
        device.name.clone(),
        device.kind.clone(),
        device.api.clone(),
        device.driver.clone(),
    ]
}

/// The CPU in the place of a device; it has no number.
pub(crate) fn cpu_report() -> DeviceReport {
    DeviceReport {
        name: "cpu".into(),
        driver: concat!("dermis ", env!("CARGO_PKG_VERSION")).into(),
        kind: "cpu".into(),
        ..DeviceReport::default()
    }
}
