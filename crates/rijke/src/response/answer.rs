//! A network of either kind, driven.

use crate::failure::{Classify, Failure};
use rijke_network::file::{Built, read};
use rijke_network::{Forced, NetworkError, Source, Workspace};
use rijke_numerics::{C64, Order};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// What is asked of a network.
pub(super) enum Quantity {
    /// Impedance and reflection at a place.
    Port(String),
    /// Pressure at the second place over that at the first.
    Transfer([String; 2]),
    /// Scattering matrix between two places.
    Scattering([String; 2]),
}

/// A network from a file.
pub(super) struct Driven {
    pub(super) title: Option<String>,
    pub(super) warnings: Vec<String>,
    /// Highest frequency of the file's search, Hz.
    pub(super) highest_hz: f64,
    path: PathBuf,
    built: Built,
}

/// Names and values of the columns of an answer.
type Columns = Vec<(String, Vec<C64>)>;

impl Driven {
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let text = rijke_numerics::read_text(path).or_bad_input().map_err(|failure| {
            failure.at(path).remedy("Name a network file; fixtures/networks holds examples.")
        })?;
        let built = read(&text).or_bad_input().map_err(|failure| failure.at(path))?;
        Ok(Self {
            title: built.name.clone(),
            warnings: built.warnings.iter().map(ToString::to_string).collect(),
            highest_hz: built.region.omega[1] / (2.0 * PI),
            path: path.to_owned(),
            built,
        })
    }

    pub(super) fn answer(&self, quantity: &Quantity, frequencies: &[f64]) -> Result<Columns, Failure> {
        let (names, places) = match quantity {
            Quantity::Port(name) => {
                let place = self.place(name)?;
                (vec![format!("Z/(rho c) at {name}"), format!("R at {name}")], [place; 2])
            }
            Quantity::Transfer([from, to]) => {
                (vec![format!("p({to})/p({from})")], [self.place(from)?, self.place(to)?])
            }
            Quantity::Scattering([from, to]) => {
                let ends = self.ascending(from, to)?;
                let kinds = ["R from", "T from", "T from", "R from"];
                let sides = [from, to, from, to];
                (kinds.iter().zip(sides).map(|(k, s)| format!("{k} {s}")).collect(), ends)
            }
        };
        let mut columns: Columns = names.into_iter().map(|name| (name, Vec::new())).collect();
        for f in frequencies {
            let s = C64::new(0.0, 2.0 * PI * f);
            let values = self.at(quantity, places, s).or_bad_input().map_err(|failure| {
                failure.at(&self.path).remedy("Change the element named, or the frequencies.")
            })?;
            for ((_, column), value) in columns.iter_mut().zip(values) {
                column.push(value);
            }
        }
        Ok(columns)
    }

    fn at(&self, quantity: &Quantity, [from, to]: [usize; 2], s: C64) -> Result<Vec<C64>, NetworkError> {
        let (network, laws) = (&self.built.network, &self.built.laws);
        let mut work = Workspace::default();
        let value = Order::Value;
        match (quantity, &self.built.flow) {
            (Quantity::Port(_), None) => {
                let r = network.reflection_at(laws, s, from, value, &mut work)?.value();
                Ok(vec![(1.0 + r) / (1.0 - r), r])
            }
            (Quantity::Port(_), Some(flow)) => {
                let t = flow.transfer(s, &[], value)?;
                let z = flow.impedance(s, &[], value)?.value() / t.impedances[0].value();
                Ok(vec![z, (z - 1.0) / (z + 1.0)])
            }
            (Quantity::Transfer(_), flow) => {
                let forced: Forced = match flow {
                    None => network.forced(laws, s, Source::Upstream, value, &mut work)?,
                    Some(flow) => flow.forced(s, Source::Upstream, &[], value)?,
                };
                Ok(vec![forced.before[to][0].value() / forced.before[from][0].value()])
            }
            (Quantity::Scattering(_), flow) => {
                let transfer = match flow {
                    None => network.transfer(laws, s, [from, to], value, &mut work)?,
                    Some(flow) => flow.transfer(s, &[], value)?,
                };
                let [[r, t_back], [t, r_back]] = transfer.scattering();
                Ok([r, t_back, t, r_back].iter().map(rijke_numerics::Jet::value).collect())
            }
        }
    }

    /// Two places, which must follow each other downstream.
    fn ascending(&self, from: &str, to: &str) -> Result<[usize; 2], Failure> {
        let places = [self.place(from)?, self.place(to)?];
        let last = self.built.network.segments().len();
        if places[0] >= places[1] {
            return Err(
                self.bad(format!("{to} does not lie downstream of {from}"), "Give the upstream place first.")
            );
        }
        if self.built.flow.is_some() && places != [0, last] {
            return Err(self.bad(
                "with [flow] the scattering of the whole chain alone is known".to_owned(),
                "Give --scattering upstream downstream, and a file of the stretch in question.",
            ));
        }
        Ok(places)
    }

    /// A place by the name of what stands there, by its position, or by the end that it is.
    fn place(&self, name: &str) -> Result<usize, Failure> {
        let network = &self.built.network;
        let place = match name {
            "upstream" => Some(0),
            "downstream" => Some(network.segments().len()),
            _ => self.built.places.iter().find(|(_, known)| known == name).map(|(place, _)| *place),
        };
        let place = match (place, name.parse::<f64>()) {
            (Some(place), _) => place,
            (None, Ok(x)) => network.place_at(x).or_bad_input().map_err(|failure| {
                failure
                    .at(&self.path)
                    .remedy("Put an element there: a `feedback` without coefficients marks a place.")
            })?,
            (None, Err(_)) => {
                let known: Vec<&str> = self.built.places.iter().map(|(_, name)| name.as_str()).collect();
                return Err(self.bad(
                    format!("no element between ducts is called `{name}`; known: {}", known.join(", ")),
                    "Name one of these, a position in m, upstream or downstream.",
                ));
            }
        };
        Ok(place)
    }

    fn bad(&self, message: String, remedy: &str) -> Failure {
        Failure::bad_input(message).at(&self.path).remedy(remedy)
    }
}
