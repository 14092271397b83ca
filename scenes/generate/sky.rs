//! A sky to light scenes with by `--env`: a low sun on a clear evening, as a Radiance file.

use glam::Vec3;
use std::f32::consts::{PI, TAU};

const WIDTH: usize = 256;
const HEIGHT: usize = 128;
/// Degrees above the horizon, and from -z towards +x.
const SUN_ELEVATION: f32 = 20.0;
const SUN_AZIMUTH: f32 = -105.0;
/// The sun is wider than the true one, so that a map this small has a dozen pixels of it; its rim is soft.
const SUN_RADIUS: f32 = 3.4;
const SUN: Vec3 = Vec3::new(900.0, 680.0, 430.0);

/// An equirectangular map: top row first, -z in its middle, +x to the right of that.
pub struct Sky {
    pixels: Vec<Vec3>,
}

pub fn evening() -> Sky {
    let sun = direction(SUN_AZIMUTH.to_radians(), SUN_ELEVATION.to_radians());
    let mut pixels = Vec::with_capacity(WIDTH * HEIGHT);
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            // Sixteen points a pixel keep the sun's rim even.
            let mut sum = Vec3::ZERO;
            for i in 0..16 {
                let (u, v) = ((i % 4) as f32 * 0.25 + 0.125, (i / 4) as f32 * 0.25 + 0.125);
                let azimuth = TAU * ((x as f32 + u) / WIDTH as f32 - 0.5);
                let elevation = PI * (0.5 - (y as f32 + v) / HEIGHT as f32);
                sum += radiance(direction(azimuth, elevation), sun);
            }
            pixels.push(sum / 16.0);
        }
    }
    Sky { pixels }
}

fn direction(azimuth: f32, elevation: f32) -> Vec3 {
    let (sin, cos) = azimuth.sin_cos();
    Vec3::new(sin * elevation.cos(), elevation.sin(), -cos * elevation.cos())
}

fn radiance(d: Vec3, sun: Vec3) -> Vec3 {
    let off = d.dot(sun).clamp(-1.0, 1.0).acos().to_degrees();
    let zenith = Vec3::new(0.085, 0.17, 0.37);
    let horizon = Vec3::new(0.38, 0.41, 0.45);
    let ground = Vec3::new(0.10, 0.08, 0.06);
    let height = d.y.clamp(0.0, 1.0);
    let air = horizon.lerp(zenith, height.powf(0.45));
    // A wide warm glow about the sun, and a narrow one.
    let glow = Vec3::new(1.0, 0.72, 0.40) * (0.7 * (-off / 22.0).exp() + 4.0 * (-off / 4.0).exp());
    let above = smooth(-0.02, 0.02, d.y);
    let disc = 1.0 - smooth(0.85 * SUN_RADIUS, 1.15 * SUN_RADIUS, off);
    ground.lerp(air + glow, above) + SUN * disc
}

fn smooth(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

impl Sky {
    /// The file: a shared exponent per pixel (RGBE), rows coded by run lengths (Ward 1991).
    pub fn radiance(&self) -> Vec<u8> {
        let mut file = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {HEIGHT} +X {WIDTH}\n").into_bytes();
        for row in self.pixels.chunks(WIDTH) {
            let coded: Vec<[u8; 4]> = row.iter().map(|&pixel| rgbe(pixel)).collect();
            file.extend([2, 2, (WIDTH >> 8) as u8, (WIDTH & 255) as u8]);
            for channel in 0..4 {
                let bytes: Vec<u8> = coded.iter().map(|pixel| pixel[channel]).collect();
                runs(&bytes, &mut file);
            }
        }
        file
    }
}

fn rgbe(pixel: Vec3) -> [u8; 4] {
    let exponent = pixel.max_element().max(1e-9).log2().floor() as i32 + 1;
    let scale = 2f32.powi(8 - exponent);
    let [r, g, b] = (pixel * scale).to_array().map(|v| v.clamp(0.0, 255.0) as u8);
    [r, g, b, (exponent + 128) as u8]
}

/// Runs of at least four equal bytes as a count above 128 and the byte, all else as a count and the bytes.
fn runs(bytes: &[u8], file: &mut Vec<u8>) {
    let run = |at: usize| bytes[at..].iter().take(127).take_while(|&&b| b == bytes[at]).count();
    let mut at = 0;
    while at < bytes.len() {
        let length = run(at);
        if length >= 4 {
            file.extend([128 + length as u8, bytes[at]]);
            at += length;
            continue;
        }
        let start = at;
        while at < bytes.len() && at - start < 128 && run(at) < 4 {
            at += 1;
        }
        file.push((at - start) as u8);
        file.extend(&bytes[start..at]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_renderer_reads_the_sky_as_it_was_made() {
        let sky = evening();
        let path = std::env::temp_dir().join(format!("emlt-sky-{}.hdr", std::process::id()));
        std::fs::write(&path, sky.radiance()).unwrap();
        let read = emlt::scene::environment::read(&path);
        std::fs::remove_file(&path).unwrap();
        let read = read.unwrap();
        assert_eq!((read.width as usize, read.height as usize), (WIDTH, HEIGHT));
        for (made, got) in sky.pixels.iter().zip(&read.pixels) {
            let off = (*made - Vec3::from_array(*got)).abs().max_element();
            assert!(off <= made.max_element() / 128.0, "{made} was read as {got:?}");
        }
    }
}
