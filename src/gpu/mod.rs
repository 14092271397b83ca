//! The device: context, scene buffers, shaders and dispatch.

pub mod context;
pub mod layout;
pub(crate) mod lights;
pub mod pipelines;
pub mod run;
pub mod scene;
pub mod shader;
pub mod surface;
mod timer;
mod workgroups;

/// A bind group layout of buffers for compute, in binding order; the binding `dynamic` takes an offset per dispatch.
fn buffer_layout(
    device: &wgpu::Device,
    label: &str,
    kinds: &[wgpu::BufferBindingType],
    dynamic: Option<usize>,
) -> wgpu::BindGroupLayout {
    let entries: Vec<wgpu::BindGroupLayoutEntry> = kinds
        .iter()
        .enumerate()
        .map(|(i, kind)| wgpu::BindGroupLayoutEntry {
            binding: i as u32,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty: *kind, has_dynamic_offset: dynamic == Some(i), min_binding_size: None },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// The group that goes with [`buffer_layout`]; a dynamic binding sees `window` bytes.
fn buffer_group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
    window: Option<(usize, u64)>,
) -> wgpu::BindGroup {
    let entries: Vec<wgpu::BindGroupEntry> = buffers
        .iter()
        .enumerate()
        .map(|(i, buffer)| wgpu::BindGroupEntry {
            binding: i as u32,
            resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset: 0,
                size: window.filter(|w| w.0 == i).and_then(|w| wgpu::BufferSize::new(w.1)),
            }),
        })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}
