//! Maps of stability: the grid that an option names, and the maps that a study asks for.

use crate::failure::Failure;
use crate::flow::foresee;
use crate::ui::Ui;
use rijke_engine::SavedModel;
use rijke_engine::run::{Answer, AskedPoint, OpenModel, forecast, over_map, stability, with_points};
use rijke_study::plan::{MapGrid, MapQuestion, Selection};
use rijke_study::{ObservedModes, Study};

/// `x_g,Q`, or `x_g=0.1:0.6,Q=0:80` with the ends of ranges; those of the points that `among` means, where
/// they are left out.
pub(crate) fn parsed(text: &str, study: &Study, among: &Selection) -> Result<MapGrid, Failure> {
    let known = study.campaign.factors.iter().map(|f| f.name.as_str()).collect::<Vec<_>>().join(", ");
    let bad = |what: String| {
        Failure::bad_input(format!("--map {text}: {what}"))
            .remedy(format!("Give two of: {known}; with a range as --map x=0.1:0.6,y=0:80, in SI units."))
    };
    let both: Vec<&str> = text.split(',').collect();
    let [x, y] = both[..] else { return Err(bad("takes two factors with a comma between".into())) };
    let over = |k: usize| {
        let points = study.campaign.points.iter().filter(|p| among.holds(&study.campaign, p));
        let values = points.map(|p| p.factors[k]).filter(|v| v.is_finite());
        let ends = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
        Some(ends).filter(|[low, high]| low < high)
    };
    let axis = |text: &str| {
        let (name, range) = text.split_once('=').map_or((text, None), |(name, range)| (name, Some(range)));
        let name = name.trim();
        let k = study.campaign.factor(name).ok_or_else(|| bad(format!("there is no factor `{name}`")))?;
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
        let ends = range.map(|range| {
            let ends = range.split_once(':').and_then(|(low, high)| Some([number(low)?, number(high)?]));
            ends.ok_or_else(|| bad(format!("`{range}` is no range, two numbers with a colon between")))
        });
        Ok::<_, Failure>((k, ends.transpose()?.or_else(|| over(k))))
    };
    let (x, y) = (axis(x)?, axis(y)?);
    MapGrid::new(&study.campaign, [x.0, y.0], [x.1, y.1]).map_err(|problem| bad(problem.to_string()))
}

/// The map that a study asks for, by the model of its stage and those that are open beside it.
pub(crate) fn answered(
    study: &Study,
    observed: &ObservedModes,
    asked: &MapQuestion,
    model: &SavedModel,
    open: &[OpenModel],
    ui: &Ui,
) -> Result<Answer, Failure> {
    let wrong = |e: rijke_engine::EngineError| crate::study::of_the_engine(&e, &study.folder);
    let all = rijke_study::plan::Selection::default();
    let among = study.plan.stage(&asked.stage).map_or(&all, |(_, stage)| &stage.points);
    let points = over_map(study, among, &asked.grid, &AskedPoint::default()).map_err(wrong)?;
    let (mut wider, places) = with_points(study, among, &points).map_err(wrong)?;
    foresee(&mut wider, &places, ui)?;
    let (found, mut left_out) = forecast(&wider, observed, model, open, &places).map_err(wrong)?;
    if found.is_empty() && !left_out.is_empty() {
        return Err(wrong(left_out.swap_remove(0).why));
    }
    Ok(stability(&wider, asked, &places, &found, model).0)
}
