//! A deformer in a host's frame: the host owns device, queue, command buffer and vertex buffer.

use ash::vk;
use glam::Mat4;

use super::{bundled, gpu, turned};
use crate::{
    deformer::{Deformer, Device, Method, Normals, Settings, Skin, VertexLayout},
    gpu::{Class, Gpu, GpuOptions, Handover, Host, HostCommands},
    pass::output::{BYTE_NORMALS, Constants},
    rig::{Pose, Rig},
    twin::{Args, Slot},
};

fn bent(rig: &Rig, degrees: f32) -> Pose {
    turned(rig, "lower", Mat4::from_rotation_z(degrees.to_radians()))
}

/// The device of `gpu` as a host would pass it on.
fn host(gpu: &Gpu) -> Host {
    // SAFETY: the loader is open as long as the process runs.
    let entry = unsafe { ash::Entry::load() }.unwrap();
    let family = gpu.shared.physical.family;
    let get_instance_proc_addr = entry.static_fn().get_instance_proc_addr;
    std::mem::forget(entry);
    Host {
        get_instance_proc_addr,
        instance: gpu.shared.instance.raw.handle(),
        physical_device: gpu.shared.physical.raw,
        device: gpu.device().handle(),
        // SAFETY: the device has one queue of this family.
        queue: unsafe { gpu.device().get_device_queue(family, 0) },
        queue_family: family,
        features: gpu.features(),
    }
}

fn handover() -> Handover {
    Handover {
        stages: vk::PipelineStageFlags::VERTEX_INPUT,
        access: vk::AccessFlags::VERTEX_ATTRIBUTE_READ,
        family: None,
    }
}

/// Bits of the positions in a host's vertices, and of the words after them.
fn vertices(bytes: &[u8], rows: usize, layout: VertexLayout) -> Vec<[u32; 6]> {
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
    let at = |row: usize| (layout.offset as usize + row * layout.stride as usize) / 4;
    (0..rows)
        .map(|row| std::array::from_fn(|k| words[at(row) + k]))
        .collect()
}

fn play(method: Method, normals: Normals) -> (Skin, Vec<[u32; 6]>, Skin) {
    let gpu = gpu().unwrap();
    let rig = bundled("arm.glb");
    let settings = Settings {
        method,
        ..Settings::default()
    };
    // SAFETY: the handles live until the end of this function, and nobody else uses the queue.
    let adopted = unsafe { Gpu::adopt(&host(&gpu), &GpuOptions::default()) }.unwrap();
    let device = Device::Gpu(adopted.clone());
    let mut deformer = Deformer::new(&device, rig.clone(), &settings).unwrap();
    let rows = rig.rows.vertex.len();
    let layout = VertexLayout {
        offset: 64,
        stride: 24,
        instance_stride: 0,
        normals,
    };
    let bytes = 64 + 24 * rows as u64;
    let buffer = gpu.buffer("host", Class::Transient, bytes).unwrap();
    gpu.upload(&buffer, &vec![0xab; bytes as usize]).unwrap();
    // SAFETY: the buffer is of this device, for storage use, and outlives the output.
    let hosted = unsafe { adopted.host_buffer(buffer.raw(), "host", bytes) }.unwrap();
    let mut output = deformer.output(&hosted, &layout, &handover()).unwrap();
    for (frame, degrees) in [20.0, 50.0, 90.0].into_iter().enumerate() {
        let pose = bent(&rig, degrees);
        let recorded = gpu.immediate("host", |recorder| {
            // SAFETY: recording; submitted and waited for by `immediate`.
            let commands = unsafe { HostCommands::new(recorder.raw) };
            deformer.record(&commands, frame % 2, &pose, Some(&mut output))
        });
        recorded.unwrap();
    }
    let written = vertices(&gpu.download(&buffer).unwrap(), rows, layout);
    let skin = deformer.read().unwrap();
    drop((output, hosted, deformer));
    assert_eq!(adopted.memory().total, 0, "all memory is given back");
    // The same poses on a device of its own.
    let mut own = Deformer::new(&Device::Gpu(gpu.clone()), rig.clone(), &settings).unwrap();
    for degrees in [20.0, 50.0, 90.0] {
        own.advance(&bent(&rig, degrees)).unwrap();
    }
    (skin, written, own.read().unwrap())
}

#[test]
fn a_frame_in_a_hosts_command_buffer_is_the_same_bits() {
    if gpu().is_none() {
        return;
    }
    for method in [Method::Lbs, Method::Dqs, Method::Implicit, Method::Tracking] {
        let (recorded, written, submitted) = play(method, Normals::Float(12));
        assert!(recorded == submitted, "{}", method.name());
        let rows = written.iter().zip(recorded.positions).zip(recorded.normals);
        for ((words, position), normal) in rows {
            let [px, py, pz, nx, ny, nz] = *words;
            assert_eq!([px, py, pz], position.to_array().map(f32::to_bits));
            assert_eq!([nx, ny, nz], normal.to_array().map(f32::to_bits));
        }
    }
}

/// The same vertices by the twin of the pass.
fn twin(skin: &Skin, constants: Constants) -> Vec<u8> {
    let rows = |x: &[glam::Vec3]| -> Vec<u32> {
        let all = x.iter().flat_map(|x| x.extend(0.0).to_array());
        all.map(f32::to_bits).collect()
    };
    let (positions, normals) = (rows(&skin.positions), rows(&skin.normals));
    let mut vertices = vec![0xabab_abab; 16 + 6 * skin.positions.len()];
    let slots = vec![
        Slot::Read(&positions),
        Slot::Read(&normals),
        Slot::Write(&mut vertices),
    ];
    let bytes = bytemuck::bytes_of(&constants);
    crate::twin::output::run(&mut Args::new(slots, bytes));
    bytemuck::cast_slice(&vertices).to_vec()
}

#[test]
fn packed_normals_are_within_half_a_step_and_the_rest_of_a_vertex_stays() {
    if gpu().is_none() {
        return;
    }
    let (recorded, written, _) = play(Method::Dqs, Normals::Byte(16));
    let rows = written.len();
    let constants = Constants {
        rows: rows as u32,
        offset: 16,
        stride: 6,
        normal_offset: 4,
        instance: 0,
        normals: BYTE_NORMALS,
    };
    let layout = VertexLayout {
        offset: 64,
        stride: 24,
        instance_stride: 0,
        normals: Normals::Byte(16),
    };
    assert!(vertices(&twin(&recorded, constants), rows, layout) == written);
    for (words, normal) in written.iter().zip(recorded.normals) {
        assert_eq!([words[3], words[5]], [0xabab_abab; 2]);
        let packed = words[4].to_le_bytes().map(|b| f32::from(b as i8) / 127.0);
        let apart = packed[..3].iter().zip(normal.to_array());
        assert!(apart.fold(0f32, |a, (p, n)| a.max((p - n).abs())) < 0.505 / 127.0);
    }
}

#[test]
fn outputs_of_others_slots_past_the_end_and_the_cpu_are_refused() {
    let Some(gpu) = gpu() else { return };
    let rig = bundled("arm.glb");
    let settings = Settings {
        method: Method::Dqs,
        ..Settings::default()
    };
    let new = |device: &Device| Deformer::new(device, rig.clone(), &settings).unwrap();
    let device = Device::Gpu(gpu.clone());
    let (mut one, other) = (new(&device), new(&device));
    let buffer = gpu.buffer("host", Class::Transient, 1 << 20).unwrap();
    let layout = VertexLayout {
        stride: 12,
        ..VertexLayout::default()
    };
    // SAFETY: as in `play`.
    let hosted = unsafe { gpu.host_buffer(buffer.raw(), "host", 1 << 20) }.unwrap();
    let mut output = other.output(&hosted, &layout, &handover()).unwrap();
    let rest = Pose::rest(&rig.skeleton);
    // SAFETY: refused before anything is recorded.
    let null = unsafe { HostCommands::new(vk::CommandBuffer::null()) };
    // SAFETY: refused, there is no buffer.
    let no_buffer = unsafe { gpu.host_buffer(vk::Buffer::null(), "host", 1) };
    let mut cpu = new(&Device::Cpu);
    let errors = [
        one.record(&null, 0, &rest, Some(&mut output)).unwrap_err(),
        one.record(&null, 2, &rest, None).unwrap_err(),
        cpu.record(&null, 0, &rest, None).unwrap_err(),
        no_buffer.err().unwrap(),
    ];
    let reasons = ["another deformer", "2 of 2", "cpu", "handle"];
    for (error, reason) in errors.iter().zip(reasons) {
        assert!(error.to_string().contains(reason), "{error}");
    }
}
