//! Which column of a file is which microphone, in which unit, and which is time.

use super::layout::Layout;
use crate::column_fault::ColumnFault;
use crate::formats::headings::{is_named, named};
use crate::problem::Problem;
use crate::records::reading::{Column, Reading};
use crate::units::{Heading, Unit};

/// One microphone's column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Take {
    pub(crate) column: usize,
    pub(crate) microphone: usize,
    /// Pa per number of the file.
    pub(crate) scale: f64,
    /// Largest pressure that the column can hold, Pa; infinite for floats.
    limit: f64,
}

/// What is taken from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Plan {
    pub(crate) takes: Vec<Take>,
    /// Column of time and its unit.
    pub(crate) time: Option<(usize, Unit)>,
}

/// What the numbers of a file are, where it does not say so itself.
#[derive(Clone, Copy)]
pub(crate) enum Numbers {
    /// Floats and text.
    AsWritten,
    /// Integers, of which the largest is full scale: the steps to there, and full scale in Pa or V.
    Steps(f64, f64),
}

impl Numbers {
    /// Integers if there is a largest one.
    pub(crate) fn of(largest: Option<f64>, full_scale: f64) -> Self {
        largest.map_or(Self::AsWritten, |steps| Self::Steps(steps, full_scale))
    }
}

/// Headings that say that a column is time, in lower case, beside `t`; `T` may be a temperature.
const TIMES: [&str; 6] = ["time", "x_value", "zeit", "temps", "tijd", "tempo"];

/// A place in the file, and what is wrong there.
pub(crate) type Wrong = (String, Problem);

impl Plan {
    /// Resolves what the manifest says against the columns of a file. `headings` are empty if the file has
    /// none; `width` is the number of columns.
    ///
    /// # Errors
    /// Columns that are listed and not there, or there and not listed; a unit that is neither of pressure nor
    /// of voltage; a voltage without sensitivity.
    pub(crate) fn of(
        layout: Layout<'_>,
        headings: &[String],
        width: usize,
        numbers: impl Fn(usize) -> Numbers,
    ) -> Result<Self, Wrong> {
        let reading = layout.reading;
        let time = time_column(reading, headings, width)?;
        let microphones = if reading.names.is_empty() {
            let all = by_place(layout.channels, time, headings, width)?;
            agree(&all, headings, reading)?;
            all
        } else {
            by_name(reading, time, headings)?
        };
        let mut takes = Vec::new();
        for (column, microphone) in microphones.into_iter().enumerate() {
            let Some(microphone) = microphone.filter(|m| !reading.dead.contains(m)) else { continue };
            // A column listed by the whole of its heading may have anything in brackets.
            let heading =
                headings.get(column).filter(|h| !reading.names.contains_key(*h) || Heading::parse(h).is_ok());
            let scale = reading.scale(microphone, heading.map(String::as_str), numbers(column));
            let (scale, limit) = scale.map_err(|problem| {
                let name = headings.get(column).map_or(String::new(), |h| format!(" `{h}`"));
                (format!("column {}{name}", column + 1), problem)
            })?;
            takes.push(Take { column, microphone, scale, limit });
        }
        let time = time.map(|column| {
            let unit = headings.get(column).and_then(|h| Heading::parse(h).ok()).and_then(|h| h.unit);
            let unit = unit.map_or_else(|| Unit::parse("s"), |unit| unit.of("s"));
            unit.map(|unit| (column, unit)).map_err(|e| (format!("column {}", column + 1), Problem::Unit(e)))
        });
        Ok(Self { takes, time: time.transpose()? })
    }

    /// All columns as they are.
    pub(crate) fn whole(width: usize, scale: f64) -> Self {
        let take = |column| Take { column, microphone: column, scale, limit: f64::INFINITY };
        Self { takes: (0..width).map(take).collect(), time: None }
    }

    /// For each column whether it is read.
    pub(crate) fn wanted(&self, width: usize) -> Vec<bool> {
        let mut wanted = vec![false; width];
        let time = self.time.iter().map(|t| t.0);
        self.takes.iter().map(|t| t.column).chain(time).for_each(|column| wanted[column] = true);
        wanted
    }

    /// The pressure at which every channel is at its limit, Pa; infinite if they differ or have none.
    pub(crate) fn full_scale(&self) -> f64 {
        let first = self.takes.first().map_or(f64::INFINITY, |take| take.limit);
        if self.takes.iter().all(|take| take.limit == first) { first } else { f64::INFINITY }
    }
}

impl Reading {
    /// Whether a column of this name is listed.
    pub(crate) fn lists(&self, heading: &str) -> bool {
        self.names.keys().any(|name| is_named(heading, name))
    }

    /// Pa per number of a column, and the largest pressure in it.
    fn scale(
        &self,
        microphone: usize,
        heading: Option<&str>,
        numbers: Numbers,
    ) -> Result<(f64, f64), Problem> {
        let stated = self.sensitivities.get(microphone).copied();
        let stay = |factor: f64| self.volts_stay.then_some(factor);
        let volts = |factor: f64| {
            stated.map(|s| factor / s).or_else(|| stay(factor)).ok_or(Problem::NoSensitivity { microphone })
        };
        if let Numbers::Steps(steps, full_scale) = numbers {
            let limit = if self.full_scale_in_volts { volts(full_scale)? } else { full_scale };
            return Ok((limit / steps, limit));
        }
        Ok((self.scale_of_floats(heading, stated, volts)?, f64::INFINITY))
    }

    fn scale_of_floats(
        &self,
        heading: Option<&str>,
        stated: Option<f64>,
        volts: impl Fn(f64) -> Result<f64, Problem>,
    ) -> Result<f64, Problem> {
        let heading =
            heading.filter(|h| !h.is_empty()).map(Heading::parse).transpose().map_err(Problem::Unit)?;
        match heading.and_then(|h| h.unit).or_else(|| self.unit.clone()) {
            Some(unit) => match unit.of("V") {
                Ok(unit) => volts(unit.factor()),
                Err(_) => unit.of("Pa").map(|unit| unit.factor()).map_err(Problem::Unit),
            },
            None if stated.is_some() => Err(Problem::NoUnit),
            None => Ok(1.0),
        }
    }
}

/// The column of time, declared or recognised.
pub(crate) fn time_column(
    reading: &Reading,
    headings: &[String],
    width: usize,
) -> Result<Option<usize>, Wrong> {
    match &reading.time {
        Some(Column::Number(number)) if (1..=width).contains(number) => return Ok(Some(number - 1)),
        Some(Column::Number(number)) => {
            return Err(("time".into(), Problem::NoSuchColumn { number: *number, width }));
        }
        Some(Column::Name(name)) => return named(headings, name).map(Some).map_err(|p| ("time".into(), p)),
        None => {}
    }
    let is_time = |h: &String| {
        let heading = Heading::parse(h);
        // TDMS marks the time so that it made itself.
        let name = heading.as_ref().map_or(h.as_str(), |h| h.name.as_str()).trim_end_matches('*').to_owned();
        let says = name == "t" || TIMES.contains(&&*name.to_lowercase());
        let unit = heading.ok().and_then(|h| h.unit);
        unit.map_or(says, |unit| unit.of("s").is_ok())
    };
    let mut found =
        headings.iter().enumerate().filter(|(_, h)| !reading.lists(h) && is_time(h)).map(|(k, _)| k);
    match (found.next(), found.next()) {
        (Some(first), Some(second)) => {
            let known = vec![headings[first].clone(), headings[second].clone()];
            Err(("header".into(), Problem::TwoTimes { known }))
        }
        (found, _) => Ok(found),
    }
}

type Microphones = Vec<Option<usize>>;

/// The list speaks of all columns, or of all but that of time.
fn by_place(
    list: &[Option<usize>],
    time: Option<usize>,
    headings: &[String],
    width: usize,
) -> Result<Microphones, Wrong> {
    let others = width - time.map_or(0, |_| 1);
    if list.len() == width {
        if let Some(column) = time
            && let Some(microphone) = list[column]
        {
            return Err((format!("column {}", column + 1), Problem::TimeIsMicrophone { microphone }));
        }
        return Ok(list.to_vec());
    }
    if list.len() == others {
        let mut all = list.to_vec();
        all.insert(time.unwrap_or(0).min(all.len()), None);
        return Ok(all);
    }
    let (have, need) = (others, list.len());
    if have < need {
        return Err(("header".into(), Problem::MissingChannel { have, need }));
    }
    let is_nameless = |k: &usize| headings.get(*k).is_some_and(String::is_empty);
    let nameless: Vec<usize> = (0..width).filter(|k| Some(*k) != time && is_nameless(k)).collect();
    let surplus = match nameless.len() == have - need {
        // Of columns with names and one without, that one is not a microphone.
        true => nameless,
        false => (0..width).filter(|k| Some(*k) != time).skip(need).collect(),
    };
    let name = |k: usize| match headings.get(k).map(String::as_str) {
        None => format!("{}", k + 1),
        Some("") => format!("{} without a name (of time, it needs one, such as `t [s]`)", k + 1),
        Some(name) => format!("{} `{name}`", k + 1),
    };
    let surplus = surplus.into_iter().map(name).collect();
    Err(("header".into(), Problem::SurplusChannels { have, need, surplus }))
}

/// No column listed by its place has the name of another microphone.
fn agree(microphones: &[Option<usize>], headings: &[String], reading: &Reading) -> Result<(), Wrong> {
    for (column, (microphone, heading)) in microphones.iter().zip(headings).enumerate() {
        let named = reading.microphones.iter().position(|name| is_named(heading, name));
        if let (Some(listed), Some(named)) = (*microphone, named)
            && listed != named
        {
            let name = reading.microphones[named].clone();
            let fault = ColumnFault::OtherMicrophone { name, named, listed };
            return Err((format!("column {}", column + 1), fault.into()));
        }
    }
    Ok(())
}

/// Every column has a name in the list, and every name of the list a column.
fn by_name(reading: &Reading, time: Option<usize>, headings: &[String]) -> Result<Microphones, Wrong> {
    if headings.is_empty() {
        return Err((
            "header".into(),
            match reading.text.header_lines {
                Some(lines) if lines > 0 => ColumnFault::NamesPassedOver { lines }.into(),
                _ => ColumnFault::NoNames.into(),
            },
        ));
    }
    let mut all = vec![None; headings.len()];
    let mut seen = vec![false; headings.len()];
    for (name, microphone) in &reading.names {
        // A microphone that is dead may be missing.
        let column = match named(headings, name) {
            Err(_) if microphone.is_none_or(|m| reading.dead.contains(&m)) => continue,
            found => found.map_err(|problem| ("channels".into(), problem))?,
        };
        if Some(column) == time
            && let Some(microphone) = *microphone
        {
            return Err((format!("column {}", column + 1), Problem::TimeIsMicrophone { microphone }));
        }
        (all[column], seen[column]) = (*microphone, true);
    }
    let surplus = (0..headings.len()).filter(|k| !seen[*k] && Some(*k) != time);
    let surplus: Vec<String> = surplus.map(|k| format!("{} `{}`", k + 1, headings[k])).collect();
    if surplus.is_empty() {
        return Ok(all);
    }
    let (have, need) = (headings.len(), headings.len() - surplus.len());
    Err(("header".into(), Problem::SurplusChannels { have, need, surplus }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::text::TextForm;

    #[test]
    fn message_columns_that_contradict_the_manifest() {
        let named = |text: &str| text.split(',').map(str::to_owned).collect::<Vec<String>>();
        // A column of time without a name.
        let list = [Some(0), Some(1)];
        let said = by_place(&list, None, &named(",p1,p2"), 3).unwrap_err().1.to_string();
        assert!(said.contains("surplus: 1 without a name") && !said.contains("p2"), "{said}");
        // Names of other microphones than the list says.
        let reading = Reading { microphones: named("p1,p2"), ..Reading::default() };
        let said = agree(&list, &named("p2,p1"), &reading).unwrap_err().1.to_string();
        assert!(said.contains("`p2`, which is microphone 1") && said.contains("as microphone 0"), "{said}");
        assert_eq!(agree(&list, &named("p1 [Pa],p2 [Pa]"), &reading), Ok(()));
        assert_eq!(agree(&[None, Some(1)], &named("p1,other"), &reading), Ok(()));
        // The line of names is passed over.
        let text = TextForm { header_lines: Some(2), ..TextForm::default() };
        let said = by_name(&Reading { text, ..Reading::default() }, None, &[]).unwrap_err().1.to_string();
        assert!(said.contains("2 lines that `header_lines` passes over"), "{said}");
    }
}
