//! The device: adapters, buffers, pipelines, dispatches, reading back. Errors come back as values, never as panics.

use super::pipeline_files::PipelineFiles;
use crate::backend::BackendError;
use std::borrow::Cow;
use std::sync::{Arc, Mutex, PoisonError};

/// Invocations of a workgroup, in every shader. Also in the shaders' text, as `WORKGROUP`.
pub const WORKGROUP: u32 = 64;

/// A binding must hold one element of its array, also where a scene has none: larger than any struct of `layout`.
const MIN_BUFFER: u64 = 256;

/// A device with its queue.
pub struct Gpu {
    /// Makes things.
    pub device: wgpu::Device,
    /// Runs things.
    pub queue: wgpu::Queue,
    /// What it is.
    pub info: wgpu::AdapterInfo,
    /// Where compiled pipelines are kept.
    pipeline_files: Option<PipelineFiles>,
    /// The first fault that nobody asked for: lost, out of memory, a validation error.
    fault: Arc<Mutex<Option<String>>>,
}

/// Which adapters will do.
#[derive(Clone, Debug, Default)]
pub struct GpuOptions {
    /// Renderers in software (lavapipe) too: for tests; slower than the CPU back end.
    pub accept_software: bool,
    /// Part of the adapter's name, in any case; empty takes the first.
    pub name_contains: String,
}

/// All adapters, hardware first.
fn adapters() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    // Layers that check every call are for those who ask by the environment.
    descriptor.flags = wgpu::InstanceFlags::empty().with_env();
    let instance = wgpu::Instance::new(descriptor);
    let mut list = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let rank = |a: &wgpu::Adapter| match a.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    list.sort_by_key(rank);
    list
}

/// Names of all devices, hardware first: "NVIDIA H100 (Vulkan)".
pub fn list_devices() -> Vec<String> {
    adapters().iter().map(|a| device_name(&a.get_info())).collect()
}

/// All devices that open, hardware first; `accept_software` takes renderers in software too.
pub fn open_all(accept_software: bool) -> Vec<Gpu> {
    let wanted = |a: &&wgpu::Adapter| accept_software || a.get_info().device_type != wgpu::DeviceType::Cpu;
    adapters().iter().filter(wanted).filter_map(|a| Gpu::open(a).ok()).collect()
}

fn device_name(info: &wgpu::AdapterInfo) -> String {
    let software = if info.device_type == wgpu::DeviceType::Cpu { ", software" } else { "" };
    format!("{} ({}{software})", info.name, info.backend)
}

/// Whether shaders count in 32 bits alone though the device has 64: on many cards those take 64 times as long.
const BITS: &str = "RAYLOOM_GPU_BITS";

fn single_precision() -> Result<bool, BackendError> {
    match std::env::var_os(BITS) {
        None => Ok(false),
        Some(v) if v == "64" => Ok(false),
        Some(v) if v == "32" => Ok(true),
        Some(v) => Err(BackendError::NoDevice(format!("{BITS} is 32 or 64, not '{}'", v.to_string_lossy()))),
    }
}

impl Gpu {
    /// Opens the first adapter that will do.
    pub fn new(options: &GpuOptions) -> Result<Self, BackendError> {
        let wanted = options.name_contains.to_lowercase();
        let fits = |a: &wgpu::Adapter| {
            let info = a.get_info();
            (options.accept_software || info.device_type != wgpu::DeviceType::Cpu) && info.name.to_lowercase().contains(&wanted)
        };
        let all = adapters();
        let Some(adapter) = all.iter().find(|a| fits(a)) else {
            let seen: Vec<String> = all.iter().map(|a| device_name(&a.get_info())).collect();
            return Err(BackendError::NoDevice(if seen.is_empty() {
                "no graphics driver was found".into()
            } else if wanted.is_empty() {
                format!("none of the devices will do: {}", seen.join(", "))
            } else {
                format!("none of the devices is called '{}': {}", options.name_contains, seen.join(", "))
            }));
        };
        Self::open(adapter)
    }

    fn open(adapter: &wgpu::Adapter) -> Result<Self, BackendError> {
        let double = if single_precision()? { wgpu::Features::empty() } else { wgpu::Features::SHADER_F64 };
        let wanted = double | wgpu::Features::PIPELINE_CACHE | wgpu::Features::TIMESTAMP_QUERY;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("rayloom"),
            required_features: adapter.features() & wanted,
            required_limits: adapter.limits(),
            memory_hints: wgpu::MemoryHints::Performance,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| BackendError::NoDevice(e.to_string()))?;
        let fault = Arc::new(Mutex::new(None));
        let keep = |fault: &Arc<Mutex<Option<String>>>, text: String| {
            fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(text);
        };
        let (lost, uncaptured) = (fault.clone(), fault.clone());
        device.set_device_lost_callback(move |reason, message| {
            let was_destroyed = reason == wgpu::DeviceLostReason::Destroyed && message.is_empty();
            keep(&lost, if was_destroyed { "it was destroyed".into() } else { message });
        });
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| keep(&uncaptured, e.to_string())));
        let info = adapter.get_info();
        let pipeline_files = PipelineFiles::new(&device, &info);
        Ok(Self { device, queue, info, pipeline_files, fault })
    }

    /// Whether shaders may use numbers of 64 bits: the feature `double` of those that hold geometry.
    pub fn has_double(&self) -> bool {
        self.device.features().contains(wgpu::Features::SHADER_F64)
    }

    /// "NVIDIA H100 (Vulkan)".
    pub fn name(&self) -> String {
        device_name(&self.info)
    }

    /// The first fault so far, as an error.
    pub fn check(&self) -> Result<(), BackendError> {
        match &*self.fault.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(text) => Err(BackendError::DeviceLost(text.clone())),
            None => Ok(()),
        }
    }

    /// Largest storage buffer that a shader may see, in bytes.
    pub fn max_binding(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
    }

    fn fits(&self, what: &str, needed: u64) -> Result<(), BackendError> {
        let limit = self.max_binding();
        if needed > limit { Err(BackendError::TooLarge { what: what.to_owned(), needed, limit }) } else { Ok(()) }
    }

    /// A storage buffer that holds `bytes` (at least `MIN_BUFFER`).
    pub fn storage_buffer(&self, what: &str, bytes: &[u8]) -> Result<wgpu::Buffer, BackendError> {
        let buffer = self.empty_buffer(what, bytes.len() as u64)?;
        if !bytes.is_empty() {
            self.queue.write_buffer(&buffer, 0, bytes);
        }
        Ok(buffer)
    }

    /// A storage buffer of `size` bytes (at least `MIN_BUFFER`) that can be copied from and to.
    pub fn empty_buffer(&self, what: &str, size: u64) -> Result<wgpu::Buffer, BackendError> {
        let size = size.max(MIN_BUFFER).next_multiple_of(16);
        self.fits(what, size)?;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false });
        match pollster::block_on(scope.pop()) {
            Some(e) => Err(BackendError::DeviceLost(format!("{what}: {e}"))),
            None => Ok(buffer),
        }
    }

    /// A uniform buffer with these bytes, which can be written again.
    pub fn uniform_buffer(&self, what: &str, bytes: &[u8]) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let size = (bytes.len() as u64).next_multiple_of(16);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false });
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// Layout of one bind group.
    pub fn group_layout(&self, label: &str, entries: &[wgpu::BindGroupLayoutEntry]) -> wgpu::BindGroupLayout {
        self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
    }

    /// Whole buffers at their bindings.
    pub fn bind_group(&self, layout: &wgpu::BindGroupLayout, buffers: &[(u32, &wgpu::Buffer)]) -> wgpu::BindGroup {
        let entries: Vec<wgpu::BindGroupEntry> =
            buffers.iter().map(|(binding, b)| wgpu::BindGroupEntry { binding: *binding, resource: b.as_entire_binding() }).collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }

    /// A pipeline from WGSL text.
    pub fn compute_pipeline(
        &self,
        label: &str,
        text: &str,
        entry_point: &str,
        groups: &[&wgpu::BindGroupLayout],
    ) -> Result<wgpu::ComputePipeline, BackendError> {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let source = wgpu::ShaderSource::Wgsl(Cow::Borrowed(text));
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source });
        let groups: Vec<Option<&wgpu::BindGroupLayout>> = groups.iter().map(|g| Some(*g)).collect();
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(label),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let file = self.pipeline_files.as_ref().map(|f| f.file(&self.device, text, entry_point));
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(label),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions { zero_initialize_workgroup_memory: false, ..Default::default() },
            cache: file.as_ref().map(|f| &f.cache),
        });
        match pollster::block_on(scope.pop()) {
            Some(e) => Err(BackendError::Unsupported(format!("shader '{label}': {e}"))),
            None => {
                if let Some(file) = file {
                    file.keep();
                }
                Ok(pipeline)
            }
        }
    }

    /// Runs a pipeline for at least `n` invocations.
    pub fn dispatch(&self, encoder: &mut wgpu::CommandEncoder, pipeline: &wgpu::ComputePipeline, groups: &[&wgpu::BindGroup], n: u32) {
        self.dispatch_timed(encoder, pipeline, groups, n, None);
    }

    /// The same, with the times when it began and ended written down.
    pub fn dispatch_timed(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::ComputePipeline,
        groups: &[&wgpu::BindGroup],
        n: u32,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let n_groups = n.div_ceil(WORKGROUP);
        if n_groups == 0 {
            return;
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
        pass.set_pipeline(pipeline);
        for (k, group) in groups.iter().enumerate() {
            pass.set_bind_group(k as u32, *group, &[]);
        }
        pass.dispatch_workgroups(n_groups, 1, 1);
    }

    /// A buffer that the host can read.
    pub fn read_buffer(&self, size: u64) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        self.device.create_buffer(&wgpu::BufferDescriptor { label: Some("read back"), size, usage, mapped_at_creation: false })
    }

    /// Submits what was recorded and reads `size` bytes of a buffer once it is done.
    pub fn submit_and_read(
        &self,
        encoder: wgpu::CommandEncoder,
        buffer: &wgpu::Buffer,
        offset: u64,
        size: u64,
    ) -> Result<Vec<u8>, BackendError> {
        self.submit_and_read_into(encoder, buffer, offset, size, &self.read_buffer(size))
    }

    /// The same through a buffer that is there: making one takes longer than small answers do.
    pub fn submit_and_read_into(
        &self,
        encoder: wgpu::CommandEncoder,
        buffer: &wgpu::Buffer,
        offset: u64,
        size: u64,
        copy: &wgpu::Buffer,
    ) -> Result<Vec<u8>, BackendError> {
        self.submit_and_map(encoder, buffer, offset, size, copy, <[u8]>::to_vec)
    }

    /// The same, with the bytes shown to `take` where they lie.
    pub fn submit_and_map<R>(
        &self,
        mut encoder: wgpu::CommandEncoder,
        buffer: &wgpu::Buffer,
        offset: u64,
        size: u64,
        copy: &wgpu::Buffer,
        take: impl FnOnce(&[u8]) -> R,
    ) -> Result<R, BackendError> {
        encoder.copy_buffer_to_buffer(buffer, offset, copy, 0, size);
        self.queue.submit([encoder.finish()]);
        copy.map_async(wgpu::MapMode::Read, ..size, |_| {});
        let lost = |e: String| BackendError::DeviceLost(e);
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| lost(e.to_string()))?;
        self.check()?;
        let taken = take(&copy.get_mapped_range(..size).map_err(|e| lost(e.to_string()))?);
        copy.unmap();
        Ok(taken)
    }
}

/// A storage buffer at a binding.
pub fn binding_layout(binding: u32, writable: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: !writable },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

/// A uniform buffer at a binding.
pub fn uniform_layout(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        ty: wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Uniform, has_dynamic_offset: false, min_binding_size: None },
        ..binding_layout(binding, false)
    }
}
