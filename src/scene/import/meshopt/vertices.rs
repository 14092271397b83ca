//! Mode ATTRIBUTES (appendix A of the extension): blocks of elements, taken apart byte by byte and stored as deltas.

use super::{LEFT_OVER, SHORT};

/// Elements that share one bit width.
const GROUP: usize = 16;
/// Most elements in a block.
const BLOCK: usize = 256;

/// How one byte of all elements of a block is stored.
#[derive(Clone, Copy)]
enum Plane {
    /// By two bits per group that choose one of these widths in bits.
    Packed([usize; 4]),
    Zeros,
    Literal,
}

/// How four neighbouring bytes follow from those of the element before.
#[derive(Clone, Copy)]
enum Channel {
    Bytes,
    Words,
    /// Exclusive or, then turned by so many bits.
    Xor(u32),
}

/// Decodes `count` elements of `stride` bytes, which is a multiple of 4 up to 256.
pub fn decode(stride: usize, count: u64, data: &[u8]) -> Result<Vec<u8>, &'static str> {
    let (header, data) = data.split_first().ok_or(SHORT)?;
    let versioned = match header {
        0xa0 => false,
        0xa1 => true,
        _ => return Err("it is not vertex data of a version that can be read"),
    };
    // At the end: padding, the element that the first one is a delta of, and (version 1) the modes of its channels.
    let (used, least) = if versioned { (stride + stride / 4, 24) } else { (stride, 32) };
    let tail = data.len().checked_sub(used.max(least)).ok_or(SHORT)?;
    let (mut data, tail) = data.split_at(tail);
    let (first, modes) = tail[tail.len() - used..].split_at(stride);
    let channels =
        (0..stride / 4).map(|i| channel(modes.get(i).copied().unwrap_or(0))).collect::<Result<Vec<_>, _>>()?;

    let mut before = first.to_vec();
    let mut elements = Vec::new();
    let most = ((8192 / stride) & !(GROUP - 1)).min(BLOCK);
    let mut left = count;
    while left > 0 {
        let n = left.min(most as u64) as usize;
        decode_block(&mut data, versioned, &channels, n, &mut before, &mut elements)?;
        left -= n as u64;
    }
    if data.is_empty() { Ok(elements) } else { Err(LEFT_OVER) }
}

fn channel(mode: u8) -> Result<Channel, &'static str> {
    match (mode & 15, mode >> 4) {
        (0, 0) => Ok(Channel::Bytes),
        (1, 0) => Ok(Channel::Words),
        (2, turn) => Ok(Channel::Xor(u32::from(turn))),
        _ => Err("it has a channel of an unknown mode"),
    }
}

/// Appends `n` elements to `elements`; `before` is the last element of the block before, and of this one afterwards.
fn decode_block(
    data: &mut &[u8],
    versioned: bool,
    channels: &[Channel],
    n: usize,
    before: &mut [u8],
    elements: &mut Vec<u8>,
) -> Result<(), &'static str> {
    let stride = before.len();
    let controls = if versioned { data.split_off(..channels.len()).ok_or(SHORT)? } else { &[] };
    let start = elements.len();
    elements.resize(start + n * stride, 0);
    let block = &mut elements[start..];
    for (k, channel) in channels.iter().enumerate() {
        let mut planes = [[0; BLOCK]; 4];
        for (byte, plane) in planes.iter_mut().enumerate() {
            let stored = match controls.get(k).map(|control| control >> (2 * byte) & 3) {
                None => Plane::Packed([0, 2, 4, 8]),
                Some(0) => Plane::Packed([0, 1, 2, 4]),
                Some(1) => Plane::Packed([1, 2, 4, 8]),
                Some(2) => Plane::Zeros,
                Some(_) => Plane::Literal,
            };
            decode_plane(data, stored, n, plane)?;
        }
        let mut last = [0; 4];
        last.copy_from_slice(&before[4 * k..4 * k + 4]);
        for i in 0..n {
            last = next(*channel, last, std::array::from_fn(|byte| planes[byte][i]));
            block[i * stride + 4 * k..][..4].copy_from_slice(&last);
        }
        before[4 * k..4 * k + 4].copy_from_slice(&last);
    }
    Ok(())
}

/// Reads one byte of `n` elements' deltas.
fn decode_plane(data: &mut &[u8], stored: Plane, n: usize, plane: &mut [u8; BLOCK]) -> Result<(), &'static str> {
    match stored {
        Plane::Zeros => {}
        Plane::Literal => plane[..n].copy_from_slice(data.split_off(..n).ok_or(SHORT)?),
        Plane::Packed(widths) => {
            let groups = n.div_ceil(GROUP);
            let headers = data.split_off(..groups.div_ceil(4)).ok_or(SHORT)?;
            for (group, deltas) in plane.chunks_exact_mut(GROUP).take(groups).enumerate() {
                let width = widths[usize::from(headers[group / 4] >> (group % 4 * 2) & 3)];
                decode_group(data, width, deltas)?;
            }
        }
    }
    Ok(())
}

/// Reads 16 deltas of `width` bits; one with all bits set stands for a whole byte that follows them.
fn decode_group(data: &mut &[u8], width: usize, deltas: &mut [u8]) -> Result<(), &'static str> {
    let packed = data.split_off(..width * GROUP / 8).ok_or(SHORT)?;
    match width {
        0 => deltas.fill(0),
        8 => deltas.copy_from_slice(packed),
        _ => {
            let sentinel = (1u8 << width) - 1;
            for (i, delta) in deltas.iter_mut().enumerate() {
                let at = i * width % 8;
                // Single bits go from low to high, wider values from high to low.
                let shift = if width == 1 { at } else { 8 - width - at };
                *delta = packed[i * width / 8] >> shift & sentinel;
                if *delta == sentinel {
                    *delta = *data.split_off_first().ok_or(SHORT)?;
                }
            }
        }
    }
    Ok(())
}

/// Four bytes of an element, from those of the one before.
fn next(channel: Channel, last: [u8; 4], delta: [u8; 4]) -> [u8; 4] {
    match channel {
        Channel::Bytes => std::array::from_fn(|i| {
            let d = delta[i];
            last[i].wrapping_add((d >> 1) ^ (d & 1).wrapping_neg())
        }),
        Channel::Words => {
            let word = |i: usize| {
                let d = u16::from_le_bytes([delta[i], delta[i + 1]]);
                let last = u16::from_le_bytes([last[i], last[i + 1]]);
                last.wrapping_add((d >> 1) ^ (d & 1).wrapping_neg()).to_le_bytes()
            };
            let ([a, b], [c, d]) = (word(0), word(2));
            [a, b, c, d]
        }
        Channel::Xor(turn) => (u32::from_le_bytes(last) ^ u32::from_le_bytes(delta).rotate_right(turn)).to_le_bytes(),
    }
}
