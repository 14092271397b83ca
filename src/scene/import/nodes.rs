//! The node hierarchy of the scene that the file shows first.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use gltf::json::Value;
use gltf::json::accessor::Type;
use gltf::json::scene::Node;

use super::accessor::{Accessor, VECTOR_COMPONENTS};
use super::file::File;

/// A node of the scene with its place in the world.
pub struct Placed {
    /// Index into the file's nodes.
    pub index: usize,
    pub world_from_node: DAffine3,
}

/// All nodes of the default scene, or else of the first one, or else (no scenes) all nodes, parents before children.
pub fn placed(file: &File) -> Result<Vec<Placed>, String> {
    let nodes = &file.root.nodes;
    let mut reached = vec![false; nodes.len()];
    let mut placed = Vec::new();
    // A stack instead of recursion, so that no depth of nesting overflows anything; reversed to keep the file's order.
    let mut waiting: Vec<(usize, DAffine3)> =
        roots(file)?.into_iter().rev().map(|index| (index, DAffine3::IDENTITY)).collect();
    while let Some((index, world_from_parent)) = waiting.pop() {
        let path = format!("nodes[{index}]");
        let node = nodes.get(index).ok_or_else(|| format!("{path} does not exist: export the file again"))?;
        if std::mem::replace(&mut reached[index], true) {
            return Err(format!("{path} is reached twice (a cycle, or two parents): export the file again"));
        }
        let parent_from_node = local(node).map_err(|why| format!("{path}{why}: export the file again"))?;
        let world_from_node = world_from_parent * parent_from_node;
        if !world_from_node.is_finite() {
            return Err(format!("{path} has a transform that is not finite: export the file again"));
        }
        placed.push(Placed { index, world_from_node });
        let children = node.children.iter().flatten().rev();
        waiting.extend(children.map(|child| (child.value(), world_from_node)));
    }
    Ok(placed)
}

/// Root nodes of the scene to show.
fn roots(file: &File) -> Result<Vec<usize>, String> {
    let root = &file.root;
    let scene = match root.scene {
        Some(index) => {
            let index = index.value();
            let scene = root.scenes.get(index);
            Some(scene.ok_or_else(|| format!("scene {index} does not exist: export the file again"))?)
        }
        None => root.scenes.first(),
    };
    if let Some(scene) = scene {
        return Ok(scene.nodes.iter().map(|node| node.value()).collect());
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if let Some(is_child) = is_child.get_mut(child.value()) {
            *is_child = true;
        }
    }
    Ok((0..root.nodes.len()).filter(|&index| !is_child[index]).collect())
}

/// A node's own transform, from its matrix or its translation, rotation and scale.
fn local(node: &Node) -> Result<DAffine3, &'static str> {
    if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        return Ok(DAffine3 { matrix3: DMat3::from_mat4(matrix), translation: matrix.w_axis.truncate() });
    }
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let scale = node.scale.map_or(DVec3::ONE, vector);
    let translation = node.translation.map_or(DVec3::ZERO, vector);
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q.0.map(f64::from)));
    if rotation.length_squared() <= 0.0 {
        return Err(".rotation is zero");
    }
    Ok(DAffine3::from_scale_rotation_translation(scale, rotation.normalize(), translation))
}

/// Copies of a node's mesh (EXT_mesh_gpu_instancing); one in place without that extension.
pub struct Instances<'a> {
    pub count: u64,
    translations: Option<Accessor<'a>>,
    rotations: Option<Accessor<'a>>,
    scales: Option<Accessor<'a>>,
}

impl<'a> Instances<'a> {
    /// The instances of `nodes[index]`, which exists.
    pub fn new(file: &'a File, index: usize) -> Result<Self, String> {
        let extensions = file.root.nodes[index].extensions.as_ref();
        let instancing = extensions.and_then(|e| e.others.get("EXT_mesh_gpu_instancing"));
        let attributes = instancing.and_then(|instancing| instancing.get("attributes"));
        let attribute = |name: &str, kind| {
            let accessor = attributes.and_then(|a| a.get(name)).and_then(Value::as_u64);
            let accessor = accessor.map(|a| Accessor::new(file, a as usize, kind, &VECTOR_COMPONENTS)?.backed());
            accessor.transpose()
        };
        let translations = attribute("TRANSLATION", Type::Vec3)?;
        let rotations = attribute("ROTATION", Type::Vec4)?;
        let scales = attribute("SCALE", Type::Vec3)?;
        let counts = [&translations, &rotations, &scales].map(|a| a.as_ref().map(|a| a.count));
        let count = counts.into_iter().flatten().next().unwrap_or(1);
        if counts.into_iter().flatten().any(|other| other != count) {
            return Err(format!("nodes[{index}] has instance attributes of different lengths: export the file again"));
        }
        if count > super::MAX_TRIANGLES {
            return Err(format!("nodes[{index}] has {count} instances, more than can be rendered: simplify it"));
        }
        Ok(Self { count, translations, rotations, scales })
    }

    /// Where instance `i` (below `count`) lies in its node.
    pub fn at(&self, i: u64) -> DAffine3 {
        let vector = |a: &Option<Accessor>, otherwise| a.as_ref().map_or(otherwise, |a| DVec3::from_array(a.vector(i)));
        let rotation = self.rotations.as_ref().map_or(DQuat::IDENTITY, |a| DQuat::from_array(a.vector(i)));
        // A zero quaternion has no direction to restore; the instance stays unturned.
        let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
        let (scale, translation) = (vector(&self.scales, DVec3::ONE), vector(&self.translations, DVec3::ZERO));
        DAffine3::from_scale_rotation_translation(scale, rotation, translation)
    }
}
