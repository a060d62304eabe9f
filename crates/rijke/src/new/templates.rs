//! The files of each template.

/// The kind of rig that is nearest to yours.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Template {
    /// Vertical tube, open at both ends, heated electrically within; the flow is driven by buoyancy and
    /// inferred from clicks.
    HeatedTube,
    /// Tube closed below, with an electrically heated gauze; forced flow, thermometers.
    QuarterWave,
    /// Duct with a flame whose transfer function is sought; forced flow, thermometers.
    Burner,
    /// Tube of gas at rest with a loudspeaker and a sample of unknown reflection.
    KundtTube,
}

/// Names and texts.
type Files = &'static [(&'static str, &'static str)];

impl Template {
    /// The files that are written as they are.
    pub(super) fn files(self) -> Files {
        match self {
            Self::HeatedTube => HEATED_TUBE,
            Self::QuarterWave => QUARTER_WAVE,
            Self::Burner => BURNER,
            Self::KundtTube => KUNDT_TUBE,
        }
    }
}

/// Files of one folder below this one, each under its own name.
macro_rules! files {
    ($folder:literal: $($name:literal)*) => {
        &[$(($name, include_str!(concat!($folder, "/", $name)))),*]
    };
}

/// The head of the manifest; the operating points follow.
pub(super) const HEATED_TUBE_MANIFEST: &str = include_str!("heated-tube/draft/records/manifest.toml");

const HEATED_TUBE: Files = files! { "heated-tube":
    "rig.toml" "campaign.csv" "study.toml" "candidates/heat-release.toml" "candidates/hot-body.toml"
    "candidates/rods.toml" "candidates/tube.toml" "draft/records/tube.toml"
};

const QUARTER_WAVE: Files = files! { "quarter-wave":
    "rig.toml" "campaign.csv" "study.toml" "candidates/gauze.toml" "candidates/tube.toml"
    "draft/observations/modes.csv" "draft/observations/observations.toml"
    "draft/observations/readings.csv" "draft/records/manifest.toml"
};

const BURNER: Files = files! { "burner":
    "rig.toml" "campaign.csv" "study.toml" "candidates/cold.toml" "candidates/flame.toml"
    "draft/observations/modes.csv" "draft/observations/observations.toml"
    "draft/observations/readings.csv" "draft/records/manifest.toml"
};

const KUNDT_TUBE: Files = files! { "kundt-tube":
    "rig.toml" "campaign.csv" "study.toml" "candidates/sample.toml" "candidates/tube.toml"
    "draft/observations/modes.csv" "draft/observations/observations.toml" "draft/records/manifest.toml"
};
