//! `rig.toml`, with the folder of OSCILOS beside it if it names one.

use super::oscilos;
use super::read::{File, rig};
use super::whole::Rig;
use crate::source::{Outcome, Source};
use crate::{Campaign, StudyError};
use std::path::Path;

impl Rig {
    /// Reads `rig.toml`; `campaign` says which factors its formulas may name.
    ///
    /// # Errors
    /// File, line and remedy.
    pub fn read(path: &Path, campaign: &Campaign) -> Result<Self, StudyError> {
        Self::parse(&Source::read(path)?, campaign)
    }

    pub(crate) fn parse(source: &Source, campaign: &Campaign) -> Result<Self, StudyError> {
        let file: File = source.toml()?;
        let file = match file.oscilos() {
            Some(name) => {
                let folder = Path::new(&source.file).with_file_name(name);
                file.beside(oscilos::read(&folder)?)
            }
            None => file,
        };
        let outcome: Outcome<Self> = rig(file, campaign, source);
        source.located(outcome)
    }
}
