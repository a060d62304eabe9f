//! What can be asked of a study: what every question says, and the keys that its kind adds. Whoever answers a
//! kind reads its keys.

use super::Plan;
use super::ids::{known_stage, short_id};
use crate::source::{Source, listed};
use crate::{Campaign, Catalogue, StudyError, StudyProblem};
use rijke_numerics::words::of_toml;
use serde::Deserialize;
use serde::de::{DeserializeOwned, Deserializer, Error, Visitor, value};
use std::collections::BTreeMap;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// A question, and what it is asked of.
#[derive(Clone, Debug)]
pub struct Question {
    /// Name of the answer.
    pub id: String,
    /// What it is called.
    pub title: String,
    /// The stage that it is asked of.
    pub stage: String,
    /// The factor along the axis, by its place in the campaign; the one with the most values if absent.
    pub over: Option<usize>,
    /// The factor that tells series apart; `row`s of the campaign if absent.
    pub series: Option<usize>,
    /// The kind of question, as `ask` names it.
    pub kind: String,
    /// Roles and candidates that its key `with` names, which has one meaning in questions of every kind.
    pub(super) with: BTreeMap<String, String>,
    /// The file, the number of the question in it, and where it begins.
    file: Option<(Arc<Source>, usize, usize)>,
}

/// The keys that every question has.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Common {
    id: String,
    title: Option<String>,
    ask: String,
    stage: String,
    over: Option<String>,
    series: Option<String>,
}

impl Question {
    /// A question without keys that stands in no file.
    #[must_use]
    pub fn of_stage(kind: &str, stage: &str, title: &str) -> Self {
        Self {
            id: stage.to_owned(),
            title: title.to_owned(),
            stage: stage.to_owned(),
            over: None,
            series: None,
            kind: kind.to_owned(),
            with: BTreeMap::new(),
            file: None,
        }
    }

    /// The keys that its kind adds: the fields of `K`.
    ///
    /// # Errors
    /// File and line of a key that is no field, with the known ones, and of a value of another type.
    pub fn keys<K: DeserializeOwned>(&self) -> Result<K, StudyError> {
        let known = fields_of::<K>();
        let (mut keys, mut span) = (DeTable::new(), 0..0);
        if let Some((source, k, _)) = &self.file
            && let Some(asked) = asked(source)?.into_iter().nth(*k)
        {
            span = asked.span();
            let all = if let DeValue::Table(table) = asked.into_inner() { table } else { DeTable::new() };
            let common = fields_of::<Common>();
            keys.extend(all.into_iter().filter(|(key, _)| !common.contains(&&**key.get_ref())));
        }
        if let Some(key) = keys.keys().find(|key| !known.contains(&&**key.get_ref())) {
            let name = format!("{}` of `ask = \"{}\"", key.get_ref(), self.kind);
            let problem = StudyProblem::Unknown { what: "key", name, known: listed(known.iter().copied()) };
            return Err(self.fail_at(key.span().start, problem));
        }
        read(Spanned::new(span, DeValue::Table(keys))).map_err(|(at, said)| self.fail_at(at, said))
    }

    /// A fault of the question, with its file and line.
    #[must_use]
    pub fn fail(&self, problem: StudyProblem) -> StudyError {
        self.fail_at(self.file.as_ref().map_or(0, |(_, _, at)| *at), problem)
    }

    fn fail_at(&self, at: usize, problem: StudyProblem) -> StudyError {
        match &self.file {
            Some((source, ..)) => source.fail(at, problem),
            None => StudyError { file: self.id.clone(), line: None, problem: Box::new(problem) },
        }
    }
}

impl Plan {
    /// Reads the questions of a file, every name checked that questions of all kinds have.
    pub(super) fn ask(
        &mut self,
        source: &Source,
        campaign: &Campaign,
        catalogue: &Catalogue,
    ) -> Result<(), StudyError> {
        let shared = Arc::new(source.clone());
        for (k, asked) in asked(source)?.into_iter().enumerate() {
            let at = asked.span().start;
            let fail = |problem| source.fail(at, problem);
            let with =
                asked.get_ref().get("with").and_then(|with| with.get_ref().as_table()).into_iter().flatten();
            let with = with.filter_map(|(role, id)| {
                Some((role.get_ref().to_string(), id.get_ref().as_str()?.to_owned()))
            });
            let with: BTreeMap<String, String> = with.collect();
            let common: Common = read(asked).map_err(|(at, said)| source.fail(at, said))?;
            let factor = |name: Option<String>| name.map(|n| campaign.known_factor(&n)).transpose();
            let question = Question {
                title: common.title.unwrap_or_else(|| common.id.clone()),
                id: common.id,
                stage: common.stage,
                over: factor(common.over).map_err(fail)?,
                series: factor(common.series).map_err(fail)?,
                kind: common.ask,
                with,
                file: Some((shared.clone(), k, at)),
            };
            self.suits(&question).map_err(fail)?;
            let known = |(role, id): (&String, &String)| catalogue.of_role(role, id).map(|_| ());
            question.with.iter().try_for_each(known).map_err(fail)?;
            self.questions.push(question);
        }
        Ok(())
    }

    /// Whether a question has a name that is free, and is asked of a stage that is there.
    fn suits(&self, question: &Question) -> Result<(), StudyProblem> {
        let name = question.id.clone();
        short_id(&name)?;
        if question.stage.is_empty() {
            let need = "name the stage that is asked: stage = \"heat\"";
            return Err(StudyProblem::Missing { key: "stage".into(), need });
        }
        known_stage(self, "stage", &question.stage)?;
        if self.answers().any(|id| *id == name) {
            return Err(StudyProblem::Duplicate { what: "stage, question or map", name });
        }
        Ok(())
    }
}

/// Every `[[ask]]` of a file, each where it stands.
fn asked(source: &Source) -> Result<Vec<Spanned<DeValue<'_>>>, StudyError> {
    let mut root = DeTable::parse(&source.text).map_err(|error| source.wrong(&error))?.into_inner();
    Ok(match root.remove("ask").map(Spanned::into_inner) {
        Some(DeValue::Array(all)) => all.into_iter().collect(),
        _ => Vec::new(),
    })
}

/// A value, or where it is wrong and how.
fn read<T: DeserializeOwned>(value: Spanned<DeValue<'_>>) -> Result<T, (usize, StudyProblem)> {
    let start = value.span().start;
    T::deserialize(ValueDeserializer::from(value)).map_err(|error| {
        let at = error.span().map_or(start, |span| span.start);
        (at, StudyProblem::Toml(of_toml(error.message())))
    })
}

/// The keys that a structure is read from: the names of its fields.
#[must_use]
pub fn fields_of<T: DeserializeOwned>() -> &'static [&'static str] {
    struct Fields<'a>(&'a mut &'static [&'static str]);
    impl<'de> Deserializer<'de> for Fields<'_> {
        type Error = value::Error;
        fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Self::Error> {
            Err(value::Error::custom("only the names of fields are wanted"))
        }
        fn deserialize_struct<V: Visitor<'de>>(
            self,
            _: &'static str,
            fields: &'static [&'static str],
            visitor: V,
        ) -> Result<V::Value, Self::Error> {
            *self.0 = fields;
            self.deserialize_any(visitor)
        }
        serde::forward_to_deserialize_any! {
            bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct
            newtype_struct seq tuple tuple_struct map enum identifier ignored_any
        }
    }
    let mut fields: &'static [&'static str] = &[];
    let asked = T::deserialize(Fields(&mut fields));
    debug_assert!(asked.is_err(), "a structure without a field is read from nothing");
    fields
}
