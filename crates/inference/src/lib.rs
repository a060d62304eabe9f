//! Parameters, priors, MAP, Laplace, evidence, ranking, ensemble Kalman filter.
