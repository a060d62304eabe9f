//! The numbers of a picture of a click: to be drawn, not to be computed with.

/// All channels of an impulse as the fit sees them ([`crate::picture_click`]): in phase, at the rate that the
/// band needs, dispersion undone, less their background, over their gains. Points are `[t, p]`, t in s from
/// the arrival.
#[derive(Clone, Debug)]
pub struct ClickPicture {
    /// The channels; where the reflection overlaps the impulse, both.
    pub channels: Vec<Vec<[f64; 2]>>,
    /// The impulse that was fitted.
    pub impulse: Vec<[f64; 2]>,
    /// The channels less impulse and reflection as fitted.
    pub left: Vec<Vec<[f64; 2]>>,
}
