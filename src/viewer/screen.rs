//! Pictures on the screen, by a pipeline of their own over the window's device.

use std::collections::HashMap;
use std::sync::Arc;

use eframe::egui::{self, ColorImage, Rect};
use eframe::egui_wgpu::{self, CallbackResources, CallbackTrait, RenderState, ScreenDescriptor};
use eframe::wgpu;
use wgpu::util::DeviceExt;

const SHADER: &str = include_str!("screen.wgsl");

/// A picture to paint: what of it, and how.
pub struct Screen {
    pub slot: usize,
    pub colors: Arc<ColorImage>,
    /// Another number for other colours.
    pub version: u64,
    /// Blends neighbouring pixels where it is scaled; else they stay sharp.
    pub smooth: bool,
    /// Which part of it fills the rectangle, in [0, 1].
    pub part: Rect,
}

impl Screen {
    /// The shape that paints it into `rect`.
    pub fn shape(self, rect: Rect) -> egui::Shape {
        egui_wgpu::Callback::new_paint_callback(rect, self).into()
    }
}

/// What is on the device for one picture.
struct Held {
    version: u64,
    part: wgpu::Buffer,
    /// Sharp and smooth.
    groups: [wgpu::BindGroup; 2],
}

/// The pipeline, and the pictures by their slots.
struct Painter {
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    samplers: [wgpu::Sampler; 2],
    /// The colours are encoded as sRGB; where the window decodes, so must the texture.
    format: wgpu::TextureFormat,
    held: HashMap<usize, Held>,
}

/// Makes the window able to show [`Screen`]s.
pub fn install(state: &RenderState) {
    let painter = Painter::new(&state.device, state.target_format);
    state.renderer.write().callback_resources.insert(painter);
}

impl Painter {
    fn new(device: &wgpu::Device, target: wgpu::TextureFormat) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("screen"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("screen"),
            entries: &[
                entry(0, wgpu::ShaderStages::FRAGMENT, texture),
                entry(1, wgpu::ShaderStages::FRAGMENT, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
                entry(2, wgpu::ShaderStages::VERTEX, uniform),
            ],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("screen"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("screen"),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("corner"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("color"),
                compilation_options: Default::default(),
                targets: &[Some(target.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let samplers = [wgpu::FilterMode::Nearest, wgpu::FilterMode::Linear].map(|filter| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("screen"),
                mag_filter: filter,
                min_filter: filter,
                ..Default::default()
            })
        });
        let format =
            if target.is_srgb() { wgpu::TextureFormat::Rgba8UnormSrgb } else { wgpu::TextureFormat::Rgba8Unorm };
        Self { pipeline, layout, samplers, format, held: HashMap::new() }
    }

    fn upload(&self, device: &wgpu::Device, queue: &wgpu::Queue, colors: &ColorImage, version: u64) -> Held {
        let [width, height] = colors.size.map(|side| side as u32);
        let descriptor = wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        };
        let order = wgpu::util::TextureDataOrder::LayerMajor;
        let texture = device.create_texture_with_data(queue, &descriptor, order, colors.as_raw());
        let view = texture.create_view(&Default::default());
        let part = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("part"),
            size: 16,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let groups = [0, 1].map(|smooth| {
            let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("screen"),
                layout: &self.layout,
                entries: &[
                    entry(0, wgpu::BindingResource::TextureView(&view)),
                    entry(1, wgpu::BindingResource::Sampler(&self.samplers[smooth])),
                    entry(2, part.as_entire_binding()),
                ],
            })
        });
        Held { version, part, groups }
    }
}

impl CallbackTrait for Screen {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _: &ScreenDescriptor,
        _: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(painter) = resources.get_mut::<Painter>() {
            if painter.held.get(&self.slot).is_none_or(|held| held.version != self.version) {
                let held = painter.upload(device, queue, &self.colors, self.version);
                painter.held.insert(self.slot, held);
            }
            let (min, size) = (self.part.min, self.part.size());
            let words = [min.x, min.y, size.x, size.y];
            queue.write_buffer(&painter.held[&self.slot].part, 0, bytemuck::cast_slice(&words));
        }
        Vec::new()
    }

    fn paint(&self, _: egui::PaintCallbackInfo, pass: &mut wgpu::RenderPass<'static>, resources: &CallbackResources) {
        let Some(painter) = resources.get::<Painter>() else { return };
        let Some(held) = painter.held.get(&self.slot) else { return };
        pass.set_pipeline(&painter.pipeline);
        pass.set_bind_group(0, &held.groups[usize::from(self.smooth)], &[]);
        pass.draw(0..3, 0..1);
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_shader_validates() {
        let module = naga::front::wgsl::parse_str(super::SHADER).unwrap();
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
            .validate(&module)
            .unwrap();
    }
}
