//! OpenEXR files: 32-bit floats, ZIP compressed, with named channels and metadata.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use ::exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
use ::exr::meta::attribute::{AttributeValue, LineOrder, Text};
use ::exr::meta::header::LayerAttributes;
use ::exr::prelude::{Compression, ReadChannels, ReadLayers, WritableImage};

use super::file::write_whole;
use super::{Channel, Image};
use crate::{Error, Result};

/// A header attribute's value.
#[derive(Debug, Clone, PartialEq)]
pub enum Attribute {
    /// EXR type `string`, in UTF-8.
    Text(String),
    /// EXR type `double`: holds a seed or a count of mutations exactly.
    Number(f64),
}

impl From<&str> for Attribute {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<f64> for Attribute {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

/// A file as read: every channel as 32-bit floats, whatever it was stored as.
#[derive(Debug, Clone, PartialEq)]
pub struct ExrFile {
    pub width: u32,
    pub height: u32,
    /// Named `LAYER.CHANNEL` where the file has named layers; sorted as in the file.
    pub channels: Vec<Channel>,
    /// Text and numbers among the header's attributes, those that EXR itself defines left out; sorted by name.
    pub attributes: Vec<(String, Attribute)>,
}

impl ExrFile {
    /// The channel called `name`.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|c| c.name == name).map(|c| c.values.as_slice())
    }

    /// The attribute called `name`.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, value)| value)
    }

    /// Channels R, G, B with `prefix` in front (as `Variance.`, or nothing); none where one is missing.
    pub fn image(&self, prefix: &str) -> Option<Image> {
        let [r, g, b] = ["R", "G", "B"].map(|c| self.channel(&format!("{prefix}{c}")));
        let pixels = r?.iter().zip(g?).zip(b?).map(|((r, g), b)| [*r, *g, *b]).collect();
        Some(Image { width: self.width, height: self.height, pixels })
    }
}

/// Writes `image` as R, G, B with further `channels` of the same size, and `attributes` in the header.
///
/// The same arguments give the same bytes. Names that EXR reserves, `version` among them, are an error. Panics where a channel's length is not the image's.
pub fn write(path: &Path, image: &Image, channels: &[Channel], attributes: &[(String, Attribute)]) -> Result<()> {
    let failed = |e| Error::runtime(format!("cannot write {}: {e}", path.display()));
    write_whole(path, &encode(image, channels, attributes).map_err(failed)?)
}

fn encode(
    image: &Image,
    channels: &[Channel],
    attributes: &[(String, Attribute)],
) -> std::result::Result<Vec<u8>, ::exr::error::Error> {
    let count = image.width as usize * image.height as usize;
    assert_eq!(image.pixels.len(), count, "pixels of the image");
    let mut list: Vec<AnyChannel<FlatSamples>> = ["R", "G", "B"]
        .iter()
        .enumerate()
        .map(|(c, name)| AnyChannel::new(*name, FlatSamples::F32(image.pixels.iter().map(|p| p[c]).collect())))
        .collect();
    for channel in channels {
        assert_eq!(channel.values.len(), count, "values of channel {}", channel.name);
        list.push(AnyChannel::new(text(&channel.name), FlatSamples::F32(channel.values.clone())));
    }
    let mut layer_attributes = LayerAttributes::default();
    for (name, value) in attributes {
        let value = match value {
            Attribute::Text(string) => AttributeValue::Text(text(string)),
            Attribute::Number(number) => AttributeValue::F64(*number),
        };
        layer_attributes.other.insert(text(name), value);
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: ::exr::image::Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (image.width as usize, image.height as usize);
    let layer = Layer::new(size, layer_attributes, encoding, AnyChannels::sort(list.into_iter().collect()));
    let mut bytes = Cursor::new(Vec::new());
    ::exr::image::Image::from_layer(layer).write().to_buffered(&mut bytes)?;
    let mut bytes = bytes.into_inner();
    sort_header(&mut bytes);
    Ok(bytes)
}

/// As UTF-8 bytes; the crate's own conversion panics beyond Latin-1.
fn text(string: &str) -> Text {
    Text::from_slice_unchecked(string.as_bytes())
}

/// Puts the header's attributes in order of name: the crate keeps them in a hash map, whose order differs from run to run.
///
/// The header of a single-part file is the attributes (name, 0, type, 0, size as i32, value), then 0, after 8 bytes of
/// magic number and version ("OpenEXR File Layout"). Its length stays, so the chunk offsets behind it stay right.
fn sort_header(bytes: &mut [u8]) {
    const START: usize = 8;
    let end_of_string = |at: usize| at + bytes[at..].iter().position(|b| *b == 0).unwrap_or(0) + 1;
    let mut entries = Vec::new();
    let mut at = START;
    while bytes[at] != 0 {
        let size_at = end_of_string(end_of_string(at));
        let size = i32::from_le_bytes([bytes[size_at], bytes[size_at + 1], bytes[size_at + 2], bytes[size_at + 3]]);
        let end = size_at + 4 + size as usize;
        entries.push(bytes[at..end].to_vec());
        at = end;
    }
    entries.sort();
    bytes[START..at].copy_from_slice(&entries.concat());
}

/// Reads the channels of any EXR file without deep data, all layers of the first one's size.
///
/// A file that is absent or not such an EXR is an [`Error::Input`].
pub fn read(path: &Path) -> Result<ExrFile> {
    let shown = path.display();
    let bytes = fs::read(path).map_err(|e| Error::input(format!("cannot read {shown}: {e}")))?;
    let image = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| Error::input(format!("{shown} cannot be read as an EXR image: {e}")))?;
    let size = image.layer_data.first().map(|l| l.size).unwrap_or_default();
    let mut file =
        ExrFile { width: size.width() as u32, height: size.height() as u32, channels: vec![], attributes: vec![] };
    let mut attributes: Vec<_> = image.attributes.other.iter().collect();
    for layer in image.layer_data.iter().filter(|l| l.size == size) {
        attributes.extend(&layer.attributes.other);
        let prefix = layer.attributes.layer_name.as_ref().map(|n| format!("{}.", string(n))).unwrap_or_default();
        for channel in &layer.channel_data.list {
            let name = format!("{prefix}{}", string(&channel.name));
            file.channels.push(Channel { name, values: channel.sample_data.values_as_f32().collect() });
        }
    }
    for (name, value) in attributes {
        let value = match value {
            AttributeValue::Text(t) => Attribute::Text(string(t)),
            AttributeValue::F64(v) => Attribute::Number(*v),
            AttributeValue::F32(v) => Attribute::Number(f64::from(*v)),
            AttributeValue::I32(v) => Attribute::Number(f64::from(*v)),
            _ => continue,
        };
        file.attributes.push((string(name), value));
    }
    file.attributes.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(file)
}

fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values that a careless path through half floats, text or arithmetic would change.
    fn example() -> (Image, Vec<Channel>, Vec<(String, Attribute)>) {
        let odd = [0.0, -0.0, 1e-45, f32::MIN_POSITIVE, 0.1, 65519.9, f32::MAX, -3.5, f32::INFINITY];
        let odd: Vec<f32> = odd.into_iter().chain([f32::NEG_INFINITY, f32::from_bits(0x7fc1_2345)]).collect();
        let (width, height) = (37, 19);
        let value = |i: usize| {
            if i.is_multiple_of(5) { odd[(i / 5) % odd.len()] } else { (i as f32).sin() }
        };
        let pixels = (0..width * height).map(|i| [value(3 * i), value(3 * i + 1), value(3 * i + 2)]).collect();
        let maps = Channel { name: "Maps.Horizontal".into(), values: (0..width * height).map(value).collect() };
        let attributes = vec![
            ("scene".into(), "Türme von 東京".into()),
            ("seed".into(), f64::from(u32::MAX).into()),
            ("b".into(), 0.1.into()),
            ("kernelMix".into(), "".into()),
        ];
        (Image { width: width as u32, height: height as u32, pixels }, vec![maps], attributes)
    }

    fn bits(image: &Image) -> Vec<[u32; 3]> {
        image.pixels.iter().map(|p| p.map(f32::to_bits)).collect()
    }

    #[test]
    fn every_bit_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let (image, channels, attributes) = example();
        write(&path, &image, &channels, &attributes).unwrap();
        let file = read(&path).unwrap();
        assert_eq!((file.width, file.height), (image.width, image.height));
        assert_eq!(bits(&file.image("").unwrap()), bits(&image));
        let maps: Vec<u32> = file.channel("Maps.Horizontal").unwrap().iter().map(|v| v.to_bits()).collect();
        assert_eq!(maps, channels[0].values.iter().map(|v| v.to_bits()).collect::<Vec<_>>());
        assert_eq!(file.channels.len(), 4);
        for (name, value) in &attributes {
            assert_eq!(file.attribute(name), Some(value), "{name}");
        }
        assert_eq!(file.image("Variance."), None);
    }

    #[test]
    fn the_same_image_gives_the_same_bytes() {
        let (image, channels, attributes) = example();
        let first = encode(&image, &channels, &attributes).unwrap();
        for _ in 0..20 {
            assert_eq!(encode(&image, &channels, &attributes).unwrap(), first);
        }
    }

    #[test]
    fn a_file_that_is_no_exr_is_bad_input() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        assert_eq!(read(&path).unwrap_err().exit_status(), 2);
        std::fs::write(&path, "not an image").unwrap();
        assert_eq!(read(&path).unwrap_err().exit_status(), 2);
        let (image, channels, attributes) = example();
        let whole = encode(&image, &channels, &attributes).unwrap();
        std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        assert_eq!(read(&path).unwrap_err().exit_status(), 2);
    }
}
