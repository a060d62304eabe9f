//! A formula: text that has become a program.

use crate::inspect::{share, units};
use crate::read::{Binary, Context, FormulaError, Function, Scope, definitions};
use crate::run::{Here, Operand, Operation, evaluate};
use rijke_numerics::{C64, ComplexDual, Jet};

/// A formula in the names of a [`Scope`] and in parameters.
///
/// It knows names by their indices: use it with the scope that it was read in, or with one that has grown
/// from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    source: String,
    program: Vec<Operation>,
}

impl Formula {
    /// Reads a formula.
    ///
    /// # Errors
    /// [`FormulaError`], with the offset of the first thing that is wrong in the formula or in a definition.
    pub fn parse(source: &str, context: &Context<'_>) -> Result<Self, FormulaError> {
        let tree = definitions::tree(source, context)?;
        let mut program = Vec::new();
        evaluate::compile(&tree, &mut program);
        Ok(Self { source: source.to_owned(), program })
    }

    /// The formula as it was written, without its definitions.
    #[must_use]
    pub fn source(&self) -> &str {
        &self.source
    }

    /// Its value, with derivatives. A name without a value `here` (excluded when the formula was read in
    /// the right context) or a missing parameter gives NaN, never a panic.
    #[must_use]
    pub fn evaluate(&self, here: &Here<'_, Jet>, parameters: &[Jet]) -> Jet {
        let parameter = |index: usize| parameters.get(index).cloned().map(Operand::Full);
        evaluate::run(&self.program, here, parameter, |z| here.space.constant(z))
    }

    /// As [`Formula::evaluate`], with the derivative with respect to s alone: without parameters as seeds
    /// it needs no jets.
    #[must_use]
    pub fn evaluate_in_s(&self, here: &Here<'_, ComplexDual>, parameters: &[f64]) -> ComplexDual {
        let number = |value: &f64| Operand::Number(C64::new(*value, 0.0));
        let parameter = |index: usize| parameters.get(index).map(number);
        evaluate::run(&self.program, here, parameter, |value| ComplexDual { value, slope: C64::ZERO })
    }

    /// The value of a formula of real names alone, as a place or the number of parts. `numbers` holds their
    /// values by index. NaN if s or a parameter enters, if a name has no value, or if the value is not
    /// real.
    #[must_use]
    pub fn real(&self, numbers: &[f64]) -> f64 {
        match evaluate::folded(&self.program, numbers, &[]).as_slice() {
            [Operation::Number(z)] if z.im == 0.0 => z.re,
            _ => f64::NAN,
        }
    }

    /// The same formula where the real names have these values by index, with all arithmetic done that
    /// neither s nor a parameter enters. A name whose value is NaN stays a name.
    #[must_use]
    pub fn at(&self, numbers: &[f64]) -> Self {
        self.of_s(numbers, &[])
    }

    /// The same formula as a function of s alone, where the parameters have these values, too: for many
    /// values of s.
    #[must_use]
    pub fn of_s(&self, numbers: &[f64], parameters: &[f64]) -> Self {
        Self { source: self.source.clone(), program: evaluate::folded(&self.program, numbers, parameters) }
    }

    /// g such that the value is g times something that is the same at all places, if the form of the
    /// formula shows that. `numbers` holds the values of the real names at this place by index, `analytic`
    /// the g of those that depend on s: 1 for s itself, none for those that have no value here or no g.
    ///
    /// Ask a formula as it was read: one that comes from [`Formula::at`] no longer knows what differs
    /// between places.
    #[must_use]
    pub fn scale(&self, numbers: &[f64], analytic: &[Option<f64>]) -> Option<f64> {
        share::scale(&self.program, numbers, analytic)
    }

    /// Whether it contains the name with index `name`.
    #[must_use]
    pub fn uses(&self, name: usize) -> bool {
        self.names().any(|used| used == name)
    }

    /// Whether it contains parameter number `index`.
    #[must_use]
    pub fn uses_parameter(&self, index: usize) -> bool {
        self.program.contains(&Operation::Parameter(index))
    }

    /// Whether nothing but sums, products, quotients, square roots and powers by what does not depend on s
    /// are in it.
    #[must_use]
    pub fn is_algebraic(&self) -> bool {
        let of_s = |operations: &[Operation]| operations.iter().any(|o| matches!(o, Operation::Analytic(_)));
        self.program.iter().enumerate().all(|(k, operation)| match operation {
            Operation::Call(function) => *function == Function::Sqrt,
            Operation::Binary(Binary::Power) => !of_s(&self.program[evaluate::start(&self.program, k)..k]),
            _ => true,
        })
    }

    /// Everything that it divides by and that depends on s, inner divisors before those that contain them:
    /// where one of them is zero the formula may have a pole. Bases of negative powers and the cosh of a tanh
    /// are among them; of `howe` what it divides stands for it, which has no poles.
    #[must_use]
    pub fn divisors(&self) -> Vec<Self> {
        let mut all = Vec::new();
        for (k, operation) in self.program.iter().enumerate() {
            let operand = |end: usize| evaluate::start(&self.program, end)..end;
            let mut part = match operation {
                Operation::Binary(Binary::Divide) => self.program[operand(k)].to_vec(),
                Operation::Binary(Binary::Power) => {
                    let exponent = operand(k);
                    match self.program[exponent.clone()] {
                        [Operation::Number(z)] if z.re < 0.0 => {}
                        [Operation::Number(z), Operation::Negate] if z.re > 0.0 => {}
                        _ => continue,
                    }
                    self.program[operand(exponent.start)].to_vec()
                }
                Operation::Call(Function::Tanh | Function::Tan | Function::Howe) => {
                    self.program[operand(k)].to_vec()
                }
                _ => continue,
            };
            match operation {
                Operation::Call(Function::Tanh) => part.push(Operation::Call(Function::Cosh)),
                Operation::Call(Function::Tan) => part.push(Operation::Call(Function::Cos)),
                Operation::Call(Function::Howe) => part.push(Operation::Call(Function::HoweBelow)),
                _ => {}
            }
            if let Some(last @ Operation::Call(Function::Howe)) = part.last_mut() {
                *last = Operation::Call(Function::HoweAbove);
            }
            if part.iter().any(|o| matches!(o, Operation::Analytic(_))) {
                all.push(Self { source: self.source.clone(), program: part });
            }
        }
        all
    }

    /// The program as words, operands before their operation, for an interpreter elsewhere: numbers (`1.5e0`,
    /// or `re,im`), names of the scope as `n` and their index, parameters as `parameter` writes them, `neg`,
    /// `+ - * / ^`, and functions by name.
    #[must_use]
    pub fn postfix(&self, parameter: impl Fn(usize) -> String) -> String {
        let word = |operation: &Operation| match *operation {
            Operation::Number(z) if z.im == 0.0 => format!("{:e}", z.re),
            Operation::Number(z) => format!("{:e},{:e}", z.re, z.im),
            Operation::Global(index) | Operation::Local(index) | Operation::Analytic(index) => {
                format!("n{index}")
            }
            Operation::Parameter(index) => parameter(index),
            Operation::Negate => "neg".to_owned(),
            Operation::Binary(operator) => operator.sign().to_owned(),
            Operation::Call(function) => function.name().to_owned(),
        };
        self.program.iter().map(word).collect::<Vec<_>>().join(" ")
    }

    /// Why the units of the formula do not agree, or do not give the unit `wanted`; none if they do.
    ///
    /// Numbers have any unit where they are added, and none where they multiply. A unit that is not
    /// understood (see [`crate::is_unit`]) is taken to be right, and so is a part whose unit depends on a
    /// parameter, as Q^k.
    #[must_use]
    pub fn unit_fault(&self, scope: &Scope, parameter_units: &[&str], wanted: &str) -> Option<String> {
        units::fault(&self.program, scope, parameter_units, wanted)
    }

    pub(crate) fn names(&self) -> impl Iterator<Item = usize> {
        self.program.iter().filter_map(|operation| match *operation {
            Operation::Global(index) | Operation::Local(index) | Operation::Analytic(index) => Some(index),
            _ => None,
        })
    }
}
