//! Acoustic networks: eigenvalues, modes, first and second derivatives.
