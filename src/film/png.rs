//! 8-bit PNG files to look at: the preview of an image, and the picture of the mutation-direction maps.

use std::path::Path;

use super::Image;
use super::file::write_whole;
use crate::{Error, Result};

/// Exponent on the smaller share over the larger one in the direction picture: above 1 so that a moderate
/// preference (shares 0.4 and 0.6) already leaves yellow visibly.
const DIRECTION_CONTRAST: f32 = 2.0;

/// Writes `image` as sRGB: values clipped to [0, 1], no tone curve; a NaN is black.
pub fn write_preview(path: &Path, image: &Image) -> Result<()> {
    let bytes: Vec<u8> = image.pixels.iter().flat_map(|p| p.map(srgb_byte)).collect();
    write(path, image.width, image.height, &bytes)
}

/// Writes the mutation-direction picture of `horizontal` and `vertical` (one value per pixel, row 0 at the top).
///
/// Red: mutations move horizontally; green: vertically; yellow: both alike; black: nothing was accepted there.
pub fn write_directions(path: &Path, width: u32, height: u32, horizontal: &[f32], vertical: &[f32]) -> Result<()> {
    let bytes: Vec<u8> = horizontal.iter().zip(vertical).flat_map(|(h, v)| direction_color(*h, *v)).collect();
    write(path, width, height, &bytes)
}

/// Writes values from 0 (black) over red to 1 (pale yellow), one a pixel.
pub fn write_heat(path: &Path, width: u32, height: u32, values: &[f64]) -> Result<()> {
    let bytes: Vec<u8> = values.iter().flat_map(|v| heat(*v)).collect();
    write(path, width, height, &bytes)
}

/// Nine stops of the colour map `magma` (Smith and van der Walt 2015, CC0), evenly spaced.
const MAGMA: [[u8; 3]; 9] = [
    [0x00, 0x00, 0x04],
    [0x1d, 0x11, 0x47],
    [0x51, 0x12, 0x7c],
    [0x82, 0x26, 0x81],
    [0xb6, 0x36, 0x79],
    [0xe6, 0x51, 0x64],
    [0xfb, 0x88, 0x61],
    [0xfe, 0xc2, 0x87],
    [0xfc, 0xfd, 0xbf],
];

/// The colour of a value, linear between the stops; a NaN is the colour of 1.
pub fn heat(value: f64) -> [u8; 3] {
    let at = if value.is_nan() { 1.0 } else { value.clamp(0.0, 1.0) } * (MAGMA.len() - 1) as f64;
    let stop = (at as usize).min(MAGMA.len() - 2);
    let share = at - stop as f64;
    std::array::from_fn(|c| {
        let [low, high] = [MAGMA[stop][c], MAGMA[stop + 1][c]].map(f64::from);
        (low + share * (high - low) + 0.5) as u8
    })
}

/// A linear value as an sRGB byte (IEC 61966-2-1), rounded to nearest.
pub fn srgb_byte(linear: f32) -> u8 {
    let x = linear.clamp(0.0, 1.0);
    let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    // The cast turns NaN into 0.
    (255.0 * encoded + 0.5) as u8
}

/// The colour of a pixel in that picture.
pub fn direction_color(horizontal: f32, vertical: f32) -> [u8; 3] {
    let most = horizontal.max(vertical);
    if !(most > 0.0 && most.is_finite()) {
        return [0, 0, 0];
    }
    let byte = |share: f32| (255.0 * (share / most).max(0.0).powf(DIRECTION_CONTRAST) + 0.5) as u8;
    [byte(horizontal), byte(vertical), 0]
}

/// Writes 8-bit sRGB pixels, row 0 at the top.
pub fn write(path: &Path, width: u32, height: u32, rgb: &[u8]) -> Result<()> {
    let failed = |e| Error::runtime(format!("cannot write {}: {e}", path.display()));
    write_whole(path, &encode(width, height, rgb).map_err(failed)?)
}

fn encode(width: u32, height: u32, rgb: &[u8]) -> std::result::Result<Vec<u8>, ::png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(::png::ColorType::Rgb);
    encoder.set_depth(::png::BitDepth::Eight);
    encoder.set_source_srgb(::png::SrgbRenderingIntent::RelativeColorimetric);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(path: &Path) -> (u32, u32, Vec<u8>) {
        let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
        let mut reader = ::png::Decoder::new(file).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        (info.width, info.height, bytes)
    }

    #[test]
    fn srgb_bytes_follow_the_standard() {
        // 0.5 gives 0.73536 * 255 = 187.5, just above; 0.002 is on the linear part: 6.589.
        for (linear, byte) in [(0.0, 0), (1.0, 255), (0.5, 188), (0.216, 128), (0.002, 7), (0.18, 118)] {
            assert_eq!(srgb_byte(linear), byte, "{linear}");
        }
        for (linear, byte) in [(-1.0, 0), (7.0, 255), (f32::INFINITY, 255), (f32::NEG_INFINITY, 0), (f32::NAN, 0)] {
            assert_eq!(srgb_byte(linear), byte, "{linear}");
        }
    }

    #[test]
    fn every_byte_survives_decoding_and_encoding() {
        for byte in 0..=255u8 {
            let x = f32::from(byte) / 255.0;
            let linear = if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
            assert_eq!(srgb_byte(linear), byte);
        }
    }

    #[test]
    fn the_first_row_is_the_top_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let image = Image { width: 2, height: 1, pixels: vec![[1.0, 0.0, 0.5], [f32::NAN, 2.0, -1.0]] };
        write_preview(&path, &image).unwrap();
        assert_eq!(decode(&path), (2, 1, vec![255, 0, 188, 0, 255, 0]));
    }

    #[test]
    fn heat_goes_through_its_stops() {
        assert_eq!([0.0, 0.5, 1.0].map(heat), [MAGMA[0], MAGMA[4], MAGMA[8]]);
        assert_eq!(heat(0.0625), [15, 9, 38]);
        assert_eq!([heat(-3.0), heat(9.0), heat(f64::NAN)], [MAGMA[0], MAGMA[8], MAGMA[8]]);
    }

    #[test]
    fn directions_have_their_colors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let (h, v) = ([2.0, 0.0, 3.0, 0.0, 1.0, f32::NAN], [0.0, 5.0, 3.0, 0.0, 2.0, f32::NAN]);
        write_directions(&path, 3, 2, &h, &v).unwrap();
        let expected = vec![255, 0, 0, 0, 255, 0, 255, 255, 0, 0, 0, 0, 64, 255, 0, 0, 0, 0];
        assert_eq!(decode(&path), (3, 2, expected));
    }
}
