//! The shaders in double precision: naga's form of a pass, run on the host one invocation at a time.
//!
//! Every number that is f32 in a shader is f64 here; what was stored as f32 is read as it is, and only what is stored as
//! bits is rounded. So the twin is the same code, whatever the kernel. Stores to buffers are left out, but for `records`.

use std::sync::Arc;

use naga::{Block, Expression, Function, Handle, Module, Statement, TypeInner, UnaryOperator};

use crate::arithmetic::{B, C, F, I, P, S, Scalar, U, V, Value, binary, cast, literal_of, math};
use crate::memory::{Pointee, Pointer, compose, float_kind, follow, load_words, put, word, zero};

/// Of one call at a time; kept for later calls as deep, since to clear what is known would take longer than most calls.
#[derive(Default)]
struct Frame {
    arguments: Vec<Value>,
    locals: Vec<Value>,
    /// Values of expressions, with the number of the call in which they were known.
    known: Vec<(u64, Value)>,
    call: u64,
}

enum Flow {
    On,
    Break,
    Continue,
    Return(Option<Value>),
}

/// A pass with what is bound to it.
pub struct Double {
    module: Arc<Module>,
    /// By number of the global variable: words of buffers, else none.
    words: Arc<Vec<Option<Vec<u32>>>>,
    private: Vec<Value>,
    frames: Vec<Frame>,
    /// Frames in use.
    depth: usize,
    /// Calls there have been.
    calls: u64,
    /// Last store to `records`.
    pub record: [f64; 4],
    /// What each call of `evaluate` in this invocation has returned: log I, log density, log C of either side.
    pub evaluations: Vec<[f64; 4]>,
}

impl Double {
    /// `bound` gives the words of a buffer by group and binding.
    pub fn new(module: Module, bound: impl Fn(u32, u32) -> Vec<u32>) -> Self {
        let words = module.global_variables.iter().map(|(_, variable)| {
            let binding = variable.binding?;
            Some(bound(binding.group, binding.binding))
        });
        let words = Arc::new(words.collect());
        Self::over(Arc::new(module), words)
    }

    fn over(module: Arc<Module>, words: Arc<Vec<Option<Vec<u32>>>>) -> Self {
        let (private, frames, evaluations) = (vec![], vec![], vec![]);
        Self { module, words, private, frames, depth: 0, calls: 0, record: [0.0; 4], evaluations }
    }

    /// Another one over the same words, for another thread.
    pub fn another(&self) -> Self {
        Self::over(self.module.clone(), self.words.clone())
    }

    /// Runs the invocation of entry `entry` out of `entries`.
    pub fn run(&mut self, entry: u32, entries: u32) {
        let module = self.module.clone();
        self.evaluations.clear();
        self.private = module
            .global_variables
            .iter()
            .map(|(_, variable)| match (variable.binding, variable.init) {
                (None, Some(init)) => self.constant(&module, init),
                (None, None) => zero(&module, variable.ty),
                _ => S(U(0)),
            })
            .collect();
        let three = |x: u32| V([U(x), U(0), U(0), U(0)], 3);
        let main = &module.entry_points[0];
        let [threads, ..] = main.workgroup_size;
        let groups = V([U(entries.div_ceil(threads)), U(1), U(1), U(0)], 3);
        self.call(&module, &main.function, vec![three(entry / threads), groups, S(U(entry % threads))]);
    }

    fn call(&mut self, module: &Module, function: &Function, arguments: Vec<Value>) -> Option<Value> {
        if self.depth == self.frames.len() {
            self.frames.push(Frame::default());
        }
        self.calls += 1;
        let frame = &mut self.frames[self.depth];
        frame.call = self.calls;
        frame.arguments = arguments;
        if frame.known.len() < function.expressions.len() {
            frame.known.resize(function.expressions.len(), (0, S(U(0))));
        }
        self.depth += 1;
        let locals: Vec<Value> = function
            .local_variables
            .iter()
            .map(|(_, local)| match local.init {
                Some(init) => self.value(module, function, init),
                None => zero(module, local.ty),
            })
            .collect();
        self.frame().locals = locals;
        let flow = self.block(module, function, &function.body);
        self.depth -= 1;
        if let Flow::Return(value) = flow { value } else { None }
    }

    fn block(&mut self, module: &Module, function: &Function, block: &Block) -> Flow {
        for statement in block.iter() {
            let flow = self.statement(module, function, statement);
            if !matches!(flow, Flow::On) {
                return flow;
            }
        }
        Flow::On
    }

    fn statement(&mut self, module: &Module, function: &Function, statement: &Statement) -> Flow {
        match statement {
            Statement::Emit(range) => {
                for handle in range.clone() {
                    let value = self.compute(module, function, handle);
                    self.set(handle, value);
                }
            }
            Statement::Block(block) => return self.block(module, function, block),
            Statement::If { condition, accept, reject } => {
                let taken = self.value(module, function, *condition).scalar() == B(true);
                return self.block(module, function, if taken { accept } else { reject });
            }
            Statement::Loop { body, continuing, break_if } => loop {
                match self.block(module, function, body) {
                    Flow::Break => break,
                    Flow::Return(value) => return Flow::Return(value),
                    Flow::On | Flow::Continue => {}
                }
                if let Flow::Return(value) = self.block(module, function, continuing) {
                    return Flow::Return(value);
                }
                if break_if.is_some_and(|end| self.value(module, function, end).scalar() == B(true)) {
                    break;
                }
            },
            Statement::Break => return Flow::Break,
            Statement::Continue => return Flow::Continue,
            Statement::Return { value } => return Flow::Return(value.map(|v| self.value(module, function, v))),
            Statement::Store { pointer, value } => {
                let value = self.value(module, function, *value);
                let P(pointer) = self.value(module, function, *pointer) else { panic!("a store to no pointer") };
                self.store(module, pointer, value);
            }
            Statement::Call { function: called, arguments, result } => {
                let arguments = arguments.iter().map(|a| self.value(module, function, *a)).collect();
                let called = &module.functions[*called];
                let value = self.call(module, called, arguments);
                let evaluates = called.name.as_deref().is_some_and(|name| name.ends_with("evaluate"));
                if let Some(C(e)) = value.as_ref().filter(|_| evaluates) {
                    self.evaluations.push([1, 2, 3, 5].map(|i: usize| e[i].float()));
                }
                if let (Some(result), Some(value)) = (result, value) {
                    self.set(*result, value);
                }
            }
            Statement::Atomic { result, .. } => {
                if let Some(result) = result {
                    self.set(*result, S(U(0)));
                }
            }
            other => panic!("{other:?}"),
        }
        Flow::On
    }

    /// That of the function that runs.
    fn frame(&mut self) -> &mut Frame {
        &mut self.frames[self.depth - 1]
    }

    fn set(&mut self, handle: Handle<Expression>, value: Value) {
        let frame = self.frame();
        frame.known[handle.index()] = (frame.call, value);
    }

    /// What is known already, or needs no statement to be.
    fn value(&mut self, module: &Module, function: &Function, handle: Handle<Expression>) -> Value {
        let frame = self.frame();
        match &frame.known[handle.index()] {
            (call, value) if *call == frame.call => value.clone(),
            _ => self.compute(module, function, handle),
        }
    }

    fn constant(&self, module: &Module, handle: Handle<Expression>) -> Value {
        match &module.global_expressions[handle] {
            Expression::Literal(literal) => S(literal_of(*literal)),
            Expression::Constant(constant) => self.constant(module, module.constants[*constant].init),
            Expression::ZeroValue(ty) => zero(module, *ty),
            Expression::Compose { ty, components } => {
                compose(module, *ty, components.iter().map(|c| self.constant(module, *c)).collect())
            }
            Expression::Splat { size, value } => {
                let value = self.constant(module, *value).scalar();
                Value::of(&vec![value; *size as usize])
            }
            other => panic!("{other:?}"),
        }
    }

    fn compute(&mut self, module: &Module, function: &Function, handle: Handle<Expression>) -> Value {
        let mut get = |handle: &Handle<Expression>| self.value(module, function, *handle);
        match &function.expressions[handle] {
            Expression::Literal(literal) => S(literal_of(*literal)),
            Expression::Constant(constant) => self.constant(module, module.constants[*constant].init),
            Expression::ZeroValue(ty) => zero(module, *ty),
            Expression::Compose { ty, components } => {
                let components = components.iter().map(get).collect();
                compose(module, *ty, components)
            }
            Expression::Access { base, index } => {
                let (base, index) = (get(base), get(index).index());
                self.access(module, base, index)
            }
            Expression::AccessIndex { base, index } => {
                let base = get(base);
                self.access(module, base, *index)
            }
            Expression::Splat { size, value } => Value::of(&vec![get(value).scalar(); *size as usize]),
            Expression::Swizzle { size, vector, pattern } => {
                let vector = get(vector);
                let picked: Vec<Scalar> =
                    pattern[..*size as usize].iter().map(|c| vector.scalars()[*c as usize]).collect();
                Value::of(&picked)
            }
            Expression::FunctionArgument(i) => self.frame().arguments[*i as usize].clone(),
            Expression::GlobalVariable(variable) => {
                let (number, global) = (variable.index(), &module.global_variables[*variable]);
                P(if self.words[number].is_some() {
                    Pointer::Words { buffer: number, offset: 0, of: Pointee::Type(global.ty) }
                } else {
                    Pointer::Global { variable: number, way: vec![] }
                })
            }
            Expression::LocalVariable(variable) => {
                P(Pointer::Local { frame: self.depth - 1, variable: variable.index(), way: vec![] })
            }
            Expression::Load { pointer } => {
                let P(pointer) = get(pointer) else { panic!("a load from no pointer") };
                self.load(module, &pointer)
            }
            Expression::Unary { op, expr } => {
                let op = *op;
                get(expr).map(|s| match (op, s) {
                    (UnaryOperator::Negate, F(x)) => F(-x),
                    (UnaryOperator::Negate, I(x)) => I(x.wrapping_neg()),
                    (UnaryOperator::LogicalNot, B(x)) => B(!x),
                    (UnaryOperator::BitwiseNot, U(x)) => U(!x),
                    other => panic!("{other:?}"),
                })
            }
            Expression::Binary { op, left, right } => {
                let (left, right) = (get(left), get(right));
                left.zip(&right, |a, b| binary(*op, a, b))
            }
            Expression::Select { condition, accept, reject } => {
                let (condition, accept, reject) = (get(condition), get(accept), get(reject));
                match &condition {
                    S(B(taken)) => {
                        if *taken {
                            accept
                        } else {
                            reject
                        }
                    }
                    _ => {
                        let parts = condition.scalars().iter().zip(accept.scalars().iter().zip(reject.scalars()));
                        let parts: Vec<Scalar> = parts.map(|(c, (a, r))| if *c == B(true) { *a } else { *r }).collect();
                        Value::of(&parts)
                    }
                }
            }
            Expression::Relational { fun, argument } => {
                let argument = get(argument);
                let mut parts = argument.scalars().iter().map(|s| *s == B(true));
                S(B(match fun {
                    naga::RelationalFunction::All => parts.all(|b| b),
                    naga::RelationalFunction::Any => parts.any(|b| b),
                    other => panic!("{other:?}"),
                }))
            }
            Expression::Math { fun, arg, arg1, arg2, .. } => {
                let arguments: Vec<Value> = [Some(*arg), *arg1, *arg2].iter().flatten().map(get).collect();
                math(*fun, &arguments)
            }
            Expression::As { expr, kind, convert } => {
                let (kind, converts) = (*kind, convert.is_some());
                get(expr).map(|s| cast(s, kind, converts))
            }
            other => panic!("{other:?}"),
        }
    }

    fn access(&self, module: &Module, base: Value, index: u32) -> Value {
        let further = |mut way: Vec<u32>| {
            way.push(index);
            way
        };
        match base {
            P(Pointer::Words { buffer, offset, of: Pointee::Type(ty) }) => {
                let (offset, of) = match &module.types[ty].inner {
                    TypeInner::Vector { scalar, .. } => (offset + index as usize, Pointee::Scalar(scalar.kind)),
                    TypeInner::Array { base, stride, .. } => {
                        (offset + index as usize * *stride as usize / 4, Pointee::Type(*base))
                    }
                    TypeInner::Struct { members, .. } => {
                        let member = &members[index as usize];
                        (offset + member.offset as usize / 4, Pointee::Type(member.ty))
                    }
                    other => panic!("{other:?}"),
                };
                P(Pointer::Words { buffer, offset, of })
            }
            P(Pointer::Global { variable, way }) => P(Pointer::Global { variable, way: further(way) }),
            P(Pointer::Local { frame, variable, way }) => P(Pointer::Local { frame, variable, way: further(way) }),
            value => value.member(index),
        }
    }

    fn load(&self, module: &Module, pointer: &Pointer) -> Value {
        match pointer {
            Pointer::Words { buffer, offset, of } => {
                let words = self.words[*buffer].as_ref().unwrap();
                match of {
                    Pointee::Scalar(kind) => S(float_kind(*kind, word(words, *offset))),
                    Pointee::Type(ty) => load_words(module, words, *offset, *ty),
                }
            }
            Pointer::Global { variable, way } => follow(&self.private[*variable], way),
            Pointer::Local { frame, variable, way } => follow(&self.frames[*frame].locals[*variable], way),
        }
    }

    fn store(&mut self, module: &Module, pointer: Pointer, value: Value) {
        let (place, way) = match &pointer {
            Pointer::Words { buffer, .. } => {
                let (_, global) = module.global_variables.iter().nth(*buffer).unwrap();
                if global.name.as_deref().is_some_and(|name| name.ends_with("records")) {
                    self.record = value.floats().try_into().unwrap();
                }
                return;
            }
            Pointer::Global { variable, way } => (&mut self.private[*variable], way),
            Pointer::Local { frame, variable, way } => (&mut self.frames[*frame].locals[*variable], way),
        };
        put(place, way, value);
    }
}
