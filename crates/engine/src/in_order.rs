//! Results of work that threads share.

use crate::EngineError;
use rayon::prelude::*;

/// Results in their order. Rayon's own `collect` gives the error of whichever thread fails first.
pub(crate) trait InOrder<T> {
    /// All values, or the error of the first place that has one, for any number of threads.
    fn in_order(self) -> Result<Vec<T>, EngineError>;
}

impl<T: Send, I: IndexedParallelIterator<Item = Result<T, EngineError>>> InOrder<T> for I {
    fn in_order(self) -> Result<Vec<T>, EngineError> {
        self.collect::<Vec<_>>().into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_first_error_by_place_is_told() {
        let one = |k: usize| match k % 3 {
            1 => Err(EngineError::NoPoint { stage: k.to_string() }),
            _ => Ok(k),
        };
        for _ in 0..50 {
            let told = (0..64).into_par_iter().map(one).in_order().unwrap_err();
            assert!(matches!(&told, EngineError::NoPoint { stage } if stage == "1"), "{told}");
        }
        assert_eq!((2..4).into_par_iter().map(one).in_order().unwrap(), [2, 3]);
    }
}
