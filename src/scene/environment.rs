//! Environment maps from files: Radiance (.hdr) and OpenEXR (.exr).

use std::fs;
use std::path::Path;

use super::light::Environment;
use crate::panics;
use crate::{Error, Result};

/// Most pixels that are kept: a larger map is halved until it fits.
const MAX_PIXELS: usize = 1 << 21;
/// Most pixels on a side that are read.
const MAX_SIDE: usize = 16384;

/// Reads an equirectangular map, by its first bytes as Radiance or OpenEXR. Negative and non-finite values become 0.
///
/// # Errors
/// [`Error::Input`] with one sentence: unreadable, damaged or black files, and those of no such format.
pub fn read(path: &Path) -> Result<Environment> {
    let of_file = |why: String| Error::input(format!("{}: {why}", path.display()));
    if !fs::metadata(path).map_err(|why| of_file(format!("it cannot be read ({why})")))?.is_file() {
        return Err(of_file("it is not a file: name an .hdr or .exr file".into()));
    }
    let bytes = fs::read(path).map_err(|why| of_file(format!("it cannot be read ({why})")))?;
    let read = if bytes.starts_with(b"#?") {
        radiance(&bytes)
    } else if bytes.starts_with(b"\x76\x2f\x31\x01") {
        panics::catch(|| open_exr(&bytes)).unwrap_or_else(|| Err("it makes no sense".into()))
    } else {
        return Err(of_file("it is neither Radiance (.hdr) nor OpenEXR (.exr): convert it".into()));
    };
    let mut map = read.map_err(|why| of_file(format!("it cannot be decoded ({why}): export it again")))?;
    for value in map.pixels.as_flattened_mut() {
        *value = if value.is_finite() { value.clamp(0.0, 1e9) } else { 0.0 };
    }
    if map.pixels.as_flattened().iter().all(|value| *value == 0.0) {
        return Err(of_file("it is black: choose a map that lights the scene".into()));
    }
    while map.pixels.len() > MAX_PIXELS {
        map = map.halved();
    }
    Ok(map)
}

fn open_exr(bytes: &[u8]) -> std::result::Result<Environment, String> {
    use exr::prelude::*;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| (size.width(), vec![[0f32; 3]; size.area().min(MAX_SIDE * MAX_SIDE)]),
            |(width, pixels), at, (r, g, b, _): (f32, f32, f32, f32)| {
                if let Some(pixel) = pixels.get_mut(at.y() * *width + at.x()) {
                    *pixel = [r, g, b];
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .map_err(|why| why.to_string())?;
    let size = image.layer_data.size;
    if size.width() > MAX_SIDE || size.height() > MAX_SIDE {
        return Err(format!("it has more than {MAX_SIDE} pixels on a side"));
    }
    let pixels = image.layer_data.channel_data.pixels.1;
    Ok(Environment { width: size.width() as u32, height: size.height() as u32, pixels })
}

/// Radiance's RGBE, flat or run-length coded (Ward 1991), top row first.
fn radiance(bytes: &[u8]) -> std::result::Result<Environment, String> {
    let cut = || "it is cut short".to_string();
    let mut rest = bytes;
    let mut line = || -> std::result::Result<String, String> {
        let end = rest.iter().position(|b| *b == b'\n').ok_or_else(cut)?;
        let text = String::from_utf8_lossy(&rest[..end]).trim().to_string();
        rest = &rest[end + 1..];
        Ok(text)
    };
    while !line()?.is_empty() {}
    let size = line()?;
    let words: Vec<&str> = size.split_whitespace().collect();
    let side = |word: &str| word.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n));
    let (height, width) = match words[..] {
        ["-Y", height, "+X", width] => side(height).zip(side(width)).ok_or("its size is wrong")?,
        _ => return Err(format!("its rows run as '{size:.40}', not as -Y .. +X ..")),
    };
    let mut pixels = Vec::with_capacity(width * height.min(64));
    let mut row = vec![[0u8; 4]; width];
    for _ in 0..height {
        if rest.len() >= 4 && rest[0] == 2 && rest[1] == 2 && rest[2] < 128 {
            if (usize::from(rest[2]) << 8 | usize::from(rest[3])) != width {
                return Err("a row is of another width".into());
            }
            rest = &rest[4..];
            for channel in 0..4 {
                let mut x = 0;
                while x < width {
                    let (&count, after) = rest.split_first().ok_or_else(cut)?;
                    let (run, n) = if count > 128 { (true, count as usize - 128) } else { (false, count as usize) };
                    let used = if run { 1 } else { n };
                    if n == 0 || x + n > width || after.len() < used {
                        return Err("a row's runs do not fit".into());
                    }
                    for (i, pixel) in row[x..x + n].iter_mut().enumerate() {
                        pixel[channel] = after[if run { 0 } else { i }];
                    }
                    rest = &after[used..];
                    x += n;
                }
            }
        } else {
            let flat = rest.get(..4 * width).ok_or_else(cut)?;
            for (pixel, bytes) in row.iter_mut().zip(flat.chunks_exact(4)) {
                pixel.copy_from_slice(bytes);
            }
            rest = &rest[4 * width..];
        }
        pixels.extend(row.iter().map(|[r, g, b, e]| {
            let scale = if *e == 0 { 0.0 } else { (f32::from(*e) - 136.0).exp2() };
            [r, g, b].map(|v| (f32::from(*v) + 0.5) * scale)
        }));
    }
    Ok(Environment { width: width as u32, height: height as u32, pixels })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_and_run_length_coded_rows() {
        let flat = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x40\x00\x81\x00\x00\x00\x00";
        let map = radiance(flat).unwrap();
        assert_eq!((map.width, map.height), (2, 1));
        assert!((map.pixels[0][0] - 128.5 / 128.0).abs() < 1e-6 && map.pixels[1] == [0.0; 3], "{:?}", map.pixels);
        let coded =
            b"#?RADIANCE\n\n-Y 1 +X 8\n\x02\x02\x00\x08\x88\x10\x88\x20\x08\x01\x02\x03\x04\x05\x06\x07\x08\x88\x80";
        let map = radiance(coded).unwrap();
        assert!((map.pixels[2][2] - 3.5 / 256.0).abs() < 1e-7, "{:?}", map.pixels);
        for wrong in
            [&flat[..flat.len() - 3], b"#?RADIANCE\n\n+Y 1 +X 2\n", b"#?x\n\n-Y 0 +X 2\n", b"#?x", b"#?\n\n-Y 9 +X"]
        {
            assert!(radiance(wrong).is_err());
        }
    }
}
