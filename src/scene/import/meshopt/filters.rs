//! What decoded vertex data goes through (appendix B of the extension), in place. Values that the specification leaves
//! open give some value or other; those that are not numbers become 0.

/// Signed components of an element: four of 8 bits, or four of 16 bits.
fn signed(stride: usize, element: &[u8]) -> [f32; 4] {
    std::array::from_fn(|i| match stride {
        4 => f32::from(element[i] as i8),
        _ => f32::from(i16::from_le_bytes([element[2 * i], element[2 * i + 1]])),
    })
}

/// Writes component `i`, rounded to the nearest integer.
fn write(stride: usize, element: &mut [u8], i: usize, value: f32) {
    let [low, high, ..] = (value.round() as i32).to_le_bytes();
    match stride {
        4 => element[i] = low,
        _ => element[2 * i..2 * i + 2].copy_from_slice(&[low, high]),
    }
}

/// Unit vectors from points of an octahedron, for elements of 4 or 8 bytes. The fourth component stays.
pub fn octahedral(stride: usize, bytes: &mut [u8]) {
    let scale = if stride == 4 { 127.0 } else { 32767.0 };
    for element in bytes.chunks_exact_mut(stride) {
        let [x, y, one, _] = signed(stride, element);
        let (x, y) = (x / one, y / one);
        let z = 1.0 - x.abs() - y.abs();
        let fold = z.min(0.0);
        let v = [x - fold.copysign(x), y - fold.copysign(y), z];
        let length = v.iter().map(|v| v * v).sum::<f32>().sqrt();
        (0..3).for_each(|i| write(stride, element, i, v[i] / length * scale));
    }
}

/// Unit quaternions from their three smaller components, for elements of 8 bytes.
pub fn quaternion(bytes: &mut [u8]) {
    for element in bytes.chunks_exact_mut(8) {
        let code = u16::from_le_bytes([element[6], element[7]]);
        let one = f32::from((code | 3) as i16);
        let [x, y, z, _] = signed(8, element).map(|v| v / one * std::f32::consts::FRAC_1_SQRT_2);
        let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
        let largest = usize::from(code & 3);
        for (i, v) in [w, x, y, z].into_iter().enumerate() {
            write(8, element, (largest + i) % 4, v * 32767.0);
        }
    }
}

/// 32-bit floating-point numbers from 24-bit mantissas and 8-bit exponents.
pub fn exponential(bytes: &mut [u8]) {
    for element in bytes.as_chunks_mut::<4>().0 {
        let v = i32::from_le_bytes(*element);
        let (exponent, mantissa) = (v >> 24, (v << 8) >> 8);
        *element = ((f64::from(mantissa) * 2f64.powi(exponent)) as f32).to_le_bytes();
    }
}

/// Red, green, blue and alpha from a luma, two chromas and alpha, for elements of 4 or 8 bytes.
pub fn color(stride: usize, bytes: &mut [u8]) {
    let full = if stride == 4 { 255 } else { 65535 };
    for element in bytes.chunks_exact_mut(stride) {
        let [luma, co, cg, alpha] = signed(stride, element).map(|v| v as i32);
        let (luma, alpha) = (luma & full, alpha & full);
        // The highest bit of alpha marks how many bits the components have.
        let most = ((1u64 << (32 - alpha.leading_zeros())) - 1) as i32;
        let alpha = alpha & (most >> 1);
        let alpha = (alpha << 1) | (alpha & 1);
        let values = [luma + co - cg, luma + cg, luma - co - cg, alpha];
        let scale = full as f32 / most as f32;
        values.iter().enumerate().for_each(|(i, v)| write(stride, element, i, *v as f32 * scale));
    }
}
