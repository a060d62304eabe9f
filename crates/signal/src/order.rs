//! Whether sound comes to channels in the order in which they are said to stand.

use crate::Channel;
use std::fmt;

/// Channels that hold the records of each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelExchange {
    /// The channels, in the order of their places.
    pub channels: Vec<Channel>,
    /// The channel that heard what each of them should have.
    pub heard_by: Vec<Channel>,
}

/// For the place of every channel, the channel whose time belongs there: times ascend with the places. Of all
/// orders this one has the least squares of what is left of the times.
pub(crate) fn by_arrival(places: &[f64], times: &[f64]) -> Vec<usize> {
    let sorted = |less: &dyn Fn(usize, usize) -> std::cmp::Ordering| {
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_by(|a, b| less(*a, *b));
        order
    };
    let time = |a: usize, b: usize| times[a].total_cmp(&times[b]);
    // Channels at one place are in the order in which they hear it.
    let at = sorted(&|a, b| places[a].total_cmp(&places[b]).then(time(a, b)));
    let heard = sorted(&time);
    let mut found = vec![0; places.len()];
    at.into_iter().zip(heard).for_each(|(at, heard)| found[at] = heard);
    found
}

impl ChannelExchange {
    /// What `order` (of [`by_arrival`]) changes; none where it changes nothing.
    pub(crate) fn of(order: &[usize], places: &[f64]) -> Option<Self> {
        let mut moved: Vec<usize> = (0..order.len()).filter(|m| order[*m] != *m).collect();
        moved.sort_by(|a, b| places[*a].total_cmp(&places[*b]));
        let heard_by = moved.iter().map(|m| order[*m].into()).collect();
        (!moved.is_empty())
            .then(|| Self { channels: moved.into_iter().map(Channel::Place).collect(), heard_by })
    }

    /// Calls its channels as `others` call those at their places.
    pub(crate) fn call(&mut self, others: &[Channel]) {
        self.channels.iter_mut().chain(&mut self.heard_by).for_each(|channel| channel.call(others));
    }

    /// Whether all channels of three or more have the opposite order.
    fn is_reversed(&self) -> bool {
        self.channels.len() > 2 && self.channels.iter().eq(self.heard_by.iter().rev())
    }
}

impl fmt::Display for ChannelExchange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.channels.as_slice() {
            [a, b] => write!(f, "{a} and {b} are exchanged"),
            all => {
                let names = |channels: &[Channel]| {
                    channels.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
                };
                let (stand, hear) = (names(all), names(&self.heard_by));
                write!(
                    f,
                    "the channels are in the wrong order: {stand} stand along the tube, and sound comes to {hear}"
                )?;
                let reversed = ", as it does where the click is made at the other end";
                write!(f, "{}", if self.is_reversed() { reversed } else { "" })
            }
        }
    }
}

/// Channels of one click that sound does not reach as a gas carries it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OutOfOrder {
    /// Some channels hold the records of others.
    #[error(
        "{exchange}: sound comes to {} {:.0} us before {}, which it passes first; exchanged back, all arrival times are those of a sound that \
         travels along the tube. Check the wiring, and give the right `channels` of these files in an [[exception]] of the manifest",
        pair[1], 1e6 * early, pair[0]
    )]
    Exchanged {
        /// Which.
        exchange: ChannelExchange,
        /// Two of them, in the order of their places, of which sound reaches the second first.
        pair: [Channel; 2],
        /// And by how much, s.
        early: f64,
    },
    /// Sound takes a time between two channels that no gas gives it.
    #[error(
        "sound takes {:.0} us from {} to {}, and it takes {:.0} to {:.0} us in a gas of {:.0} to {:.0} K: are these channels in the order, and the microphones \
         at the places, that manifest and rig say?",
        1e6 * travel, pair[0], pair[1], 1e6 * between[0], 1e6 * between[1], temperatures[0], temperatures[1]
    )]
    Travel {
        /// The two, in the order of their places.
        pair: [Channel; 2],
        /// The time, s.
        travel: f64,
        /// The shortest and the longest that are possible, s.
        between: [f64; 2],
        /// Temperatures of the gas that are thought possible, K.
        temperatures: [f64; 2],
    },
}

impl OutOfOrder {
    /// Calls its channels as `others` call those at their places.
    pub(crate) fn call(&mut self, others: &[Channel]) {
        let (Self::Exchanged { pair, .. } | Self::Travel { pair, .. }) = self;
        pair.iter_mut().for_each(|channel| channel.call(others));
        if let Self::Exchanged { exchange, .. } = self {
            exchange.call(others);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_order_of_arrival_names_what_was_exchanged() {
        let places = [0.15, 0.6, 0.27, 0.52];
        assert_eq!(ChannelExchange::of(&by_arrival(&places, &[1.0, 4.0, 2.0, 3.0]), &places), None);
        let found = ChannelExchange::of(&by_arrival(&places, &[1.0, 3.0, 2.0, 4.0]), &places).unwrap();
        assert_eq!(found.to_string(), "channel 3 and channel 1 are exchanged");
        let found =
            ChannelExchange::of(&by_arrival(&places, &[4.0, 1.0, 3.0, 2.0]), &places).unwrap().to_string();
        assert!(found.ends_with("as it does where the click is made at the other end"), "{found}");
        let found =
            ChannelExchange::of(&by_arrival(&places, &[2.0, 4.0, 3.0, 1.0]), &places).unwrap().to_string();
        let said = "channel 0, channel 2, channel 3 stand along the tube, and sound comes to channel 3, channel 0, channel 2";
        assert!(found.ends_with(said), "{found}");
        // Two at one place hear it in any order.
        let places = [0.1, 0.3, 0.3, 0.5];
        assert_eq!(ChannelExchange::of(&by_arrival(&places, &[1.0, 3.1, 3.0, 5.0]), &places), None);
    }
}
