//! The stages of a study and its questions: numbers, never drawings.
//!
//! Knows studies and models of any rig. Knows no part of a rig by name, no file of results and no drawing.

mod ahead;
mod answerable;
mod answers;
mod apart;
mod asked;
mod assumed;
mod average;
mod begin;
mod behind;
mod beyond;
mod checks;
mod claims;
mod combined;
mod compete;
mod course;
mod doubts;
mod earlier;
mod elsewhere;
mod far;
mod followed;
mod foresight;
mod found;
mod frame;
mod handed;
mod inputs;
mod lengths;
mod matching;
mod maxima;
mod meant;
mod meters;
mod missing;
mod miswired;
mod moved_since;
mod next;
mod once;
mod other_columns;
mod parameter;
mod predicted;
mod ready;
mod recognised;
mod record;
mod relabelled;
mod rows;
mod search;
mod shapes;
mod signs;
mod sliders;
mod so_far;
mod stages;
mod written;

pub use answerable::answerable;
pub use answers::{
    Answer, AnswerPanel, Layer, LayerLook, MapNodes, gains_along, keys_of_questions, left_out_table, open,
    residuals_over_factors, stability, symbol,
};
pub use asked::{Unpredicted, forecast, modes_at};
pub use average::{OpenModel, at_other_maxima};
pub(crate) use behind::behind_by_a_prior;
pub use beyond::{Beyond, beyond};
pub use checks::Datum;
pub use claims::{Judgement, agreement, models, verdicts};
pub use course::{Chosen, Run, Trusted};
pub use elsewhere::{AskedPoint, nearest, over_map, with_points};
pub use foresight::{Foreseen, StageForesight, foresight};
pub use found::{
    Asked, Checks, ExactLengths, Family, LengthError, Missing, MovingLength, PointCheck, SumCheck,
};
pub use frame::{Frame, FrameColumn, FrameRow, ShownUnit};
pub(crate) use inputs::{conditions_at, conditions_of, with_factors_moved};
pub use next::{
    Aim, Lead, Leads, MicrophoneChoice, MicrophoneTable, Next, Sequence, Step, Suggestion, Wish, microphones,
    next,
};
pub use parameter::TrainedParameter;
pub use predicted::{Averaged, Forecast};
pub use recognised::recognised;
pub use record::{CarriedOn, CarriedStage, EvidenceRecord, MeasuredRecord, ModelRecord, StageRecord};
pub use search::{
    Combination, GivenUp, GreedyChoice, RoleChoice, Search, SearchNode, SearchOptions, SearchPart,
    SearchRecord, merge_searches,
};
pub use sliders::{SliderAxis, SliderMode, SliderNode, SliderParameter, Sliders, sliders};
pub use so_far::{Leading, so_far};
