//! The device's scattering functions, called on lists of directions (shaders/passes/bsdf_probe.wesl).

use emlt::gpu::context::Context;
use emlt::gpu::layout::PassUniform;
use emlt::gpu::run::{Buffer, Dispatch, Run, Sizes};
use emlt::gpu::scene::SceneData;
use emlt::gpu::shader::Variant;
use emlt::scene::{Camera, Features, Image, Material, Scene};
use glam::{DVec3, Vec3};

/// Most entries of a call.
const ENTRIES: usize = 1 << 20;

/// Tags, as in shaders/bsdf/scatter.wesl.
pub const TAG_DIFFUSE: u32 = 0;
pub const TAG_REFLECT: u32 = 1;
pub const TAG_TRANSMIT: u32 = 2;
pub const TAG_NONE: u32 = 3;

pub struct Evaluated {
    pub value: [f64; 3],
    pub pdf_to_light: f64,
    pub pdf_to_camera: f64,
}

pub struct Device<'a> {
    run: Run<'a>,
    features: Features,
    /// How far the coat's normal leans towards x beyond the base's, where normals are mapped.
    pub lean: f32,
}

impl<'a> Device<'a> {
    /// A device with `materials` on a triangle each, lobes of alpha below `threshold` in classes of their own.
    pub fn new(context: &'a Context, materials: &[Material], threshold: f32) -> Self {
        let n = materials.len() as u32;
        let scene = Scene {
            name: "materials".into(),
            positions: (0..n).flat_map(|i| [Vec3::X, Vec3::Y, Vec3::ZERO].map(|p| p + i as f32 * Vec3::Z)).collect(),
            normals: vec![Vec3::Z; 3 * n as usize],
            tangents: vec![Vec3::X.extend(1.0); 3 * n as usize],
            triangles: (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            triangle_materials: (0..n).collect(),
            materials: materials.to_vec(),
            images: vec![Image { width: 1, height: 1, texels: vec![0xffff_8080] }],
            sky: Some(Vec3::ONE),
            ..Scene::default()
        };
        let world_from_camera = glam::Affine3A::IDENTITY;
        let name = "none".into();
        let camera =
            Camera { name, world_from_camera, vertical_fov: 1.0, orthographic_height: None, lens: None, aspect: None };
        let data = SceneData::with_threshold(&scene, &camera, 4, 4, threshold).unwrap();
        let sizes = Sizes { chains: 48 * ENTRIES as u64, lists: 16, output: 32 * ENTRIES as u64, counters: 256 };
        let features = Features::with_threshold(&scene, threshold);
        Self { run: Run::new(context, &data, sizes).unwrap(), features, lean: 0.0 }
    }

    fn call(&mut self, rows: [Vec<[f32; 4]>; 3], flags: &[&'static str], pass_index: u32) -> Vec<[f32; 4]> {
        let entries = rows[0].len();
        assert!(entries <= ENTRIES);
        for (i, row) in rows.iter().enumerate() {
            self.run.set_chains(16 * (i * ENTRIES) as u64, bytemuck::cast_slice(row));
        }
        let uniform =
            PassUniform { seed: 1, pass_index, entries: entries as u32, stride: ENTRIES as u32, ..Default::default() };
        let variant = Variant { pass: "bsdf_probe", features: self.features, max_edges: 4, flags: flags.to_vec() };
        self.run.submit(&[Dispatch { variant, uniform }]).unwrap();
        self.run.read(Buffer::Output, 0..32 * entries as u64).unwrap()
    }

    /// `count` directions sampled for `w_in`, with their tags.
    pub fn sample(&mut self, material: usize, ns: DVec3, w_in: DVec3, count: usize) -> Vec<(DVec3, u32)> {
        let rows = [vec![row(w_in, material as f32); count], vec![[0.0; 4]; count], vec![row(ns, self.lean); count]];
        let made = self.call(rows, &[], material as u32);
        made[..count].iter().map(|r| (direction(r), r[3] as u32)).collect()
    }

    /// Scattering from w_light to w_camera, each with a tag.
    pub fn evaluate(&mut self, material: usize, ns: DVec3, pairs: &[(DVec3, DVec3, u32)]) -> Vec<Evaluated> {
        let rows = [
            pairs.iter().map(|p| row(p.1, material as f32)).collect(),
            pairs.iter().map(|p| row(p.0, p.2 as f32)).collect(),
            vec![row(ns, self.lean); pairs.len()],
        ];
        self.call(rows, &["probe"], 0)
            .chunks_exact(2)
            .take(pairs.len())
            .map(|r| Evaluated {
                value: [0, 1, 2].map(|c| f64::from(r[0][c])),
                pdf_to_light: f64::from(r[0][3]),
                pdf_to_camera: f64::from(r[1][0]),
            })
            .collect()
    }
}

fn row(v: DVec3, w: f32) -> [f32; 4] {
    [v.x as f32, v.y as f32, v.z as f32, w]
}

fn direction(r: &[f32; 4]) -> DVec3 {
    DVec3::new(r[0].into(), r[1].into(), r[2].into())
}
