//! Triangles of a mesh primitive, in the mesh's own space.

use glam::DVec3;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, accessor};

use super::accessor::{Accessor, VECTOR_COMPONENTS};
use super::draco::Compressed;
use super::file::File;

const INDEX_COMPONENTS: [ComponentType; 3] = [ComponentType::U8, ComponentType::U16, ComponentType::U32];

/// The triangles of one primitive, counter-clockwise in mesh space, and the vertex data they index.
pub struct Triangles<'a> {
    pub corners: Vec<[u32; 3]>,
    pub positions: Attribute<'a>,
    pub normals: Option<Attribute<'a>>,
    /// By slot; None where the primitive lacks the set that the material asks for.
    pub coordinates: [Option<Accessor<'a>>; 2],
    pub tangents: Option<Accessor<'a>>,
    /// RGB or RGBA.
    pub colors: Option<(Accessor<'a>, Type)>,
}

/// What the material of a primitive needs to know of its vertices beyond their places and normals.
#[derive(Default)]
pub struct Wanted<'a> {
    /// Sets of texture coordinates, by slot.
    pub coordinates: &'a [u32],
    pub tangents: bool,
    pub colors: bool,
}

/// A vector per vertex, with the morph targets' default weights applied.
pub struct Attribute<'a> {
    base: Accessor<'a>,
    targets: Vec<(f64, Accessor<'a>)>,
}

impl<'a> Attribute<'a> {
    /// The attribute called `name`, from `compressed` where that has it.
    fn new(
        file: &'a File,
        compressed: Option<&Compressed<'a>>,
        name: &str,
        base: Index<accessor::Accessor>,
        targets: impl Iterator<Item = (f32, Option<Index<accessor::Accessor>>)>,
    ) -> Result<Self, String> {
        let accessor = |index: Index<_>| Accessor::new(file, index.value(), Type::Vec3, &VECTOR_COMPONENTS);
        let base = vertex_data(file, compressed, name, base, Type::Vec3)?;
        let targets = targets
            .filter(|(weight, _)| *weight != 0.0)
            .filter_map(|(weight, index)| Some((f64::from(weight), index?)))
            .map(|(weight, index)| {
                let target = accessor(index)?;
                same_count(&target, &base)?;
                Ok((weight, target))
            })
            .collect::<Result<_, String>>()?;
        Ok(Self { base, targets })
    }

    /// The vector of a vertex that some triangle names.
    pub fn at(&self, vertex: u32) -> DVec3 {
        let vertex = u64::from(vertex);
        let mut v = DVec3::from_array(self.base.vector(vertex));
        for (weight, target) in &self.targets {
            v += *weight * DVec3::from_array(target.vector(vertex));
        }
        v
    }
}

/// The vertex data called `name`, from `compressed` where that has it.
fn vertex_data<'a>(
    file: &'a File,
    compressed: Option<&Compressed<'a>>,
    name: &str,
    index: Index<accessor::Accessor>,
    kind: Type,
) -> Result<Accessor<'a>, String> {
    let data = compressed.map(|compressed| compressed.attribute(name)).transpose()?.flatten();
    match data {
        Some(data) => Accessor::of_draco(file, index.value(), kind, &VECTOR_COMPONENTS, data),
        None => Accessor::new(file, index.value(), kind, &VECTOR_COMPONENTS),
    }
}

/// Where the vertices of triangles are named.
enum Indices<'a> {
    Accessor(Accessor<'a>),
    Draco(Compressed<'a>),
    /// The vertices in turn, so many of them.
    All(u64),
}

impl Indices<'_> {
    fn count(&self) -> u64 {
        match self {
            Self::Accessor(accessor) => accessor.count,
            Self::Draco(compressed) => 3 * compressed.faces().len() as u64,
            Self::All(vertices) => *vertices,
        }
    }

    fn at(&self, i: u64) -> u64 {
        match self {
            Self::Accessor(accessor) => accessor.integer(i),
            Self::Draco(compressed) => u64::from(compressed.faces()[(i / 3) as usize][(i % 3) as usize].0),
            Self::All(_) => i,
        }
    }
}

/// Reads a primitive; None if it consists of points or lines. At most `room` triangles are taken.
/// `weights` are those of the morph targets, missing ones being zero.
pub fn triangles<'a>(
    file: &'a File,
    primitive: &'a Primitive,
    weights: &[f32],
    wanted: &Wanted,
    room: u64,
) -> Result<Option<Triangles<'a>>, String> {
    let Checked::Valid(mut mode) = primitive.mode else {
        return Err("its mode is unknown: export the file again".into());
    };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(None);
    }
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let Some(positions) = attribute(Semantic::Positions) else {
        return Err("it has no POSITION: export the file again".into());
    };
    let compressed = Compressed::of(file, primitive, room)?;
    let draco = compressed.as_ref();
    let targets = || (primitive.targets.iter().flatten()).zip(weights.iter().copied());
    let positions =
        Attribute::new(file, draco, "POSITION", positions, targets().map(|(target, w)| (w, target.positions)))?;
    let normals = match attribute(Semantic::Normals) {
        Some(normals) => {
            let normals =
                Attribute::new(file, draco, "NORMAL", normals, targets().map(|(target, w)| (w, target.normals)))?;
            same_count(&normals.base, &positions.base)?;
            Some(normals)
        }
        None => None,
    };
    let vertices = positions.base.count;
    let more = |semantic: Semantic, kind: Type| -> Result<Option<Accessor>, String> {
        let name = semantic.to_string();
        let Some(index) = attribute(semantic) else { return Ok(None) };
        let data = vertex_data(file, draco, &name, index, kind)?;
        same_count(&data, &positions.base)?;
        Ok(Some(data))
    };
    let mut coordinates = [None, None];
    for (slot, set) in coordinates.iter_mut().zip(wanted.coordinates) {
        *slot = more(Semantic::TexCoords(*set), Type::Vec2)?;
    }
    let tangents = if wanted.tangents { more(Semantic::Tangents, Type::Vec4)? } else { None };
    let colors = match attribute(Semantic::Colors(0)).filter(|_| wanted.colors) {
        Some(index) => {
            let kind = file.root.accessors.get(index.value()).map(|accessor| accessor.type_);
            let kind = if kind == Some(Checked::Valid(Type::Vec3)) { Type::Vec3 } else { Type::Vec4 };
            more(Semantic::Colors(0), kind)?.map(|colors| (colors, kind))
        }
        None => None,
    };
    let indices = match (compressed, primitive.indices) {
        (Some(compressed), _) => {
            // Draco holds triangles one by one, whatever the mode was before.
            mode = Mode::Triangles;
            Indices::Draco(compressed)
        }
        (None, Some(index)) => {
            let accessor = Accessor::new(file, index.value(), Type::Scalar, &INDEX_COMPONENTS)?;
            Indices::Accessor(accessor.backed()?)
        }
        (None, None) => Indices::All(positions.base.bound()?),
    };
    let length = indices.count();
    let count = match mode {
        Mode::Triangles => length / 3,
        _ => length.saturating_sub(2),
    };
    if count > room {
        let most = super::MAX_TRIANGLES;
        return Err(format!("the scene has more than the {most} triangles that can be rendered: simplify it"));
    }
    let vertex = |at: u64| -> Result<u32, String> {
        let index = indices.at(at);
        if index >= vertices {
            return Err(format!("it names vertex {index} of {vertices}: export the file again"));
        }
        u32::try_from(index).map_err(|_| format!("it has {vertices} vertices, more than can be rendered: simplify it"))
    };
    let mut corners = Vec::with_capacity(count as usize);
    for i in 0..count {
        // glTF 2.0, section 3.7.2.1: which vertices make triangle i.
        let [a, b, c] = match mode {
            Mode::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Mode::TriangleFan => [i + 1, i + 2, 0],
            _ => [3 * i, 3 * i + 1, 3 * i + 2],
        };
        corners.push([vertex(a)?, vertex(b)?, vertex(c)?]);
    }
    Ok(Some(Triangles { corners, positions, normals, coordinates, tangents, colors }))
}

/// All data of one primitive must cover the same vertices.
fn same_count(data: &Accessor, positions: &Accessor) -> Result<(), String> {
    if data.count == positions.count {
        return Ok(());
    }
    let (path, n, vertices) = (&data.path, data.count, positions.count);
    Err(format!("{path} has {n} elements for {vertices} vertices: export the file again"))
}
