//! Indexed triangle meshes with a normal per vertex; counter-clockwise triangles seen from outside.

use glam::{Affine3A, Quat, Vec3};
use std::collections::BTreeMap;

#[derive(Debug, Clone, Default)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    pub fn vertex(&mut self, position: Vec3, normal: Vec3) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.positions.len() as u32 - 1
    }

    /// Adds a flat convex polygon, corners counter-clockwise, with vertices of its own.
    pub fn polygon(&mut self, corners: &[Vec3]) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let first = self.positions.len() as u32;
        for &corner in corners {
            self.vertex(corner, normal);
        }
        for i in 2..corners.len() as u32 {
            self.triangles.push([first, first + i - 1, first + i]);
        }
    }

    pub fn append(&mut self, other: &Mesh) {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.normals.extend(&other.normals);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| first + i)));
    }

    /// The union of parts that share one material; opaque parts may overlap.
    pub fn joined(parts: &[Mesh]) -> Mesh {
        let mut all = Mesh::default();
        for part in parts {
            all.append(part);
        }
        all
    }

    /// Inside out: for rooms seen from inside and for cavities in glass.
    pub fn flipped(mut self) -> Mesh {
        for normal in &mut self.normals {
            *normal = -*normal;
        }
        for t in &mut self.triangles {
            t.swap(1, 2);
        }
        self
    }

    /// Facets: every triangle gets vertices of its own with its geometric normal.
    pub fn faceted(&self) -> Mesh {
        let mut flat = Mesh::default();
        for t in &self.triangles {
            flat.polygon(&t.map(|i| self.positions[i as usize]));
        }
        flat
    }

    /// Moved by a rotation and a translation (so that normals stay normals).
    pub fn moved(mut self, rotation: Quat, translation: Vec3) -> Mesh {
        let rigid = Affine3A::from_rotation_translation(rotation, translation);
        for p in &mut self.positions {
            *p = rigid.transform_point3(*p);
        }
        for n in &mut self.normals {
            *n = rigid.transform_vector3(*n).normalize();
        }
        self
    }

    pub fn at(self, x: f32, y: f32, z: f32) -> Mesh {
        self.moved(Quat::IDENTITY, Vec3::new(x, y, z))
    }

    /// Turned about +y by `degrees`.
    pub fn turned(self, degrees: f32) -> Mesh {
        self.moved(Quat::from_rotation_y(degrees.to_radians()), Vec3::ZERO)
    }

    pub fn scaled(mut self, factor: f32) -> Mesh {
        for p in &mut self.positions {
            *p *= factor;
        }
        self
    }

    pub fn area(&self) -> f32 {
        let corner = |i: u32| self.positions[i as usize];
        let twice = |t: &[u32; 3]| (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0])).length() as f64;
        (0.5 * self.triangles.iter().map(twice).sum::<f64>()) as f32
    }

    /// The mesh itself, once checked: every edge is shared by exactly two triangles that run along it in
    /// opposite ways, and the normals are on the triangles' front side. Glass that leaks would be a wrong scene.
    pub fn closed(self) -> Mesh {
        // By position, because flat faces have vertices of their own.
        let key = |i: u32| self.positions[i as usize].to_array().map(|x| (x + 0.0).to_bits());
        let mut balance: BTreeMap<[[u32; 3]; 2], (i32, u32)> = BTreeMap::new();
        for t in &self.triangles {
            for e in 0..3 {
                let (a, b) = (key(t[e]), key(t[(e + 1) % 3]));
                let entry = balance.entry([a.min(b), a.max(b)]).or_default();
                entry.0 += if a < b { 1 } else { -1 };
                entry.1 += 1;
            }
        }
        if let Some((edge, count)) = balance.iter().find(|&(_, &count)| count != (0, 2)) {
            let [a, b] = edge.map(|p| p.map(f32::from_bits));
            panic!("edge {a:?} to {b:?} has {count:?}");
        }
        for t in &self.triangles {
            let [a, b, c] = t.map(|i| self.positions[i as usize]);
            let sum: Vec3 = t.iter().map(|&i| self.normals[i as usize]).sum();
            assert!((b - a).cross(c - a).dot(sum) > 0.0, "a normal points to the wrong side at {a}");
        }
        self
    }
}
