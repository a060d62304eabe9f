//! The functions and constants that every formula knows.

use rijke_numerics::C64;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Sqrt,
    Exp,
    Ln,
    Sin,
    Cos,
    Tan,
    Sinh,
    Cosh,
    Tanh,
    BesselRatio,
    Howe,
    /// What `howe` divides, and by what: for its zeros and poles, not for formulas.
    HoweAbove,
    HoweBelow,
    Re,
    Im,
    Abs,
    Arg,
    Conj,
}

/// Names of the functions; `log` is the natural logarithm, as in MATLAB and Python; `bessel_ratio` is I1/I0
/// for Re z >= 0, `howe` that of [`rijke_numerics::howe`].
pub(crate) const FUNCTIONS: [(&str, Function); 17] = [
    ("sqrt", Function::Sqrt),
    ("exp", Function::Exp),
    ("ln", Function::Ln),
    ("log", Function::Ln),
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("sinh", Function::Sinh),
    ("cosh", Function::Cosh),
    ("tanh", Function::Tanh),
    ("bessel_ratio", Function::BesselRatio),
    ("howe", Function::Howe),
    ("re", Function::Re),
    ("im", Function::Im),
    ("abs", Function::Abs),
    ("arg", Function::Arg),
    ("conj", Function::Conj),
];

/// Names of constants, the same in every formula.
pub(crate) const CONSTANTS: [(&str, C64); 3] =
    [("i", C64::I), ("j", C64::I), ("pi", C64::new(std::f64::consts::PI, 0.0))];

impl Function {
    pub(crate) fn name(self) -> &'static str {
        FUNCTIONS.iter().find(|(_, f)| *f == self).map_or("", |(name, _)| name)
    }

    pub(crate) fn is_analytic(self) -> bool {
        !matches!(self, Self::Re | Self::Im | Self::Abs | Self::Arg | Self::Conj)
    }
}

/// Whether `name` is a function or a constant.
pub(crate) fn is_reserved(name: &str) -> bool {
    FUNCTIONS.iter().any(|(n, _)| *n == name) || CONSTANTS.iter().any(|(n, _)| *n == name)
}
