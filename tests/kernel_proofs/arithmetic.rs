//! Values of shaders in double precision, and what is done with them: see double.rs.

use naga::{BinaryOperator as Op, Literal, MathFunction as Math, ScalarKind};

use crate::memory::Pointer;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scalar {
    F(f64),
    U(u32),
    I(i32),
    B(bool),
}
pub use Scalar::{B, F, I, U};

#[derive(Debug, Clone)]
pub enum Value {
    S(Scalar),
    V([Scalar; 4], usize),
    /// Members of a struct or an array.
    C(Vec<Value>),
    P(Pointer),
}
pub use Value::{C, P, S, V};

impl Value {
    pub fn scalar(&self) -> Scalar {
        match self {
            S(s) => *s,
            other => panic!("{other:?} is no scalar"),
        }
    }

    pub fn index(&self) -> u32 {
        match self.scalar() {
            U(n) => n,
            I(n) => n as u32,
            other => panic!("{other:?} is no index"),
        }
    }

    pub fn float(&self) -> f64 {
        match self.scalar() {
            F(x) => x,
            other => panic!("{other:?} is no number"),
        }
    }

    pub fn floats(&self) -> Vec<f64> {
        self.scalars().iter().map(|s| S(*s).float()).collect()
    }

    pub fn scalars(&self) -> &[Scalar] {
        match self {
            S(s) => std::slice::from_ref(s),
            V(all, n) => &all[..*n],
            other => panic!("{other:?} is no vector"),
        }
    }

    pub fn of(scalars: &[Scalar]) -> Self {
        match scalars {
            [one] => S(*one),
            _ => {
                let mut all = [U(0); 4];
                all[..scalars.len()].copy_from_slice(scalars);
                V(all, scalars.len())
            }
        }
    }

    pub fn map(&self, f: impl Fn(Scalar) -> Scalar) -> Self {
        let scalars: Vec<Scalar> = self.scalars().iter().map(|s| f(*s)).collect();
        Self::of(&scalars)
    }

    /// Pairs of components; a scalar goes with each of the other's.
    pub fn zip(&self, other: &Self, f: impl Fn(Scalar, Scalar) -> Scalar) -> Self {
        let (a, b) = (self.scalars(), other.scalars());
        let at = |all: &[Scalar], i: usize| if all.len() == 1 { all[0] } else { all[i] };
        let scalars: Vec<Scalar> = (0..a.len().max(b.len())).map(|i| f(at(a, i), at(b, i))).collect();
        Self::of(&scalars)
    }

    pub fn member(&self, i: u32) -> Self {
        match self {
            V(all, n) => S(all[(i as usize).min(n - 1)]),
            C(all) => all[(i as usize).min(all.len() - 1)].clone(),
            other => panic!("{other:?} has no members"),
        }
    }
}

pub fn literal_of(literal: Literal) -> Scalar {
    match literal {
        Literal::F32(x) => F(f64::from(x)),
        Literal::U32(x) => U(x),
        Literal::I32(x) => I(x),
        Literal::Bool(x) => B(x),
        other => panic!("{other:?}"),
    }
}

pub fn zero_of(kind: ScalarKind) -> Scalar {
    match kind {
        ScalarKind::Float => F(0.0),
        ScalarKind::Uint => U(0),
        ScalarKind::Sint => I(0),
        _ => B(false),
    }
}

pub fn cast(s: Scalar, kind: ScalarKind, converts: bool) -> Scalar {
    match (s, kind, converts) {
        (F(x), ScalarKind::Uint, false) => U((x as f32).to_bits()),
        (F(x), ScalarKind::Sint, false) => I((x as f32).to_bits() as i32),
        (U(x), ScalarKind::Float, false) => F(f64::from(f32::from_bits(x))),
        (I(x), ScalarKind::Float, false) => F(f64::from(f32::from_bits(x as u32))),
        (F(x), ScalarKind::Float, _) => F(x),
        (F(x), ScalarKind::Uint, true) => U(x as u32),
        (F(x), ScalarKind::Sint, true) => I(x as i32),
        (F(x), ScalarKind::Bool, _) => B(x != 0.0),
        (U(x), ScalarKind::Float, true) => F(f64::from(x)),
        (I(x), ScalarKind::Float, true) => F(f64::from(x)),
        (B(x), ScalarKind::Float, _) => F(f64::from(u8::from(x))),
        (U(x), ScalarKind::Sint, _) => I(x as i32),
        (I(x), ScalarKind::Uint, _) => U(x as u32),
        (B(x), ScalarKind::Uint, _) => U(u32::from(x)),
        (B(x), ScalarKind::Sint, _) => I(i32::from(x)),
        (U(x), ScalarKind::Bool, _) => B(x != 0),
        (s, ..) => s,
    }
}

pub fn binary(op: Op, a: Scalar, b: Scalar) -> Scalar {
    match (op, a, b) {
        (Op::Add, F(a), F(b)) => F(a + b),
        (Op::Subtract, F(a), F(b)) => F(a - b),
        (Op::Multiply, F(a), F(b)) => F(a * b),
        (Op::Divide, F(a), F(b)) => F(a / b),
        (Op::Modulo, F(a), F(b)) => F(a % b),
        (Op::Add, U(a), U(b)) => U(a.wrapping_add(b)),
        (Op::Subtract, U(a), U(b)) => U(a.wrapping_sub(b)),
        (Op::Multiply, U(a), U(b)) => U(a.wrapping_mul(b)),
        (Op::Divide, U(a), U(b)) => U(a.checked_div(b).unwrap_or(a)),
        (Op::Modulo, U(a), U(b)) => U(a.checked_rem(b).unwrap_or(0)),
        (Op::And, U(a), U(b)) => U(a & b),
        (Op::InclusiveOr, U(a), U(b)) => U(a | b),
        (Op::ExclusiveOr, U(a), U(b)) => U(a ^ b),
        (Op::ShiftLeft, U(a), U(b)) => U(a.wrapping_shl(b)),
        (Op::ShiftRight, U(a), U(b)) => U(a.wrapping_shr(b)),
        (Op::Add, I(a), I(b)) => I(a.wrapping_add(b)),
        (Op::Subtract, I(a), I(b)) => I(a.wrapping_sub(b)),
        (Op::Multiply, I(a), I(b)) => I(a.wrapping_mul(b)),
        (Op::Divide, I(a), I(b)) => I(a.checked_div(b).unwrap_or(a)),
        (Op::Modulo, I(a), I(b)) => I(a.checked_rem(b).unwrap_or(0)),
        (Op::ShiftLeft, I(a), U(b)) => I(a.wrapping_shl(b)),
        (Op::ShiftRight, I(a), U(b)) => I(a.wrapping_shr(b)),
        (Op::And, I(a), I(b)) => I(a & b),
        (Op::And | Op::LogicalAnd, B(a), B(b)) => B(a && b),
        (Op::InclusiveOr | Op::LogicalOr, B(a), B(b)) => B(a || b),
        (Op::Equal, a, b) => B(a == b),
        (Op::NotEqual, a, b) => B(a != b),
        _ => B(compare(op, a, b)),
    }
}

pub fn compare(op: Op, a: Scalar, b: Scalar) -> bool {
    let order = match (a, b) {
        (F(a), F(b)) => a.partial_cmp(&b),
        (U(a), U(b)) => Some(a.cmp(&b)),
        (I(a), I(b)) => Some(a.cmp(&b)),
        other => panic!("{op:?} of {other:?}"),
    };
    match op {
        Op::Less => order.is_some_and(|o| o.is_lt()),
        Op::LessEqual => order.is_some_and(|o| o.is_le()),
        Op::Greater => order.is_some_and(|o| o.is_gt()),
        Op::GreaterEqual => order.is_some_and(|o| o.is_ge()),
        other => panic!("{other:?} of {a:?} and {b:?}"),
    }
}

pub fn math(fun: Math, arguments: &[Value]) -> Value {
    let a = &arguments[0];
    let dot = |a: &Value, b: &Value| a.floats().iter().zip(b.floats()).map(|(a, b)| a * b).sum::<f64>();
    let each = |f: fn(f64) -> f64| a.map(|s| F(f(S(s).float())));
    let smaller = |a: Scalar, b: Scalar| if compare(Op::Less, b, a) { b } else { a };
    let larger = |a: Scalar, b: Scalar| if compare(Op::Less, a, b) { b } else { a };
    match fun {
        Math::Abs => a.map(|s| match s {
            F(x) => F(x.abs()),
            I(x) => I(x.wrapping_abs()),
            other => other,
        }),
        Math::Min => a.zip(&arguments[1], smaller),
        Math::Max => a.zip(&arguments[1], larger),
        Math::Clamp => a.zip(&arguments[1], larger).zip(&arguments[2], smaller),
        Math::Saturate => each(|x| x.clamp(0.0, 1.0)),
        Math::Cos => each(f64::cos),
        Math::Sin => each(f64::sin),
        Math::Tan => each(f64::tan),
        Math::Acos => each(f64::acos),
        Math::Asin => each(f64::asin),
        Math::Atan => each(f64::atan),
        Math::Atan2 => a.zip(&arguments[1], |a, b| F(S(a).float().atan2(S(b).float()))),
        Math::Ceil => each(f64::ceil),
        Math::Floor => each(f64::floor),
        Math::Trunc => each(f64::trunc),
        Math::Fract => each(|x| x - x.floor()),
        Math::Exp => each(f64::exp),
        Math::Exp2 => each(f64::exp2),
        Math::Log => each(f64::ln),
        Math::Log2 => each(f64::log2),
        Math::Sqrt => each(f64::sqrt),
        Math::InverseSqrt => each(|x| 1.0 / x.sqrt()),
        Math::Sign => each(|x| {
            if x > 0.0 {
                1.0
            } else if x < 0.0 {
                -1.0
            } else {
                0.0
            }
        }),
        Math::Pow => a.zip(&arguments[1], |a, b| F(S(a).float().powf(S(b).float()))),
        Math::Dot => S(F(dot(a, &arguments[1]))),
        Math::Length => S(F(dot(a, a).sqrt())),
        Math::Distance => {
            let d = a.zip(&arguments[1], |a, b| binary(Op::Subtract, a, b));
            S(F(dot(&d, &d).sqrt()))
        }
        Math::Normalize => {
            let length = dot(a, a).sqrt();
            a.map(|s| F(S(s).float() / length))
        }
        Math::Cross => {
            let (a, b) = (a.floats(), arguments[1].floats());
            let part = |i: usize, j: usize| F(a[i] * b[j] - a[j] * b[i]);
            Value::of(&[part(1, 2), part(2, 0), part(0, 1)])
        }
        Math::Mix => {
            let step = arguments[1].zip(a, |b, a| binary(Op::Subtract, b, a));
            let part = step.zip(&arguments[2], |d, t| binary(Op::Multiply, d, t));
            a.zip(&part, |a, d| binary(Op::Add, a, d))
        }
        Math::Reflect => {
            let twice = 2.0 * dot(a, &arguments[1]);
            a.zip(&arguments[1], |a, n| F(S(a).float() - twice * S(n).float()))
        }
        Math::Fma => {
            let product = a.zip(&arguments[1], |a, b| binary(Op::Multiply, a, b));
            product.zip(&arguments[2], |p, c| binary(Op::Add, p, c))
        }
        Math::CountOneBits => a.map(|s| U(S(s).index().count_ones())),
        Math::FirstLeadingBit => a.map(|s| U(S(s).index().checked_ilog2().unwrap_or(u32::MAX))),
        Math::FirstTrailingBit => a.map(|s| match S(s).index() {
            0 => U(u32::MAX),
            x => U(x.trailing_zeros()),
        }),
        Math::Unpack2x16snorm => {
            let word = a.index();
            let part = |shift: u32| F((f64::from((word >> shift) as u16 as i16) / 32767.0).max(-1.0));
            Value::of(&[part(0), part(16)])
        }
        Math::Unpack4x8unorm => {
            let word = a.index();
            Value::of(&[0, 8, 16, 24].map(|shift: u32| F(f64::from((word >> shift) & 255) / 255.0)))
        }
        Math::Unpack2x16unorm => {
            let word = a.index();
            Value::of(&[0, 16].map(|shift: u32| F(f64::from((word >> shift) & 0xffff) / 65535.0)))
        }
        other => panic!("{other:?}"),
    }
}
