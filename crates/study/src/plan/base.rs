//! How study.toml states the base of a study.

use super::{Base, HeatedFlow, MeasuredGas, Selection};
use serde::Deserialize;

impl<'de> Deserialize<'de> for Base {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(rename_all = "kebab-case")]
        enum Table {
            States(StatesFile),
            HeatedFlow(HeatedFlow),
            Measured(MeasuredGas),
        }
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct StatesFile {
            points: Selection,
        }
        let fail = |text: String| {
            serde::de::Error::custom(format!(
                "{text}; give base = \"ambient\", \"rig\" or \"states\", or a table [base.states], [base.heated-flow] or [base.measured]"
            ))
        };
        match toml::Value::deserialize(from)? {
            toml::Value::String(text) => match text.as_str() {
                "ambient" => Ok(Self::Ambient),
                "rig" => Ok(Self::Rig),
                "states" => Ok(Self::States(Selection::default())),
                other => Err(fail(format!("there is no base state `{other}`"))),
            },
            value => match value.try_into::<Table>() {
                Ok(Table::States(file)) => Ok(Self::States(file.points)),
                Ok(Table::HeatedFlow(heated)) => Ok(Self::HeatedFlow(heated)),
                Ok(Table::Measured(measured)) => Ok(Self::Measured(measured)),
                Err(error) => Err(fail(error.message().to_owned())),
            },
        }
    }
}
