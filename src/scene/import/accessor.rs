//! Accessors read element by element straight from the buffers, so that no count in the file decides an allocation.

use std::collections::HashMap;

use draco_core::{AttributeValueIndex, DataType, PointAttribute};
use gltf::json;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;

use super::file::File;

/// Component types that vertex and instance data may have, KHR_mesh_quantization included.
pub const VECTOR_COMPONENTS: [ComponentType; 5] =
    [ComponentType::F32, ComponentType::I8, ComponentType::U8, ComponentType::I16, ComponentType::U16];

/// Most elements without data where nothing else bounds their number.
const MOST_ZEROS: u64 = 1 << 16;

/// A checked view of one accessor: every element below `count` can be read.
pub struct Accessor<'a> {
    /// Name of the accessor in messages: its path in the JSON.
    pub path: String,
    pub count: u64,
    component: ComponentType,
    normalized: bool,
    /// Without one, all elements are zero (glTF 2.0, section 3.6.2.3).
    base: Option<Strided<'a>>,
    /// Sparse values: bytes of single elements that replace the base's.
    replaced: HashMap<u64, &'a [u8]>,
}

/// Elements of `size` bytes, `stride` bytes apart.
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    /// Which element of the bytes each element is, where it is not the same one.
    rows: Option<&'a [AttributeValueIndex]>,
}

impl<'a> Strided<'a> {
    /// `count` elements of `size` bytes from `offset` in a buffer view, checked to lie inside it and its buffer.
    fn new(file: &'a File, view: usize, offset: u64, count: u64, size: usize) -> Result<Self, String> {
        let bytes = file.view(view)?;
        let stride = file.root.buffer_views[view].byte_stride.map_or(size, |stride| stride.0);
        let again = |why: String| format!("{why}: export the file again");
        if stride < size {
            let why = format!("bufferViews[{view}].byteStride {stride} is less than an element of {size} bytes");
            return Err(again(why));
        }
        let end = match count.checked_sub(1) {
            None => Some(0),
            Some(last) => {
                (stride as u64).checked_mul(last).and_then(|n| n.checked_add(offset)?.checked_add(size as u64))
            }
        };
        if end.is_none_or(|end| end > bytes.len() as u64) {
            let have = bytes.len();
            return Err(again(format!(
                "its {count} elements reach beyond bufferViews[{view}], which has {have} bytes"
            )));
        }
        // An empty accessor may start anywhere; nothing of it is read.
        let bytes = bytes.get(offset as usize..).unwrap_or(&[]);
        Ok(Self { bytes, stride, size, rows: None })
    }

    /// The values of `count` vertices in decoded Draco data, `size` bytes each, checked to be there.
    fn of_draco(attribute: &'a PointAttribute, count: usize, size: usize) -> Option<Self> {
        let bytes = attribute.buffer().data();
        let stride = usize::try_from(attribute.byte_stride()).ok().filter(|stride| *stride >= size && size > 0)?;
        let rows = attribute.explicit_mapping();
        // Rows that are whole; the last one may lack its padding.
        let whole = (bytes.len() + (stride - size)) / stride;
        let fits = match rows {
            None => count <= whole,
            Some(rows) => rows.len() >= count && rows.iter().take(count).all(|row| (row.0 as usize) < whole),
        };
        fits.then_some(Self { bytes, stride, size, rows })
    }

    fn element(&self, index: u64) -> &'a [u8] {
        let row = self.rows.map_or(index as usize, |rows| rows[index as usize].0 as usize);
        let start = row * self.stride;
        &self.bytes[start..start + self.size]
    }
}

impl<'a> Accessor<'a> {
    /// `accessors[index]`, which must be of type `kind` and one of `components`.
    pub fn new(file: &'a File, index: usize, kind: Type, components: &[ComponentType]) -> Result<Self, String> {
        let (json, component) = checked(file, index, kind, components)?;
        let path = path(index);
        let of_path = |why: String| format!("{path}: {why}");
        let size = kind.multiplicity() * component.size();
        let count = json.count.0;
        let base = match json.buffer_view {
            Some(view) => {
                let offset = json.byte_offset.map_or(0, |offset| offset.0);
                Some(Strided::new(file, view.value(), offset, count, size).map_err(of_path)?)
            }
            None => None,
        };
        let mut replaced = HashMap::new();
        if let Some(sparse) = &json.sparse {
            let Checked::Valid(index_component) = sparse.indices.component_type else {
                return Err(format!("{path}: its sparse.indices.componentType is unknown: export the file again"));
            };
            let indices_view = sparse.indices.buffer_view.value();
            let values_view = sparse.values.buffer_view.value();
            let (indices_offset, values_offset) = (sparse.indices.byte_offset.0, sparse.values.byte_offset.0);
            let index_size = index_component.0.size();
            let indices =
                Strided::new(file, indices_view, indices_offset, sparse.count.0, index_size).map_err(of_path)?;
            let values = Strided::new(file, values_view, values_offset, sparse.count.0, size).map_err(of_path)?;
            for i in 0..sparse.count.0 {
                let index = component_value(index_component.0, indices.element(i)) as u64;
                if index >= count {
                    let why = format!("its sparse index {index} is beyond its {count} elements");
                    return Err(format!("{path}: {why}: export the file again"));
                }
                replaced.insert(index, values.element(i));
            }
        }
        Ok(Self { count, component, normalized: json.normalized, base, replaced, path })
    }

    /// The same, for what decides how much is read: there, zeros that no data stands for may not be many.
    pub fn backed(self) -> Result<Self, String> {
        self.bound()?;
        Ok(self)
    }

    /// Its count, if that is no such one.
    pub fn bound(&self) -> Result<u64, String> {
        if self.base.is_none() && self.count > MOST_ZEROS {
            return Err(format!("{}: its {} elements have no data: export the file again", self.path, self.count));
        }
        Ok(self.count)
    }

    /// The same, but with its elements in decoded Draco data: `attribute`, which covers `count` vertices.
    pub fn of_draco(
        file: &'a File,
        index: usize,
        kind: Type,
        components: &[ComponentType],
        (attribute, count): (&'a PointAttribute, usize),
    ) -> Result<Self, String> {
        let (json, _) = checked(file, index, kind, components)?;
        let path = path(index);
        let again = |why: &str| format!("{path}: {why}: export the file again");
        // What the data is made of counts, not what the accessor says of it.
        let component = match attribute.data_type() {
            DataType::Int8 => ComponentType::I8,
            DataType::Uint8 => ComponentType::U8,
            DataType::Int16 => ComponentType::I16,
            DataType::Uint16 => ComponentType::U16,
            DataType::Uint32 => ComponentType::U32,
            DataType::Float32 => ComponentType::F32,
            _ => return Err(again("its Draco data is of a type that glTF does not have")),
        };
        if usize::from(attribute.num_components()) != kind.multiplicity() || !components.contains(&component) {
            return Err(again("its Draco data is of another type"));
        }
        if json.count.0 != count as u64 {
            let have = json.count.0;
            return Err(again(&format!("it has {have} elements, but its Draco data has {count}")));
        }
        let size = kind.multiplicity() * component.size();
        let base = Strided::of_draco(attribute, count, size);
        let base = Some(base.ok_or_else(|| again("its Draco data does not reach all vertices"))?);
        let (count, replaced) = (count as u64, HashMap::new());
        Ok(Self { count, component, normalized: json.normalized, base, replaced, path })
    }

    fn component(&self, index: u64, component: usize) -> f64 {
        let bytes = self.replaced.get(&index).copied().or_else(|| self.base.as_ref().map(|base| base.element(index)));
        bytes.map_or(0.0, |bytes| component_value(self.component, &bytes[component * self.component.size()..]))
    }

    /// Element `index` (below `count`) of a SCALAR accessor of unsigned integers.
    pub fn integer(&self, index: u64) -> u64 {
        self.component(index, 0) as u64
    }

    /// The first `N` components of element `index` (below `count`), normalised where the accessor says so.
    pub fn vector<const N: usize>(&self, index: u64) -> [f64; N] {
        std::array::from_fn(|i| {
            let value = self.component(index, i);
            // glTF 2.0, section 3.6.2.2: signed values map to [-1, 1] with two codes for -1.
            match self.component {
                ComponentType::I8 if self.normalized => (value / 127.0).max(-1.0),
                ComponentType::U8 if self.normalized => value / 255.0,
                ComponentType::I16 if self.normalized => (value / 32767.0).max(-1.0),
                ComponentType::U16 if self.normalized => value / 65535.0,
                _ => value,
            }
        })
    }
}

/// Name of an accessor in messages.
fn path(index: usize) -> String {
    format!("accessors[{index}]")
}

/// `accessors[index]` and its component type, if it is of type `kind` and one of `components`.
fn checked<'a>(
    file: &'a File,
    index: usize,
    kind: Type,
    components: &[ComponentType],
) -> Result<(&'a json::Accessor, ComponentType), String> {
    let again = |why: String| format!("{}: {why}: export the file again", path(index));
    let json = file.root.accessors.get(index).ok_or_else(|| again("it does not exist".into()))?;
    let Checked::Valid(component) = json.component_type else {
        return Err(again("its componentType is unknown".into()));
    };
    let component = component.0;
    if json.type_ != Checked::Valid(kind) || !components.contains(&component) {
        return Err(again(format!("its type or componentType ({component:?}) is not allowed for this use")));
    }
    Ok((json, component))
}

/// The little-endian number that `bytes` begin with; exact, since f64 holds every one of these types.
fn component_value(component: ComponentType, bytes: &[u8]) -> f64 {
    match component {
        ComponentType::I8 => f64::from(bytes[0] as i8),
        ComponentType::U8 => f64::from(bytes[0]),
        ComponentType::I16 => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
        ComponentType::U16 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        ComponentType::U32 => f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        ComponentType::F32 => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
    }
}
