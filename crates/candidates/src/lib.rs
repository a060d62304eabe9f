//! Competing models of each component as effects on feedback and reflection coefficients.
