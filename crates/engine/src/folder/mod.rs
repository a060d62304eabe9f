//! The folder of a study from step to step: opened and doubted, ranked into `results`, read again. What each
//! step says while it works goes to a [`Tell`](rijke_numerics::Tell), what stops it is a
//! [`Failed`](rijke_numerics::Failed) with file and remedy. Knows no records, no figure and no page.

mod case;
mod check_responses;
mod condition;
mod forecasts;
mod infer;
mod modes;
mod rank;
mod response_forecasts;
mod responses;
mod results;
mod study;

pub use case::ModeCase;
pub use check_responses::check_responses;
pub use condition::{condition, frequencies, grid};
pub use forecasts::{Forecasts, forecast_csv, how_many, surroundings};
pub use infer::{InferredNetwork, infer_networks};
pub use modes::{ByNoise, FoundModes, ModeLine};
pub use rank::{Foresee, RankOptions, rank};
pub use response_forecasts::RankedResponses;
pub use responses::{ResponseData, ResponseResults, rank_responses};
pub use results::{Ranked, Results, kept, known_stage, rival_of, warn_of_ranking};
pub use study::{
    FILES_NAMED, doubts_of, is_measured, observations, of_modes, of_the_engine, open_study, warn_of_copies,
    warn_of_left_out, warn_of_records, warn_of_study, without_responses,
};
