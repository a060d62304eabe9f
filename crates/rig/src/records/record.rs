//! One record of all microphones.

/// One record of all microphones.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// The first `quiet` samples were taken before the loudspeaker acts: noise only. A click's trigger, t =
    /// 0, is at sample `quiet`. In a ping the recorder may skip from here to the last part of the forcing.
    pub quiet: usize,
    /// Largest pressure the instrument can record, Pa; infinite for floating-point files.
    pub full_scale: f64,
    /// Pressure in Pa: `channels[m]` belongs to microphone m of the rig; all of the same length, but none at
    /// all of a microphone that was dead.
    pub channels: Vec<Vec<f64>>,
}

impl Record {
    /// Number of samples per channel.
    #[must_use]
    pub fn len(&self) -> usize {
        self.channels.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Microphones that gave nothing: declared dead, or all samples the same while others have a signal.
    #[must_use]
    pub fn dead(&self) -> Vec<usize> {
        let still = |samples: &Vec<f64>| samples.iter().all(|p| *p == samples[0]);
        let dead: Vec<usize> = (0..self.channels.len()).filter(|m| still(&self.channels[*m])).collect();
        let declared = |m: &usize| self.channels[*m].is_empty();
        if dead.len() == self.channels.len() { dead.into_iter().filter(declared).collect() } else { dead }
    }

    /// Number of samples of channel `m` at the limit of the instrument.
    #[must_use]
    pub fn clipped(&self, m: usize) -> usize {
        let limit = self.full_scale * (1.0 - 1e-6);
        self.channels[m].iter().filter(|p| p.abs() >= limit).count()
    }
}
