//! A network of a file, driven: impedance and reflection, transfer, scattering.

use super::build::Built;
use crate::chain::workspace::Workspace;
use crate::error::NetworkError;
use crate::respond::forced::{Forced, Source};
use rijke_numerics::{C64, Jet, Order};
use std::f64::consts::PI;

/// What is asked of a driven network. Places are names of elements between ducts, positions (m) as text, or
/// `upstream` and `downstream`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DrivenQuantity {
    /// Impedance over rho c and reflection at a place, seen from just before it.
    Port(String),
    /// Pressure at the second place over that at the first, driven by a wave at the upstream end.
    Transfer([String; 2]),
    /// Scattering matrix of pressure waves between two places, from either side.
    Scattering([String; 2]),
}

/// Why a driven network has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DrivenError {
    /// The places do not follow each other.
    #[error("{to} does not lie downstream of {from}")]
    Order {
        /// The first.
        from: String,
        /// The second.
        to: String,
    },
    /// Part of a chain with flow.
    #[error("with [flow] the scattering of the whole chain alone is known")]
    PartOfFlow,
    /// A port within a chain with flow.
    #[error("with [flow] what the chain shows is known at its upstream end alone")]
    PortInFlow,
    /// No such place.
    #[error("no element between ducts is called `{name}`; known: {known}")]
    Unknown {
        /// The name.
        name: String,
        /// All that there are.
        known: String,
    },
    /// A position at which nothing stands.
    #[error(transparent)]
    Position(NetworkError),
    /// The network has no answer.
    #[error(transparent)]
    Network(#[from] NetworkError),
}

impl DrivenError {
    /// What to do.
    #[must_use]
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::Order { .. } => "Give the upstream place first.",
            Self::PartOfFlow => {
                "Give --scattering upstream downstream, and a file of the stretch in question."
            }
            Self::PortInFlow => {
                "Give --port upstream, and a file of the stretch downstream of the place in question."
            }
            Self::Unknown { .. } => "Name one of these, a position in m, upstream or downstream.",
            Self::Position(_) => {
                "Inside a duct an element marks a place: a `feedback` without coefficients changes nothing. Beyond the ends there is none."
            }
            Self::Network(_) => "Change the element named, or the frequencies.",
        }
    }
}

impl Built {
    /// The columns of an answer, each with its name and a value at every one of these frequencies (Hz).
    ///
    /// # Errors
    /// [`DrivenError`].
    pub fn driven(
        &self,
        quantity: &DrivenQuantity,
        frequencies: &[f64],
    ) -> Result<Vec<(String, Vec<C64>)>, DrivenError> {
        let (names, places) = match quantity {
            DrivenQuantity::Port(name) => {
                let place = self.place(name)?;
                if self.flow.is_some() && place != 0 {
                    return Err(DrivenError::PortInFlow);
                }
                (vec![format!("Z/(rho c) at {name}"), format!("R at {name}")], [place; 2])
            }
            DrivenQuantity::Transfer([from, to]) => {
                (vec![format!("p({to})/p({from})")], [self.place(from)?, self.place(to)?])
            }
            DrivenQuantity::Scattering([from, to]) => {
                let ends = self.ascending(from, to)?;
                let kinds = ["R from", "T from", "T from", "R from"];
                let sides = [from, to, from, to];
                (kinds.iter().zip(sides).map(|(k, s)| format!("{k} {s}")).collect(), ends)
            }
        };
        let mut columns: Vec<(String, Vec<C64>)> = names.into_iter().map(|name| (name, Vec::new())).collect();
        for f in frequencies {
            let values = self.driven_at(quantity, places, C64::new(0.0, 2.0 * PI * f))?;
            if values.iter().any(|z| z.re.is_nan() || z.im.is_nan()) {
                return Err(DrivenError::Network(NetworkError::NotFinite { s: C64::new(0.0, 2.0 * PI * f) }));
            }
            for ((_, column), value) in columns.iter_mut().zip(values) {
                column.push(value);
            }
        }
        Ok(columns)
    }

    fn driven_at(
        &self,
        quantity: &DrivenQuantity,
        [from, to]: [usize; 2],
        s: C64,
    ) -> Result<Vec<C64>, NetworkError> {
        let (network, laws) = (&self.network, &self.laws);
        let mut work = Workspace::default();
        let value = Order::Value;
        match (quantity, &self.flow) {
            (DrivenQuantity::Port(_), None) => {
                let r = network.reflection_at(laws, s, from, value, &mut work)?.value();
                // A rigid end has no finite impedance.
                let z = if r == C64::ONE { C64::new(f64::INFINITY, 0.0) } else { (1.0 + r) / (1.0 - r) };
                Ok(vec![z, r])
            }
            (DrivenQuantity::Port(_), Some(flow)) => {
                let t = flow.transfer(s)?;
                let z = flow.impedance(s)? / t.impedances[0].value();
                Ok(vec![z, (z - 1.0) / (z + 1.0)])
            }
            (DrivenQuantity::Transfer(_), flow) => {
                let forced: Forced = match flow {
                    None => network.forced(laws, s, Source::Upstream, value, &mut work)?,
                    Some(flow) => flow.forced(s, Source::Upstream)?,
                };
                Ok(vec![forced.before[to][0].value() / forced.before[from][0].value()])
            }
            (DrivenQuantity::Scattering(_), flow) => {
                let transfer = match flow {
                    None => network.transfer(laws, s, [from, to], value, &mut work)?,
                    Some(flow) => flow.transfer(s)?,
                };
                let [[r, t_back], [t, r_back]] = transfer.scattering();
                Ok([r, t_back, t, r_back].iter().map(Jet::value).collect())
            }
        }
    }

    /// Two places, which must follow each other downstream.
    fn ascending(&self, from: &str, to: &str) -> Result<[usize; 2], DrivenError> {
        let places = [self.place(from)?, self.place(to)?];
        let last = self.network.segments().len();
        if places[0] >= places[1] {
            return Err(DrivenError::Order { from: from.to_owned(), to: to.to_owned() });
        }
        if self.flow.is_some() && places != [0, last] {
            return Err(DrivenError::PartOfFlow);
        }
        Ok(places)
    }

    /// A place by the name of what stands there, by its position, or by the end that it is.
    fn place(&self, name: &str) -> Result<usize, DrivenError> {
        let place = match name {
            "upstream" => Some(0),
            "downstream" => Some(self.network.segments().len()),
            _ => self.places.iter().find(|(_, known)| known == name).map(|(place, _)| *place),
        };
        match (place, name.parse::<f64>()) {
            (Some(place), _) => Ok(place),
            (None, Ok(x)) => self.network.place_at(x).map_err(DrivenError::Position),
            (None, Err(_)) => {
                let known = self.places.iter().map(|(_, name)| name.as_str()).collect::<Vec<_>>().join(", ");
                let known = if known.is_empty() { "none".to_owned() } else { known };
                Err(DrivenError::Unknown { name: name.to_owned(), known })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::read::read;
    use super::*;

    const TUBE: &str = "[upstream]\ntype = 'anechoic'\n[downstream]\ntype = 'closed'\n[[element]]\ntype = 'duct'\nlength = 0.4\n\
                        diameter = 0.05\n[[element]]\nname = 'mark'\ntype = 'feedback'\n[[element]]\ntype = 'duct'\nlength = 0.6\n\
                        diameter = 0.05\n";

    #[test]
    fn oracle_a_closed_tube_reflects_and_carries_as_it_must() {
        let built = read(TUBE).unwrap();
        let c = (1.4_f64 * 287.05 * 293.15).sqrt();
        let k = |hz: f64| 2.0 * PI * hz / c;
        let port = built.driven(&DrivenQuantity::Port("mark".into()), &[100.0, 130.0]).unwrap();
        for (hz, r) in [100.0, 130.0].iter().zip(&port[1].1) {
            assert!((r - C64::new(0.0, -1.2 * k(*hz)).exp()).norm() < 1e-12, "{r}");
        }
        let ends = ["mark".to_owned(), "downstream".to_owned()];
        let transfer = built.driven(&DrivenQuantity::Transfer(ends.clone()), &[100.0]).unwrap();
        assert!((transfer[0].1[0].re * (0.6 * k(100.0)).cos() - 1.0).abs() < 1e-12, "{transfer:?}");
        let scattering = built.driven(&DrivenQuantity::Scattering(ends), &[100.0]).unwrap();
        assert!(scattering[0].1[0].norm() < 1e-12 && (scattering[2].1[0].norm() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn message_places_that_are_none_are_named() {
        let built = read(TUBE).unwrap();
        let pair = |a: &str, b: &str| DrivenQuantity::Scattering([a.to_owned(), b.to_owned()]);
        let refused = |quantity: &DrivenQuantity| built.driven(quantity, &[100.0]).unwrap_err();
        let order = refused(&pair("mark", "upstream"));
        assert_eq!(order.to_string(), "upstream does not lie downstream of mark");
        let unknown = refused(&DrivenQuantity::Port("mrak".into()));
        assert!(unknown.to_string().ends_with("known: mark") && unknown.remedy().starts_with("Name one"));
        let nothing = refused(&DrivenQuantity::Port("0.3".into()));
        assert!(matches!(nothing, DrivenError::Position(_)), "{nothing}");
    }
}
