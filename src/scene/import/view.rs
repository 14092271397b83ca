//! Buffer views: ranges of buffers, taken as they are or decompressed when first asked for.

use gltf::json::Value;

use super::file::File;
use super::meshopt::{Filter, Layout, Mode};

/// Extensions of a buffer view that say how it is compressed. They differ in what their decoder allows, not in form.
const COMPRESSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

impl File {
    /// The bytes of `bufferViews[index]`, decompressed where it is compressed. Nothing of the buffer that a compressed
    /// view stands in for is read, since it may be without data.
    pub fn view(&self, index: usize) -> Result<&[u8], String> {
        let Some(view) = self.root.buffer_views.get(index) else {
            return Err(format!("bufferViews[{index}] does not exist: export the file again"));
        };
        let path = format!("bufferViews[{index}]");
        let (offset, length) = (view.byte_offset.map_or(0, |offset| offset.0), view.byte_length.0);
        let others = view.extensions.as_ref().map(|extensions| &extensions.others);
        let compression = COMPRESSIONS.iter().find_map(|name| Some((name, others?.get(*name)?)));
        let Some((name, json)) = compression else {
            return self.range(&path, view.buffer.value(), offset, length);
        };
        let cell = &self.unpacked[index];
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        let bytes = self.unpack(&format!("{path}.extensions.{name}"), json, length)?;
        Ok(cell.get_or_init(|| bytes))
    }

    /// `length` bytes from `offset` in `buffers[buffer]`; `path` is what says so.
    fn range(&self, path: &str, buffer: usize, offset: u64, length: u64) -> Result<&[u8], String> {
        let bytes = self.buffer(buffer).map_err(|why| format!("{path}: {why}"))?;
        let end = offset.checked_add(length);
        let range = end.and_then(|end| bytes.get(usize::try_from(offset).ok()?..usize::try_from(end).ok()?));
        range.ok_or_else(|| {
            format!("{path} reaches beyond buffers[{buffer}], which has {} bytes: export the file again", bytes.len())
        })
    }

    /// Decodes the data that a view's extension (at `path` in the JSON) names; the view has room for `length` bytes.
    fn unpack(&self, path: &str, json: &Value, length: u64) -> Result<Vec<u8>, String> {
        let again = |why: &str| format!("{path}{why}: export the file again");
        let number = |key: &str| {
            let number = json.get(key).and_then(Value::as_u64);
            number.ok_or_else(|| again(&format!(".{key} is not a whole number")))
        };
        let offset = if json.get("byteOffset").is_some() { number("byteOffset")? } else { 0 };
        let buffer = usize::try_from(number("buffer")?).unwrap_or(usize::MAX);
        let data = self.range(path, buffer, offset, number("byteLength")?)?;
        let layout = Layout {
            mode: match json.get("mode").and_then(Value::as_str) {
                Some("ATTRIBUTES") => Mode::Attributes,
                Some("TRIANGLES") => Mode::Triangles,
                Some("INDICES") => Mode::Indices,
                _ => return Err(again(".mode is unknown")),
            },
            filter: match json.get("filter").map(Value::as_str) {
                None | Some(Some("NONE")) => Filter::None,
                Some(Some("OCTAHEDRAL")) => Filter::Octahedral,
                Some(Some("QUATERNION")) => Filter::Quaternion,
                Some(Some("EXPONENTIAL")) => Filter::Exponential,
                Some(Some("COLOR")) => Filter::Color,
                _ => return Err(again(".filter is unknown")),
            },
            stride: number("byteStride")?,
            count: number("count")?,
        };
        let undecodable = |why: &str| again(&format!(" cannot be decoded ({why})"));
        layout.check().map_err(undecodable)?;
        let size = layout.count.checked_mul(layout.stride).filter(|size| *size <= length);
        let Some(size) = size else {
            return Err(again(&format!(" has more elements than its buffer view's {length} bytes can hold")));
        };
        self.take_room(path, size)?;
        layout.decode(data).map_err(undecodable)
    }

    /// Notes that what lies at `path` takes `size` bytes when it is decompressed.
    pub fn take_room(&self, path: &str, size: u64) -> Result<(), String> {
        let room = self.room.get().checked_sub(size);
        self.room.set(room.ok_or_else(|| format!("{path} has more data than can be rendered: simplify the scene"))?);
        Ok(())
    }
}
