//! The last predictions of a model, which are asked for again.
//!
//! A search that alternates between parameters and noise starts each turn where the last one ended, and
//! Laplace's method wants the derivatives where the search has just had them.

use crate::problem::Prediction;
use rijke_numerics::Order;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

/// Most numbers kept: 16 MB.
const CAPACITY: usize = 1 << 21;

/// The last predictions with derivatives.
///
/// Only the very order that was computed is found again: a model may reach the same values by other
/// operations at another order, and results must not depend on what other threads made it forget.
#[derive(Default)]
pub(crate) struct Memory(Mutex<VecDeque<Known>>);

struct Known {
    parameters: Vec<f64>,
    order: Order,
    prediction: Arc<Prediction>,
}

impl Memory {
    /// The prediction to `order` at the physical `parameters`, if it is known.
    pub(crate) fn recall(&self, parameters: &[f64], order: Order) -> Option<Prediction> {
        let known = self.0.lock().ok()?;
        let same = |k: &&Known| k.order == order && k.parameters == parameters;
        let found = known.iter().rev().find(same).map(|k| k.prediction.clone());
        drop(known);
        found.map(Arc::unwrap_or_clone)
    }

    /// Keeps a prediction, unless it has no derivatives and so costs little, and forgets the oldest ones.
    pub(crate) fn keep(&self, parameters: &[f64], order: Order, prediction: &Prediction) {
        if order == Order::Value || size(prediction) > CAPACITY {
            return;
        }
        let new = Known { parameters: parameters.to_vec(), order, prediction: Arc::new(prediction.clone()) };
        let Ok(mut known) = self.0.lock() else { return };
        known.push_back(new);
        while known.iter().map(|k| size(&k.prediction)).sum::<usize>() > CAPACITY {
            known.pop_front();
        }
    }
}

fn size(prediction: &Prediction) -> usize {
    prediction.values.len() + prediction.jacobian.as_slice().len() + prediction.curvature.len()
}
