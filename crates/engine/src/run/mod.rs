//! The stages of a study and its questions: numbers, never drawings.
//!
//! Knows studies and models of any rig. Knows no part of a rig by name, no file of results and no drawing.

mod answerable;
mod answers;
mod begin;
mod checks;
mod claims;
mod combined;
mod course;
mod foresight;
mod found;
mod frame;
mod lengths;
mod missing;
mod next;
mod parameter;
mod points;
mod record;
mod search;
mod sliders;
mod so_far;
mod stages;
mod suspects;

pub use answerable::answerable;
pub use answers::{
    Answer, AnswerPanel, Layer, LayerLook, MapNodes, gains_along, keys_of_questions, left_out_table, open,
    residuals_over_factors, stability, symbol,
};
pub use checks::Datum;
pub use claims::{Judgement, agreement, models, verdicts};
pub use course::{Chosen, Run, Trusted};
pub use foresight::{Foreseen, StageForesight, foresight};
pub use found::{
    Asked, Checks, ExactLengths, Family, LengthError, Missing, MovingLength, PointCheck, SumCheck,
};
pub use frame::{Frame, FrameColumn, FrameRow, ShownUnit};
pub use next::{
    Aim, Lead, Leads, MicrophoneChoice, MicrophoneTable, Next, Sequence, Step, Suggestion, Wish, microphones,
    next,
};
pub use parameter::TrainedParameter;
pub use points::asked::{Unpredicted, forecast, modes_at};
pub use points::beyond::{Beyond, beyond};
pub use points::elsewhere::{AskedPoint, nearest, over_map, with_points};
pub(crate) use points::inputs::{conditions_at, conditions_of, with_factors_moved};
pub use points::predicted::{Averaged, Forecast};
pub(crate) use record::add_lines;
pub use record::{CarriedOn, CarriedStage, EvidenceRecord, MeasuredRecord, ModelRecord, StageRecord};
pub use search::{
    Combination, GivenUp, GreedyChoice, RoleChoice, Search, SearchNode, SearchOptions, SearchPart,
    SearchRecord, merge_searches,
};
pub use sliders::{SliderAxis, SliderMode, SliderNode, SliderParameter, Sliders, sliders};
pub use so_far::{Leading, so_far};
pub use stages::average::{OpenModel, at_other_maxima};
pub(crate) use suspects::behind::behind_by_a_prior;
pub use suspects::recognised::recognised;
