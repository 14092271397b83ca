//! Images of the file: PNG, JPEG and WebP, decoded when the first material needs them.

use std::io::Cursor;

use gltf::json::Value;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::file::File;
use crate::panics;
use crate::scene::texture::Image;

/// Most pixels on a side: what a texture row packs into 16 bits, with room.
const MAX_SIDE: u32 = 32768;

impl File {
    /// `images[index]`, decoded; None if it is in a format that is not read (KTX2, Basis).
    ///
    /// # Errors
    /// A sentence that begins with the image's path in the JSON: missing, damaged or too large.
    pub fn image(&self, index: usize) -> Result<Option<Image>, String> {
        let path = format!("images[{index}]");
        let Some(json) = self.raw("images").get(index) else {
            return Err(format!("{path} does not exist: export the file again"));
        };
        let name = json.get("uri").and_then(Value::as_str);
        let loaded;
        let bytes = match (name, json.get("bufferView").and_then(Value::as_u64)) {
            (Some(uri), _) => {
                loaded = self.load(uri, u64::MAX).map_err(|why| format!("{path}: {why}"))?;
                &loaded[..]
            }
            (None, Some(view)) => self.view(view as usize).map_err(|why| format!("{path}: {why}"))?,
            (None, None) => return Err(format!("{path} has neither a uri nor a bufferView: export the file again")),
        };
        let room = |width: usize, height: usize| {
            if width == 0 || height == 0 || width.max(height) > MAX_SIDE as usize {
                return Err(format!("it has {width} x {height} pixels, not 1 to {MAX_SIDE} on a side: resize it"));
            }
            self.take_room(&path, 8 * width as u64 * height as u64)
        };
        // The decoders check what they read, but they are large and not ours.
        let decoded = match kind(bytes) {
            Some(Kind::Png) => panics::catch(|| png(bytes, &room)),
            Some(Kind::Jpeg) => panics::catch(|| jpeg(bytes, &room)),
            Some(Kind::Webp) => panics::catch(|| webp(bytes, &room)),
            None if bytes.starts_with(b"\xabKTX") => return Ok(None),
            None => return Err(format!("{path} is no PNG, JPEG or WebP image: convert it")),
        };
        let decoded = decoded.unwrap_or_else(|| Err("it makes no sense".into()));
        decoded.map(Some).map_err(|why| format!("{path} cannot be decoded ({why}): export it again"))
    }
}

enum Kind {
    Png,
    Jpeg,
    Webp,
}

/// By its first bytes, whatever the file says of it.
fn kind(bytes: &[u8]) -> Option<Kind> {
    if bytes.starts_with(b"\x89PNG") {
        Some(Kind::Png)
    } else if bytes.starts_with(b"\xff\xd8\xff") {
        Some(Kind::Jpeg)
    } else if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        Some(Kind::Webp)
    } else {
        None
    }
}

type Room<'a> = &'a dyn Fn(usize, usize) -> Result<(), String>;

fn png(bytes: &[u8], room: Room) -> Result<Image, String> {
    let text = |why: png::DecodingError| why.to_string();
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: 1 << 30 });
    // Palettes and few bits to 8 bits, a transparent colour to alpha; 16 bits to 8.
    decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::STRIP_16);
    let mut reader = decoder.read_info().map_err(text)?;
    let (width, height) = reader.info().size();
    room(width as usize, height as usize)?;
    let mut pixels = vec![0; reader.output_buffer_size().ok_or("it is too large")?];
    let frame = reader.next_frame(&mut pixels).map_err(text)?;
    packed(width, height, frame.color_type.samples(), &pixels)
}

fn jpeg(bytes: &[u8], room: Room) -> Result<Image, String> {
    let side = MAX_SIDE as usize;
    let options = DecoderOptions::default().set_max_width(side).set_max_height(side);
    let options = options.jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|why| why.to_string())?;
    let info = decoder.info().ok_or("it has no header")?;
    let (width, height) = (info.width, info.height);
    room(width.into(), height.into())?;
    let pixels = decoder.decode().map_err(|why| why.to_string())?;
    let channels = decoder.output_colorspace().map_or(3, |space| space.num_components());
    packed(width.into(), height.into(), channels, &pixels)
}

fn webp(bytes: &[u8], room: Room) -> Result<Image, String> {
    let mut decoder = image_webp::WebPDecoder::new(Cursor::new(bytes)).map_err(|why| why.to_string())?;
    let (width, height) = decoder.dimensions();
    room(width as usize, height as usize)?;
    let mut pixels = vec![0; decoder.output_buffer_size().ok_or("it is too large")?];
    decoder.read_image(&mut pixels).map_err(|why| why.to_string())?;
    packed(width, height, if decoder.has_alpha() { 4 } else { 3 }, &pixels)
}

/// Grey, grey and alpha, RGB or RGBA of 8 bits a channel.
fn packed(width: u32, height: u32, channels: usize, bytes: &[u8]) -> Result<Image, String> {
    let texels: Vec<u32> = bytes
        .chunks_exact(channels.max(1))
        .map(|p| match *p {
            [l] => u32::from_le_bytes([l, l, l, 255]),
            [l, a] => u32::from_le_bytes([l, l, l, a]),
            [r, g, b] => u32::from_le_bytes([r, g, b, 255]),
            [r, g, b, a, ..] => u32::from_le_bytes([r, g, b, a]),
            [] => 0,
        })
        .take(width as usize * height as usize)
        .collect();
    if texels.len() != width as usize * height as usize {
        return Err("it is cut short".into());
    }
    Ok(Image { width, height, texels })
}
