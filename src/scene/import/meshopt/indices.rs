//! Modes TRIANGLES and INDICES (appendix A of the extension).

use super::{LEFT_OVER, SHORT};

/// The last 16 things pushed. What was never pushed reads as the start value, which no mesh has as an index.
struct Recent<T> {
    items: [T; 16],
    pushed: usize,
}

impl<T: Copy> Recent<T> {
    fn new(start: T) -> Self {
        Self { items: [start; 16], pushed: 0 }
    }

    fn push(&mut self, item: T) {
        self.items[self.pushed % 16] = item;
        self.pushed += 1;
    }

    /// The `age`-th newest, 0 being the newest.
    fn get(&self, age: u8) -> T {
        self.items[self.pushed.wrapping_sub(1 + usize::from(age)) % 16]
    }
}

/// What the triangle codec remembers from triangle to triangle.
struct Triangles<'a> {
    data: &'a [u8],
    /// The next index that was not used yet.
    next: u32,
    /// The last index that was written out.
    last: u32,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
}

impl Triangles<'_> {
    fn unused(&mut self) -> u32 {
        let index = self.next;
        self.next = self.next.wrapping_add(1);
        index
    }

    /// An index that is written out as a difference to the last such one.
    fn explicit(&mut self) -> Result<u32, &'static str> {
        let v = varint(&mut self.data)?;
        self.last = self.last.wrapping_add((v >> 1) ^ (v & 1).wrapping_neg());
        Ok(self.last)
    }

    /// A corner by its code: 0 is an unused index, 15 a written one if `written` allows it, others a recent one.
    fn corner(&mut self, code: u8) -> Result<u32, &'static str> {
        match code {
            0 => Ok(self.unused()),
            15 => self.explicit(),
            _ => Ok(self.vertices.get(code - 1)),
        }
    }

    /// A triangle on a recent edge.
    fn on_edge(&mut self, age: u8, code: u8) -> Result<[u32; 3], &'static str> {
        let [a, b] = self.edges.get(age);
        let c = match code {
            0 => self.unused(),
            13 => {
                self.last = self.last.wrapping_sub(1);
                self.last
            }
            14 => {
                self.last = self.last.wrapping_add(1);
                self.last
            }
            15 => self.explicit()?,
            _ => self.vertices.get(code),
        };
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        if !(1..13).contains(&code) {
            self.vertices.push(c);
        }
        Ok([a, b, c])
    }

    /// A triangle whose corners are coded one by one: the first is unused or written, the others by `codes`.
    fn alone(&mut self, first_written: bool, codes: u8) -> Result<[u32; 3], &'static str> {
        let a = if first_written { self.explicit()? } else { self.unused() };
        let (b, c) = (self.corner(codes >> 4)?, self.corner(codes & 15)?);
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        self.vertices.push(a);
        for (code, vertex) in [(codes >> 4, b), (codes & 15, c)] {
            if code == 0 || code == 15 {
                self.vertices.push(vertex);
            }
        }
        Ok([a, b, c])
    }
}

/// Decodes a list of `count` indices (a multiple of 3) of `width` bytes each, 2 or 4.
pub fn triangles(width: usize, count: u64, data: &[u8]) -> Result<Vec<u8>, &'static str> {
    let (header, data) = data.split_first().ok_or(SHORT)?;
    // Version 0 lacks two codes, which its streams do not use.
    if !matches!(header, 0xe0 | 0xe1) {
        return Err("it is not triangles of a version that can be read");
    }
    let tail = data.len().checked_sub(16).ok_or(SHORT)?;
    let (data, table) = data.split_at(tail);
    let codes = usize::try_from(count / 3).map_err(|_| SHORT)?;
    let (codes, data) = data.split_at_checked(codes).ok_or(SHORT)?;
    let start = u32::MAX;
    let mut state = Triangles { data, next: 0, last: 0, edges: Recent::new([start; 2]), vertices: Recent::new(start) };
    let mut bytes = Vec::with_capacity(codes.len() * 3 * width);
    for &code in codes {
        let triangle = match (code >> 4, code & 15) {
            (15, low @ 14..) => {
                let corners = *state.data.split_off_first().ok_or(SHORT)?;
                if corners == 0 {
                    state.next = 0;
                }
                state.alone(low == 15, corners)?
            }
            (15, low) => {
                let corners = table[usize::from(low)];
                if corners >> 4 == 15 || corners & 15 == 15 {
                    return Err("its table of corners is wrong");
                }
                state.alone(false, corners)?
            }
            (age, code) => state.on_edge(age, code)?,
        };
        triangle.iter().for_each(|index| bytes.extend_from_slice(&index.to_le_bytes()[..width]));
    }
    if state.data.is_empty() { Ok(bytes) } else { Err(LEFT_OVER) }
}

/// Decodes `count` indices of any meaning, of `width` bytes each, 2 or 4.
pub fn sequence(width: usize, count: u64, data: &[u8]) -> Result<Vec<u8>, &'static str> {
    let (header, data) = data.split_first().ok_or(SHORT)?;
    if !matches!(header, 0xd0 | 0xd1) {
        return Err("it is not indices of a version that can be read");
    }
    let tail = data.len().checked_sub(4).ok_or(SHORT)?;
    let mut data = &data[..tail];
    // Each index takes a byte or more, so that the count is no larger than the data.
    let mut last = [0u32; 2];
    let mut bytes = Vec::new();
    for _ in 0..count {
        let v = varint(&mut data)?;
        let last = &mut last[(v & 1) as usize];
        *last = last.wrapping_add((v >> 2) ^ (v >> 1 & 1).wrapping_neg());
        bytes.extend_from_slice(&last.to_le_bytes()[..width]);
    }
    if data.is_empty() { Ok(bytes) } else { Err(LEFT_OVER) }
}

/// An unsigned number in groups of seven bits, the lowest first; bits beyond 32 are dropped.
fn varint(data: &mut &[u8]) -> Result<u32, &'static str> {
    let mut value = 0;
    for shift in [0, 7, 14, 21, 28] {
        let byte = *data.split_off_first().ok_or(SHORT)?;
        value |= u32::from(byte & 127) << shift;
        if byte < 128 {
            return Ok(value);
        }
    }
    Err("it has a number of more than 5 bytes")
}
