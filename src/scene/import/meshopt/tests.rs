//! Streams that another encoder (meshoptimizer's) made of data that is made here again.

use super::*;

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap()).collect()
}

fn decode(mode: Mode, filter: Filter, stride: u64, count: u64, data: &[u8]) -> Result<Vec<u8>, &'static str> {
    let layout = Layout { mode, filter, stride, count };
    layout.check()?;
    layout.decode(data)
}

const VERSION_0: &str = "a02a066666666666666666666666666666666666666600000000001f0002060a0e12161a1e22262a2e32363a3e4246\
    4a4e52565a5e62666a6e72767affff00007e82868a8e92969a14800200808080000000002f0080804040404020202020202020201010101010\
    101010101010101010101008888888880000000001080000081f004a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a\
    4affff00004a4a4a4a4a4a4a4a0015266666666666666666660000000000000000000000000000000000000000000000000000000000803f00\
    0000ff";
/// With channels of all three modes and planes of all four.
const VERSION_1: &str = "a1b9689b2a0666666666666666666666666666666666666666000000000002060a0e12161a1e22262a2e32363a3e42\
    464a4e52565a5e62666a6e72767a7e82868a8e92969a0104001f1a0ff8f8f4c4f4c4f210f018381c7c62e262f262e262f11e3edddd00000307\
    030f004a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a152666666666666666666600000000\
    00000000000000000000000000803f000000ff016200";
const TRIANGLES: &str = "e1fe1e100e100e100e100efe1e190e180e170e160eff1e160e160e160e160eff1e160e160e160e160eff1e160e160e\
    160e160efffe0f0c9f025f090c5f090c5f090cff4500004fc801007687566778a9866589689801690000";
const SEQUENCE: &str = "d10004141218021204141218021204141218021204141218021204141218020e0414121802120414121802120414121\
    8021204141218021204141218020e04141218021204141218021204141218021204141218021204141218020e0414121802120414121802120\
    4141218021204141218021204141218020e04141218021204141218021204141218021204141218021204141218020101011d7188020000000\
    0";

/// 40 elements of two 16-bit numbers, a float and four bytes.
fn elements() -> Vec<u8> {
    let element = |i: u16| {
        let [a, b] = (3 * i).to_le_bytes();
        let [c, d] = (i * i).to_le_bytes();
        let [e, f, g, h] = (f32::from(i) * 0.5 + 1.0).to_le_bytes();
        [a, b, c, d, e, f, g, h, (37 * i) as u8, 0, (i & 1) as u8, 255]
    };
    (0..40).flat_map(element).collect()
}

/// The triangles of a grid of 5 by 5 cells, and two more.
fn triangles() -> Vec<u16> {
    let corner = |y: u16, x: u16| 6 * y + x;
    let cells = (0..5).flat_map(|y| (0..5).map(move |x| corner(y, x)));
    cells.flat_map(|a| [a, a + 1, a + 6, a + 1, a + 7, a + 6]).chain([0, 0, 0, 7, 35, 100]).collect()
}

/// Mode, bytes and number of elements, the stream, and what it decodes to.
type Stream = (Mode, u64, u64, Vec<u8>, Vec<u8>);

fn all() -> [Stream; 4] {
    let indices: Vec<u8> = triangles().iter().flat_map(|i| i.to_le_bytes()).collect();
    [
        (Mode::Attributes, 12, 40, bytes(VERSION_0), elements()),
        (Mode::Attributes, 12, 40, bytes(VERSION_1), elements()),
        (Mode::Triangles, 2, 156, bytes(TRIANGLES), indices.clone()),
        (Mode::Indices, 2, 156, bytes(SEQUENCE), indices),
    ]
}

/// Indices of `width` bytes, triangle by triangle with the smallest first: the encoder may turn them around.
fn turned(width: usize, indices: &[u8]) -> Vec<[u32; 3]> {
    let index = |bytes: &[u8]| bytes.iter().rev().fold(0, |index, byte| index << 8 | u32::from(*byte));
    let indices: Vec<u32> = indices.chunks(width).map(index).collect();
    let turn = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap();
    indices.as_chunks::<3>().0.iter().map(|triangle| turn(*triangle)).collect()
}

#[test]
fn vertices_and_indices_come_back() {
    for (mode, stride, count, data, want) in all() {
        let have = decode(mode, Filter::None, stride, count, &data).unwrap();
        if mode != Mode::Triangles {
            assert_eq!(have, want, "{mode:?}");
        }
        if mode != Mode::Attributes {
            let wide = decode(mode, Filter::None, 4, count, &data).unwrap();
            assert_eq!((turned(2, &have), turned(4, &wide)), (turned(2, &want), turned(2, &want)));
        }
    }
}

#[test]
fn streams_of_another_length_or_version_are_refused() {
    for (mode, stride, count, data, _) in all() {
        let decode = |count, data: &[u8]| decode(mode, Filter::None, stride, count, data);
        for length in 0..data.len() {
            assert!(decode(count, &data[..length]).is_err(), "{mode:?} {length}");
        }
        for other in [0, count - 3, count + 3, 1 << 40, u64::MAX / 3 * 3] {
            // The last group of elements is filled up to 16, so that nobody can tell where it ends.
            if mode == Mode::Attributes && other.div_ceil(16) == count.div_ceil(16) {
                continue;
            }
            assert!(decode(other, &data).is_err(), "{mode:?} {other}");
        }
        let mut newer = data.clone();
        newer[0] += 2;
        assert!(decode(count, &newer).unwrap_err().contains("version"));
        let mut longer = data.clone();
        longer.insert(data.len() - if mode == Mode::Attributes { 32 } else { 16 }, 0);
        assert!(decode(count, &longer).is_err(), "{mode:?}");
    }
}

#[test]
fn filters_give_what_the_specification_says() {
    let mut normals = bytes("00007f7f49817f817f007f00");
    filters::octahedral(4, &mut normals);
    assert_eq!(normals, [0, 0, 127, 127, 0, -76, -102, -127, 127, 0, 0, 0].map(|v: i8| v as u8));
    let words =
        |bytes: &[u8]| -> Vec<i16> { bytes.as_chunks::<2>().0.iter().map(|b| i16::from_le_bytes(*b)).collect() };
    let mut normals = bytes("000000007f00ff7f490081ff7f0001807f0000007f000000");
    filters::octahedral(8, &mut normals);
    assert_eq!(words(&normals), [0, 0, 32767, 32767, 0, -19487, -26343, -32767, 32767, 0, 0, 0]);
    let mut quaternions = bytes("000000000000ff0759faa70559fafc070000c9060000fc07");
    filters::quaternion(&mut quaternions);
    assert_eq!(words(&quaternions), [0, 0, 0, 32767, 16399, -16378, 16378, -16378, 26213, 0, 19661, 0]);
    let mut floats = bytes("000600f600fcfff4a107000900000091");
    filters::exponential(&mut floats);
    let floats: Vec<f32> = floats.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    assert_eq!(floats, [1.5, -0.25, 999_936.0, 0.0]);
    let mut colors = bytes("905ff1ff4081c0c0");
    filters::color(4, &mut colors);
    assert_eq!(colors, [254, 129, 64, 255, 1, 0, 255, 128]);
}

#[test]
fn filters_survive_any_bytes() {
    let mut state = 1u32;
    let mut any = || -> Vec<u8> {
        let next = |state: &mut u32| {
            *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (*state >> 24) as u8
        };
        (0..4096).map(|_| next(&mut state)).chain([0; 16]).chain([128; 16]).chain([255; 16]).collect()
    };
    for stride in [4, 8] {
        filters::octahedral(stride, &mut any());
        filters::color(stride, &mut any());
    }
    filters::quaternion(&mut any());
    filters::exponential(&mut any());
}

#[test]
fn layouts_that_the_extension_forbids_are_refused() {
    let layout = |mode, filter, stride, count| Layout { mode, filter, stride, count }.check();
    use {Filter as F, Mode as M};
    for (mode, filter, stride, count) in [
        (M::Attributes, F::None, 0, 1),
        (M::Attributes, F::None, 6, 1),
        (M::Attributes, F::None, 260, 1),
        (M::Attributes, F::Octahedral, 12, 1),
        (M::Attributes, F::Quaternion, 4, 1),
        (M::Triangles, F::None, 1, 3),
        (M::Triangles, F::None, 4, 4),
        (M::Indices, F::None, 8, 1),
        (M::Indices, F::Exponential, 4, 1),
    ] {
        assert!(layout(mode, filter, stride, count).is_err(), "{mode:?} {filter:?} {stride} {count}");
    }
    assert!(layout(M::Attributes, F::Exponential, 12, 7).is_ok());
}
