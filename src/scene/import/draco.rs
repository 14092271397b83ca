//! Primitives compressed with KHR_draco_mesh_compression.

use draco_core::{DecodeLimits, DecoderBuffer, DracoError, ErrorKind, Mesh, MeshDecoder, PointAttribute, PointIndex};
use gltf::json::Value;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::file::File;
use crate::panics;

const NAME: &str = "KHR_draco_mesh_compression";
/// Most bytes per vertex, of all attributes together: every attribute that glTF 2.0 names, and as much again.
const MAX_VERTEX: u64 = 512;

/// The decoded geometry of one primitive.
pub struct Compressed<'a> {
    mesh: &'a Mesh,
    /// Which attribute of the data is which of the primitive.
    ids: Option<&'a Value>,
}

impl<'a> Compressed<'a> {
    /// The Draco data of a primitive of triangles, decoded; None if it has none. At most `room` triangles are taken.
    ///
    /// The accessors of the primitive bound what is decoded, since a few bytes can stand for any number of equal values.
    pub fn of(file: &'a File, primitive: &'a Primitive, room: u64) -> Result<Option<Self>, String> {
        let others = primitive.extensions.as_ref().map(|extensions| &extensions.others);
        let Some(json) = others.and_then(|others| others.get(NAME)) else {
            return Ok(None);
        };
        let again = |why: String| format!("its extensions.{NAME} {why}: export the file again");
        let view = json.get("bufferView").and_then(Value::as_u64);
        let Some(view) = view.and_then(|view| usize::try_from(view).ok()) else {
            return Err(again("names no bufferView".into()));
        };
        let count = |index: usize| file.root.accessors.get(index).map_or(0, |accessor| accessor.count.0);
        // A strip has as many indices as it likes: what Draco makes of it are single triangles.
        let indices = primitive.indices.filter(|_| primitive.mode == Checked::Valid(Mode::Triangles));
        let indices = indices.map(|indices| count(indices.value()));
        let faces = indices.map_or(room, |indices| room.min(indices / 3));
        let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
        let vertices = positions.map_or(0, |positions| count(positions.value()));
        let limits = DecodeLimits::default()
            .with_max_faces(faces)
            .with_max_points(vertices)
            .with_max_decoded_bytes(vertices.saturating_mul(MAX_VERTEX).min(file.room.get()));
        let mesh = file.draco(view, limits)?;
        let (have, want) = (mesh.num_faces() as u64, indices.map(|indices| indices / 3));
        if want.is_some_and(|want| want != have) || have > faces {
            let want = want.unwrap_or(faces);
            return Err(again(format!("has {have} triangles, but its accessors have {want}")));
        }
        Ok(Some(Self { mesh, ids: json.get("attributes") }))
    }

    /// The vertices of each triangle.
    pub fn faces(&self) -> &'a [[PointIndex; 3]] {
        self.mesh.faces()
    }

    /// The attribute called `name` and the number of vertices; None if it is not part of the Draco data.
    pub fn attribute(&self, name: &str) -> Result<Option<(&'a PointAttribute, usize)>, String> {
        let Some(id) = self.ids.and_then(|ids| ids.get(name)) else {
            return Ok(None);
        };
        // By the attribute's own number, not by its place.
        let number = id.as_u64().and_then(|id| u32::try_from(id).ok());
        let attribute = number.and_then(|id| self.mesh.attribute_by_unique_id(id));
        let attribute = attribute.ok_or_else(|| {
            format!("its extensions.{NAME}.attributes.{name} {id} is not in the data: export the file again")
        })?;
        Ok(Some((attribute, self.mesh.num_points())))
    }
}

impl File {
    /// The mesh in `bufferViews[view]`, decoded on first use.
    fn draco(&self, view: usize, limits: DecodeLimits) -> Result<&Mesh, String> {
        let data = self.view(view).map_err(|why| format!("its extensions.{NAME}: {why}"))?;
        let cell = &self.draco_meshes[view];
        if let Some(mesh) = cell.get() {
            return Ok(mesh);
        }
        // The decoder checks what it reads, but it is large and not ours.
        let decoded = panics::catch(|| {
            let mut mesh = Mesh::new();
            let mut buffer = DecoderBuffer::new(data).with_limits(limits);
            MeshDecoder::new().decode(&mut buffer, &mut mesh).map(|()| mesh)
        });
        let mesh = decoded.unwrap_or_else(|| Err(DracoError::general("it makes no sense"))).map_err(|why| {
            let why = match why.kind() {
                ErrorKind::LimitExceeded => "it has more data than the accessors say",
                _ => why.message(),
            };
            format!("its extensions.{NAME} cannot be decoded from bufferViews[{view}] ({why}): export the file again")
        })?;
        let attributes = (0..mesh.num_attributes()).filter_map(|i| mesh.try_attribute(i).ok());
        let size = attributes.map(|a| a.buffer().data().len() + 4 * a.explicit_mapping().map_or(0, <[_]>::len));
        let size = size.sum::<usize>() + size_of_val(mesh.faces());
        self.take_room(&format!("bufferViews[{view}]"), size as u64)?;
        Ok(cell.get_or_init(|| mesh))
    }
}
