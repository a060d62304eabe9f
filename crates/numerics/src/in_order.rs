//! Results of work that threads share.

use rayon::prelude::*;

/// A collection for results that may fail.
pub trait InOrder: IndexedParallelIterator {
    /// As `collect`, but of several failures the first by place is told, for any number of threads; rayon
    /// tells that of whichever thread fails first. It computes every item, also after a failure.
    fn in_order<C: FromIterator<Self::Item>>(self) -> C {
        self.collect::<Vec<_>>().into_iter().collect()
    }
}

impl<I: IndexedParallelIterator> InOrder for I {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_first_error_by_place_is_told() {
        let one = |k: usize| if k % 3 == 1 { Err(k) } else { Ok(k) };
        for _ in 0..50 {
            assert_eq!((0..64).into_par_iter().map(one).in_order::<Result<Vec<_>, _>>(), Err(1));
        }
        assert_eq!((2..4).into_par_iter().map(one).in_order::<Result<Vec<_>, _>>(), Ok(vec![2, 3]));
    }
}
