//! The slow one-dimensional conjugate heat-transfer flow of a heated vertical tube.
