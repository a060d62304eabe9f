//! Parameters of which the data tell nothing.

use super::select::Selected;
use crate::run::TrainedParameter;
use rijke_study::responses::ResponseKind;

/// Of which parameters the data tell nothing, in a sentence; none if they tell of all.
pub(super) fn untold(parameters: &[TrainedParameter], data: &Selected) -> Option<String> {
    let untold: Vec<&str> = parameters.iter().filter(|p| p.is_as_before()).map(|p| p.name.as_str()).collect();
    if untold.is_empty() {
        return None;
    }
    let both =
        |what: &ResponseKind| matches!(what, ResponseKind::Pressure { sources, .. } if sources.len() > 1);
    let hint = if data.whats.iter().any(both) {
        "; waves of unknown strength enter at both ends, so these data do not determine what the ends reflect: if only one end drives, write \
         sources = [\"upstream\"]"
    } else {
        ""
    };
    Some(format!("not identified by these data, as their priors: {}{hint}", untold.join(", ")))
}
