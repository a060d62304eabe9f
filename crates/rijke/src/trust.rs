//! How far evidences are checked: an option of several commands.

use crate::number;
use rijke_engine::run::Trusted;
use rijke_inference::SamplerKind;
use rijke_numerics::Failed;

/// How far evidences are checked.
#[derive(Clone, Copy, clap::Args)]
pub(crate) struct Trust {
    /// Search for one maximum of each posterior, and skip the checks of the evidence. Faster; wrong where a
    /// posterior has several maxima.
    #[arg(long, conflicts_with = "sampler")]
    one_start: bool,
    /// Compare every evidence with a slow method that needs no Gaussian approximation.
    #[arg(long, value_name = "METHOD")]
    sampler: Option<Sampler>,
    /// Statistical error of the sampler, nats; its cost grows with the inverse square.
    #[arg(long, value_name = "NATS", default_value_t = 0.3, value_parser = number::positive)]
    sampler_error: f64,
}

/// Slow methods of evidence.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Sampler {
    /// Nested sampling.
    Nested,
    /// The gradient sampler NUTS with bridge sampling; only if the program was built with the feature `nuts`.
    Nuts,
}

impl Trust {
    pub(crate) fn has_sampler(self) -> bool {
        self.sampler.is_some()
    }

    pub(crate) fn trusted(self) -> Result<Trusted, Failed> {
        let kind = match self.sampler {
            Some(Sampler::Nested) => SamplerKind::Nested,
            Some(Sampler::Nuts) if cfg!(feature = "nuts") => SamplerKind::Nuts,
            Some(Sampler::Nuts) => {
                return Err(Failed::bad_input("--sampler nuts: this program was built without NUTS")
                    .remedy("Build it with `cargo install --path crates/rijke --features nuts`, or use --sampler nested."));
            }
            None if self.one_start => return Ok(Trusted::Laplace),
            None => return Ok(Trusted::Checked),
        };
        Ok(Trusted::Sampled(kind, self.sampler_error))
    }
}
