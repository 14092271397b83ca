//! Variables and buffers of shaders in double precision: see double.rs.

use naga::{Handle, Module, ScalarKind, Type, TypeInner};

use crate::arithmetic::{C, F, I, S, Scalar, U, V, Value, zero_of};

/// Where a pointer leads: a place in words of a buffer, or a variable and the way into it.
#[derive(Debug, Clone)]
pub enum Pointer {
    Words { buffer: usize, offset: usize, of: Pointee },
    Global { variable: usize, way: Vec<u32> },
    Local { frame: usize, variable: usize, way: Vec<u32> },
}

#[derive(Debug, Clone, Copy)]
pub enum Pointee {
    Type(Handle<Type>),
    Scalar(ScalarKind),
}

pub fn float_kind(kind: ScalarKind, word: u32) -> Scalar {
    match kind {
        ScalarKind::Float => F(f64::from(f32::from_bits(word))),
        ScalarKind::Uint => U(word),
        ScalarKind::Sint => I(word as i32),
        other => panic!("{other:?} in a buffer"),
    }
}

/// Beyond the end as robust access has it: something.
pub fn word(words: &[u32], offset: usize) -> u32 {
    words.get(offset).copied().unwrap_or(0)
}

pub fn load_words(module: &Module, words: &[u32], offset: usize, ty: Handle<Type>) -> Value {
    match &module.types[ty].inner {
        TypeInner::Scalar(scalar) => S(float_kind(scalar.kind, word(words, offset))),
        TypeInner::Vector { size, scalar } => {
            let parts: Vec<Scalar> =
                (0..*size as usize).map(|i| float_kind(scalar.kind, word(words, offset + i))).collect();
            Value::of(&parts)
        }
        TypeInner::Struct { members, .. } => {
            C(members.iter().map(|m| load_words(module, words, offset + m.offset as usize / 4, m.ty)).collect())
        }
        other => panic!("{other:?}"),
    }
}

pub fn follow(value: &Value, way: &[u32]) -> Value {
    match way {
        [] => value.clone(),
        [i, rest @ ..] => match value {
            C(all) => follow(&all[(*i as usize).min(all.len() - 1)], rest),
            other => other.member(*i),
        },
    }
}

pub fn put(place: &mut Value, way: &[u32], value: Value) {
    match (way, place) {
        ([], place) => *place = value,
        ([i, rest @ ..], C(all)) => {
            let last = all.len() - 1;
            put(&mut all[(*i as usize).min(last)], rest, value);
        }
        ([i], V(all, _)) => all[*i as usize] = value.scalar(),
        (_, other) => panic!("{other:?} has no members"),
    }
}

pub fn zero(module: &Module, ty: Handle<Type>) -> Value {
    match &module.types[ty].inner {
        TypeInner::Scalar(scalar) => S(zero_of(scalar.kind)),
        TypeInner::Vector { size, scalar } => Value::of(&vec![zero_of(scalar.kind); *size as usize]),
        TypeInner::Struct { members, .. } => C(members.iter().map(|m| zero(module, m.ty)).collect()),
        TypeInner::Array { base, size: naga::ArraySize::Constant(n), .. } => {
            C(vec![zero(module, *base); n.get() as usize])
        }
        other => panic!("{other:?}"),
    }
}

pub fn compose(module: &Module, ty: Handle<Type>, components: Vec<Value>) -> Value {
    match &module.types[ty].inner {
        TypeInner::Vector { .. } => {
            let parts: Vec<Scalar> = components.iter().flat_map(|c| c.scalars().to_vec()).collect();
            Value::of(&parts)
        }
        _ => C(components),
    }
}
