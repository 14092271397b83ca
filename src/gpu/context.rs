//! The device: found, described, opened.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use super::shader::{Sources, Variant, validate};
use super::workgroups::WORKGROUP;
use crate::{Error, Result};

/// An open device with its queue.
pub struct Context {
    adapter: wgpu::Adapter,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// Name and driver, for messages and metadata.
    pub description: String,
    /// True for a driver that renders on the CPU, such as lavapipe.
    pub software: bool,
    /// Pipelines that have run on the device, so that a renderer that starts again need not compile again. Their layouts
    /// are the same for every run.
    pipelines: Mutex<HashMap<Variant, wgpu::ComputePipeline>>,
    fault: Arc<OnceLock<Fault>>,
    sources: Mutex<Sources>,
    /// Threads a workgroup.
    pub(super) workgroup: u32,
}

/// What a device has said of itself outside of any call; nothing that it does afterwards can be relied on.
#[derive(Debug, Clone)]
enum Fault {
    Lost(String),
    OutOfMemory,
    Other(String),
}

/// A device that could be opened.
#[derive(Debug, Clone)]
pub struct DeviceDescription {
    pub name: String,
    pub backend: String,
    pub driver: String,
    pub software: bool,
}

/// What to say where [`list`] is empty.
pub const NO_DEVICE: &str = "no Vulkan device was found: install a driver, for software rendering 'apt install libvulkan1 mesa-vulkan-drivers' (Debian, Ubuntu), 'dnf install vulkan-loader mesa-vulkan-drivers' (Fedora) or 'pacman -S vulkan-icd-loader vulkan-swrast' (Arch)";

fn adapters() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::VULKAN,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
    // Fastest kind first; stable, so the loader's order decides among equals.
    adapters.sort_by_key(|a| match a.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    adapters
}

fn describe(info: &wgpu::AdapterInfo) -> DeviceDescription {
    DeviceDescription {
        name: info.name.clone(),
        backend: format!("{:?}", info.backend),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_string(),
        software: info.device_type == wgpu::DeviceType::Cpu,
    }
}

/// Every device, the preferred one first.
pub fn list() -> Vec<DeviceDescription> {
    adapters().iter().map(|a| describe(&a.get_info())).collect()
}

/// The first device whose name contains `name` (any case), or the preferred one.
pub fn find(name: Option<&str>) -> Result<DeviceDescription> {
    Ok(describe(&adapter(name)?.get_info()))
}

fn adapter(name: Option<&str>) -> Result<wgpu::Adapter> {
    let mut adapters = adapters();
    if adapters.is_empty() {
        return Err(Error::runtime(NO_DEVICE));
    }
    let names: Vec<String> = adapters.iter().map(|a| a.get_info().name).collect();
    let wanted = |own: &String| name.is_none_or(|n| own.to_lowercase().contains(&n.to_lowercase()));
    let place = names.iter().position(wanted).ok_or_else(|| {
        Error::input(format!("no device is called '{}': choose one of {}", name.unwrap_or_default(), names.join(", ")))
    })?;
    Ok(adapters.swap_remove(place))
}

impl Context {
    /// Opens the device that [`find`] finds.
    pub fn open(name: Option<&str>) -> Result<Self> {
        Self::on(&adapter(name)?)
    }

    /// A new device of `adapter`.
    fn on(adapter: &wgpu::Adapter) -> Result<Self> {
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("emlt"),
            // The clock, where there is one, is for statistics alone.
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: limits(adapter),
            ..Default::default()
        }))
        .map_err(|e| Error::runtime(format!("the device could not be opened: {e}")))?;
        Ok(Self::over(adapter, device, queue))
    }

    fn over(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let description = describe(&adapter.get_info());
        // The first fault explains those that follow from it.
        let fault = Arc::new(OnceLock::new());
        let told = Arc::clone(&fault);
        device.set_device_lost_callback(move |_, message| {
            let _ = told.set(Fault::Lost(message));
        });
        let told = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |error| {
            let _ = told.set(match error {
                wgpu::Error::OutOfMemory { .. } => Fault::OutOfMemory,
                error => Fault::Other(error.to_string()),
            });
        }));
        Self {
            adapter: adapter.clone(),
            device,
            queue,
            description: format!("{} ({})", description.name, description.driver),
            software: description.software,
            pipelines: Mutex::default(),
            fault,
            sources: Mutex::default(),
            workgroup: WORKGROUP,
        }
    }

    /// The same device with workgroups of so many threads, which no result may show (tests/images/workgroups.rs).
    pub fn with_workgroups_of(self, threads: u32) -> Self {
        Self { workgroup: threads, ..self }
    }

    /// Whether the device is gone: whoever wants to go on opens another.
    pub fn is_lost(&self) -> bool {
        matches!(self.fault.get(), Some(Fault::Lost(_)))
    }

    /// An error once anything has gone wrong on the device, as it says outside of any call.
    pub(super) fn check(&self) -> Result<()> {
        match self.fault.get() {
            None => Ok(()),
            Some(Fault::Lost(why)) => Err(Error::runtime(format!(
                "the device was lost ({}): run again, and if it happens again choose another with --device",
                why.lines().next().unwrap_or_default()
            ))),
            Some(Fault::OutOfMemory) => Err(Error::runtime(
                "the device has not enough memory: choose a smaller --size or --ensemble, or another --device",
            )),
            Some(Fault::Other(why)) => {
                Err(Error::runtime(format!("the device refuses its work, please report it: {why}")))
            }
        }
    }

    /// What opens another device of the same kind, which shares nothing but the driver's caches.
    pub(super) fn another(&self) -> impl FnOnce() -> Result<Self> + Send + 'static {
        let (adapter, sources, workgroup) = (self.adapter.clone(), self.sources(), self.workgroup);
        move || Self::on(&adapter).map(|context| Self { sources: Mutex::new(sources), workgroup, ..context })
    }

    /// The sources of pipelines that are built from now on.
    pub fn sources(&self) -> Sources {
        self.sources.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Takes other sources if every shader in use can be made of them; then all pipelines are to be built anew.
    pub fn set_sources(&self, sources: Sources) -> Result<()> {
        let mut pipelines = self.pipelines();
        for variant in pipelines.keys() {
            let valid = sources.compose(variant).and_then(|text| validate(&text));
            // Composer and validator draw pictures of several lines.
            let sentence = |why: String| why.split_whitespace().collect::<Vec<_>>().join(" ");
            valid.map_err(|why| {
                Error::input(format!("the last good shaders stay, {} has a fault: {}", variant.pass, sentence(why)))
            })?;
        }
        pipelines.clear();
        *self.sources.lock().unwrap_or_else(PoisonError::into_inner) = sources;
        Ok(())
    }

    pub(super) fn pipelines(&self) -> MutexGuard<'_, HashMap<Variant, wgpu::ComputePipeline>> {
        // A map of whole entries: a thread that panics leaves it in order.
        self.pipelines.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What a renderer asks of a device: the default limits, and buffers as large as it has them.
pub fn limits(adapter: &wgpu::Adapter) -> wgpu::Limits {
    let offered = adapter.limits();
    wgpu::Limits {
        max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
        max_buffer_size: offered.max_buffer_size,
        // 8 do for scenes without textures; every desktop driver offers more.
        max_storage_buffers_per_shader_stage: offered.max_storage_buffers_per_shader_stage.min(16),
        ..wgpu::Limits::default()
    }
}
