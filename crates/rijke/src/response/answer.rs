//! A network of a file, driven.

use crate::failure::{Classify, Failure};
use rijke_network::file::{Built, DrivenQuantity, read};
use rijke_numerics::C64;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// A network from a file.
pub(super) struct Driven {
    pub(super) title: Option<String>,
    pub(super) warnings: Vec<String>,
    /// Highest frequency of the file's search, Hz.
    pub(super) highest_hz: f64,
    path: PathBuf,
    built: Built,
}

impl Driven {
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let text = rijke_numerics::read_text(path).or_bad_input().map_err(|failure| {
            failure.at(path).remedy("Name a network file; fixtures/networks holds examples.")
        })?;
        let built = read(&text).or_bad_input().map_err(|failure| failure.at(path))?;
        Ok(Self {
            title: built.name.clone(),
            warnings: built.warnings.iter().map(ToString::to_string).collect(),
            highest_hz: built.region.omega[1] / (2.0 * PI),
            path: path.to_owned(),
            built,
        })
    }

    /// Names and values of the columns of an answer.
    pub(super) fn answer(
        &self,
        quantity: &DrivenQuantity,
        frequencies: &[f64],
    ) -> Result<Vec<(String, Vec<C64>)>, Failure> {
        self.built.driven(quantity, frequencies).map_err(|error| {
            let remedy = error.remedy();
            Failure::bad_input(error).at(&self.path).remedy(remedy)
        })
    }
}
