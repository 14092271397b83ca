//! The scene on the device: normalised to the unit sphere, in leaf order, behind bind group 0.

use glam::{DVec3, Vec3};
use wgpu::util::DeviceExt;

use super::context::Context;
use super::layout::SceneUniform;
use super::{lights, surface};
use crate::accel;
use crate::scene::material::GLOSSY_AS_SPECULAR_ALPHA;
use crate::scene::{Camera, Features, Scene};
use crate::{Error, Result};

/// Plain data of bind group 0, made without a device.
#[derive(Debug, Clone)]
pub struct SceneData {
    pub uniform: SceneUniform,
    pub nodes: Vec<[u32; 20]>,
    /// v0, v1 - v0, v2 - v0 per triangle; where emission is textured, the first has its mean luminance beside it, and the
    /// second 1 where its back is culled.
    pub triangles: Vec<[f32; 4]>,
    /// Octahedral normals and material per triangle.
    pub shading: Vec<[u32; 4]>,
    /// Materials, then the alias table, then the textures.
    pub tables: Vec<[u32; 4]>,
    /// What the triangles' corners have besides, and the images; empty where no material needs them.
    pub corners: Vec<u32>,
    pub texels: Vec<u32>,
    /// Whether the rows of `triangles` go into buffers of their own ([`Features::split`]).
    pub split: bool,
    /// Centre and radius of what becomes the unit sphere.
    sphere: (Vec3, f32),
}

impl SceneData {
    /// Packs `scene` as seen by `camera` on a film of the given size in pixels.
    pub fn new(scene: &Scene, camera: &Camera, width: u32, height: u32) -> Result<Self> {
        Self::with_threshold(scene, camera, width, height, GLOSSY_AS_SPECULAR_ALPHA)
    }

    /// The same where lobes with alpha below `threshold` are treated as specular, as `Features::with_threshold` has them.
    pub fn with_threshold(scene: &Scene, camera: &Camera, width: u32, height: u32, threshold: f32) -> Result<Self> {
        let threshold = scene.specular_threshold(threshold);
        let (centre, radius) = scene.bounding_sphere();
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(Error::input(format!("{} has no extent: its triangles all lie in one point", scene.name)));
        }
        let normalised = |p: Vec3| ((DVec3::from(p) - DVec3::from(centre)) / f64::from(radius)).as_vec3();
        let positions: Vec<Vec3> = scene.positions.iter().map(|p| normalised(*p)).collect();
        let corners: Vec<[Vec3; 3]> = scene.triangles.iter().map(|t| t.map(|i| positions[i as usize])).collect();
        let accel = accel::build(&corners)?;

        let features = Features::with_threshold(scene, threshold);
        let emission = scene.mean_emission();
        let mut triangles = Vec::with_capacity(3 * corners.len());
        let mut shading = Vec::with_capacity(corners.len());
        for &source in &accel.order {
            let [a, b, c] = corners[source as usize];
            let mean = if features.emission_mapped { emission[source as usize] as f32 } else { 0.0 };
            let material = scene.triangle_materials[source as usize];
            let culled = if scene.materials[material as usize].is_culled() { 1.0 } else { 0.0 };
            for (v, w) in [(a, mean), (b - a, culled), (c - a, 0.0)] {
                triangles.push([v.x, v.y, v.z, w]);
            }
            let n = scene.triangles[source as usize].map(|i| surface::encode_octahedral(scene.normals[i as usize]));
            shading.push([n[0], n[1], n[2], material]);
        }

        let (mut weights, mut emitters) = lights::emitters(scene, &accel.order, &corners, &emission);
        let others = lights::others(scene, radius);
        others.add_to(&mut weights, &mut emitters);
        let lights_rows = weights.len() + if features.mixed { lights::HEADER_ROWS } else { 0 };
        let (mut tables, textures) = surface::materials(scene, features, threshold, lights_rows);
        let lights_offset = tables.len() + lights_rows - weights.len();
        if features.mixed {
            tables.extend(others.header(tables.len() + lights_rows + textures.len()));
        }
        tables.extend(lights::alias_table(&weights, &emitters));
        tables.extend(textures);
        tables.extend(others.rows);

        let uniform = SceneUniform {
            sky: scene.sky.unwrap_or(Vec3::ZERO).into(),
            light_count: emitters.len() as u32,
            light_weight: weights.iter().sum::<f64>() as f32,
            lights_offset: lights_offset as u32,
            ..Default::default()
        };
        let corners = surface::corners(scene, features, &accel.order);
        let texels = if features.textured { surface::texels(scene) } else { Vec::new() };
        let (nodes, sphere) = (accel.nodes, (centre, radius));
        let mut data =
            Self { uniform, nodes, triangles, shading, tables, corners, texels, split: features.split, sphere };
        data.aim(camera, width, height);
        Ok(data)
    }

    /// Lets another camera see the scene, or a film of another size in pixels.
    pub fn aim(&mut self, camera: &Camera, width: u32, height: u32) {
        let (centre, radius) = self.sphere;
        let eye: Vec3 = camera.world_from_camera.translation.into();
        let pixels_per_unit = match camera.orthographic_height {
            None => 0.5 * height as f32 / (0.5 * camera.vertical_fov).tan(),
            Some(seen) => height as f32 * radius / seen,
        };
        let world_from_camera = camera.world_from_camera.matrix3;
        self.uniform = SceneUniform {
            camera_position: ((DVec3::from(eye) - DVec3::from(centre)) / f64::from(radius)).as_vec3().into(),
            pixel_area: 1.0 / (pixels_per_unit * pixels_per_unit),
            camera_right: Vec3::from(world_from_camera.x_axis).normalize().into(),
            film_width: width as f32,
            camera_up: Vec3::from(world_from_camera.y_axis).normalize().into(),
            film_height: height as f32,
            camera_back: Vec3::from(world_from_camera.z_axis).normalize().into(),
            pixels_per_unit,
            lens_radius: camera.lens.map_or(0.0, |lens| 0.5 * lens.aperture / radius),
            focus_distance: camera.lens.map_or(1.0, |lens| lens.focus / radius),
            ..self.uniform
        };
    }

    /// As little as can be bound where a scene has `features`: for dispatches of nothing.
    pub fn nothing(features: Features) -> Self {
        Self {
            uniform: SceneUniform::default(),
            nodes: vec![[0; 20]],
            triangles: vec![[0.0; 4]],
            shading: vec![[0; 4]],
            tables: vec![[0; 4]],
            corners: vec![0; usize::from(features.textured)],
            texels: vec![0; usize::from(features.textured)],
            split: features.split,
            sphere: (Vec3::ZERO, 1.0),
        }
    }
}

/// Storage buffers of bind group 1, which share a device's limit with those of the scene.
const RUN_BUFFERS: usize = 4;

/// Bind group 0 on a device.
pub struct GpuScene {
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
}

impl GpuScene {
    /// Uploads `data`; an error if a part exceeds what the device can bind.
    pub fn new(context: &Context, data: &SceneData) -> Result<Self> {
        let device = &context.device;
        let rows = |row| data.triangles.iter().skip(row).step_by(3).copied().collect::<Vec<_>>();
        let split = if data.split { [0, 1, 2].map(rows) } else { Default::default() };
        let triangles = if data.split { &split[0] } else { &data.triangles };
        let mut parts: Vec<(&str, &[u8], &str)> = vec![
            ("search tree", bytemuck::cast_slice(&data.nodes), "fewer triangles"),
            ("triangles", bytemuck::cast_slice(triangles), "fewer triangles"),
            ("normals", bytemuck::cast_slice(&data.shading), "fewer triangles"),
            ("materials", bytemuck::cast_slice(&data.tables), "fewer materials and lights"),
        ];
        if !data.texels.is_empty() {
            parts.push(("texture coordinates", bytemuck::cast_slice(&data.corners), "fewer triangles"));
            parts.push(("images", bytemuck::cast_slice(&data.texels), "smaller images"));
        }
        if data.split {
            parts.extend(split[1..].iter().map(|rows| ("triangles", bytemuck::cast_slice(rows), "fewer triangles")));
        }
        let limits = device.limits();
        let most = limits.max_storage_buffers_per_shader_stage as usize;
        if parts.len() + RUN_BUFFERS > most {
            let need = parts.len() + RUN_BUFFERS;
            return Err(Error::runtime(format!(
                "this scene needs {need} storage buffers and this device binds at most {most}: use another device"
            )));
        }
        let limit = limits.max_storage_buffer_binding_size;
        for (what, bytes, advice) in &parts {
            if bytes.len() as u64 > limit {
                return Err(Error::input(format!(
                    "the scene's {what} take {} MiB and this device binds at most {} MiB: use {advice} or another device",
                    bytes.len() >> 20,
                    limit >> 20
                )));
            }
        }
        let buffer = |label, usage, contents| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let uniform = buffer("scene", wgpu::BufferUsages::UNIFORM, bytemuck::bytes_of(&data.uniform));
        let storage: Vec<wgpu::Buffer> =
            parts.iter().map(|(label, bytes, _)| buffer(label, wgpu::BufferUsages::STORAGE, bytes)).collect();
        let mut kinds = vec![wgpu::BufferBindingType::Uniform];
        kinds.resize(1 + storage.len(), wgpu::BufferBindingType::Storage { read_only: true });
        let layout = super::buffer_layout(device, "scene", &kinds, None);
        let buffers: Vec<&wgpu::Buffer> = std::iter::once(&uniform).chain(&storage).collect();
        let group = super::buffer_group(device, &layout, &buffers, None);
        Ok(Self { layout, group })
    }
}
