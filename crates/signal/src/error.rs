//! Why a record cannot be used.

use crate::Channel;
use crate::readings::TwoReadings;
use crate::unstable::Unstable;
use crate::words::{not_free, not_quiet, second_excitation, strange_reflection};

/// What is wrong with one record, which the caller lists and leaves. Times are seconds from its first sample.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// The channels do not have the same length, or there is none.
    #[error(
        "the channels of the record differ in length: {channel} has {have} samples, the first has {need}"
    )]
    UnequalChannels {
        /// The first channel that differs.
        channel: Channel,
        /// Its number of samples.
        have: usize,
        /// The number of samples of the first channel.
        need: usize,
    },
    /// Options that no fit can use.
    #[error("the options of the fit: {0}")]
    Options(&'static str),
    /// Too few samples, channels or settings out of range for what was asked.
    #[error("the {what} is too short: it has {have} samples, {need} are needed")]
    TooShort {
        /// Which part of the record.
        what: &'static str,
        /// Samples there are.
        have: usize,
        /// Samples needed.
        need: usize,
    },
    /// The stretch that is said to be silent is not.
    #[error("{}", not_quiet(*stated, *found, *at, *ratio))]
    NotQuiet {
        /// Samples that are said to be silent.
        stated: usize,
        /// Samples that are; none if the record begins loudly.
        found: usize,
        /// When silence ends, s.
        at: f64,
        /// How much louder the rest of the stretch, or the whole of it, is than silence.
        ratio: f64,
    },
    /// A step of the converter is too coarse for the signal.
    #[error(
        "{channel}: the converter is too coarse for the signal. The amplitude of the mode is {:.1} steps of {step:.3e}, and {need:.0} \
         steps are needed. Raise the gain before the converter, or choose a smaller range of it",
        amplitude / step
    )]
    Coarse {
        /// The channel with the largest amplitude in steps.
        channel: Channel,
        /// Step of the converter, units of the record.
        step: f64,
        /// Amplitude of the mode, units of the record.
        amplitude: f64,
        /// Steps needed.
        need: f64,
    },
    /// The record ends too soon after the forcing.
    #[error(
        "the decay is too short: {:.1} ms are left after the forcing at {frequency_hz:.0} Hz, and {:.1} ms are needed to tell a decay from \
         forcing. Record for longer after the loudspeaker is switched off; what sounds by itself has no decay",
        1e3 * have, 1e3 * need
    )]
    ShortDecay {
        /// Time from the last loud moment to the end of the record, s.
        have: f64,
        /// The same that is needed, s.
        need: f64,
        /// Frequency of the forcing, Hz.
        frequency_hz: f64,
    },
    /// A sample is NaN or infinite.
    #[error("{channel}: sample {sample} is not a finite number")]
    NotFinite {
        /// The channel.
        channel: Channel,
        /// The sample.
        sample: usize,
    },
    /// Samples sit at full scale, or the waveform has a flat top.
    #[error(
        "{channel} is clipped: {samples} samples sit at its extreme value {level:.4e}. Lower the gain. If only this channel is \
         clipped, write `dead = [{dead}]` in the manifest", dead = channel.number()
    )]
    Clipped {
        /// The channel with most clipped samples.
        channel: Channel,
        /// How many of its samples are clipped.
        samples: usize,
        /// The value they sit at, in the units of the record.
        level: f64,
    },
    /// A channel holds one constant value throughout, or hardly more where the others hold a signal.
    #[error(
        "{channel} is missing: its samples span {span:.1e}, the median of the channels {median:.1e}. Look after its microphone and cable, or \
         write `dead = [{dead}]` in the manifest, and another `reference` in rig.toml if it is that", dead = channel.number()
    )]
    DeadChannel {
        /// The channel.
        channel: Channel,
        /// Difference of its largest and smallest sample, in the units of the record.
        span: f64,
        /// Median of the same over the channels.
        median: f64,
    },
    /// Two channels are one.
    #[error(
        "{0} and {1} hold the same samples: one signal was wired, or listed in `channels`, twice; write `dead = [{n}]` for one that was not recorded", n = .1.number())]
    SameChannels(Channel, Channel),
    /// A channel holds noise where every other channel holds a signal.
    #[error(
        "{channel} carries no signal: its amplitude is {ratio:.2} times the noise, the median of the channels is {median:.0}. Look after its \
         microphone and cable, or write `dead = [{dead}]` in the manifest, and another `reference` in rig.toml if it is that", dead = channel.number()
    )]
    NoSignal {
        /// The channel.
        channel: Channel,
        /// Amplitude of that channel over its noise.
        ratio: f64,
        /// Median of the same ratio over the channels.
        median: f64,
    },
    /// A channel of a click holds no impulse.
    #[error("{channel} holds no impulse: its largest sample is {ratio:.1} times the rms of its quiet part")]
    NoImpulse {
        /// The channel.
        channel: Channel,
        /// Largest sample over the rms of the quiet part, both high-passed.
        ratio: f64,
    },
    /// An impulse lasts too long for the way it travels.
    #[error(
        "the impulse at {channel} rises for {:.2} ms and falls for {:.2} ms or more, and its reflection comes {:.2} ms after it: use a shorter one",
        1e3 * before, 1e3 * after, 1e3 * room
    )]
    LongImpulse {
        /// The channel farthest from the reflecting end.
        channel: Channel,
        /// From a twentieth of the peak to the peak, s.
        before: f64,
        /// From the peak to a twentieth of it, s.
        after: f64,
        /// Time between the impulse and its reflection, s.
        room: f64,
    },
    /// What follows an impulse is no reflection at an open end: the channel nearest that end, the window that
    /// was fitted before and after the peak, s, the time between impulse and reflection, s, and whether the
    /// reflection has the sign of the impulse.
    #[error("{}", strange_reflection(_0, *_1, *_2, *_3))]
    StrangeReflection(Channel, (f64, f64), f64, bool),
    /// An impulse too near the first or the last sample.
    #[error(
        "the impulse at {channel} comes {:.2} ms after the first sample and {:.2} ms before the last one, and {:.2} ms are needed on \
         either side. Start the recorder sooner, or let it run for longer; a single short click needs less than one that bounces",
        1e3 * before, 1e3 * after, 1e3 * need
    )]
    ImpulseAtEdge {
        /// The channel.
        channel: Channel,
        /// Time from the first sample to the impulse, s.
        before: f64,
        /// Time from the impulse to the last sample, s.
        after: f64,
        /// What both must be at least, s.
        need: f64,
    },
    /// An impulse holds frequencies that the sampling rate does not show.
    #[error(
        "the impulse at {channel} is too short for {rate_hz:.0} samples a second: just below {:.0} Hz it still has {:.0} % of its loudest \
         frequency. Use a longer click, or a higher sampling rate",
        0.5 * rate_hz, 100.0 * share
    )]
    ShortImpulse {
        /// The channel farthest from the reflecting end.
        channel: Channel,
        /// Sampling rate, Hz.
        rate_hz: f64,
        /// Amplitude below half the sampling rate over that of the loudest frequency.
        share: f64,
    },
    /// A sample that is far beyond all others.
    #[error(
        "sample {sample} of {channel} is {ratio:.0} times the root mean square: a fault of the record, no sound; cut it out"
    )]
    Spike {
        /// Channel.
        channel: Channel,
        /// Sample.
        sample: usize,
        /// Its distance from the mean, in root mean squares.
        ratio: f64,
    },
    /// A channel holds its value for a stretch of time.
    #[error("{channel} drops out at {at:.4} s: {samples} equal samples in a row")]
    Dropout {
        /// The channel.
        channel: Channel,
        /// When the stretch begins, s.
        at: f64,
        /// Its length.
        samples: usize,
    },
    /// No signal stands out of the noise: the amplitude over the noise.
    #[error("no signal: the strongest component is {0:.2} times the noise")]
    Weak(f64),
    /// The strongest tone, Hz, lies beside a multiple of the mains, Hz.
    #[error("the tone at {0:.1} Hz may be hum at {1:.0} Hz: drive the mode, or state `mains_hz`")]
    BesideMains(f64, f64),
    /// The loudspeaker acted a second time.
    #[error("{}", second_excitation(*at, *factor))]
    SecondExcitation {
        /// When it begins, s.
        at: f64,
        /// How much the amplitude grows.
        factor: f64,
    },
    /// Mains hum comes or goes during the decay.
    #[error("hum burst at {at:.3} s: energy near {frequency_hz:.0} Hz is {ratio:.1} times the noise")]
    HumBurst {
        /// Middle of the strongest stretch, s.
        at: f64,
        /// Multiple of the mains frequency, Hz.
        frequency_hz: f64,
        /// Amplitude of the burst over the noise.
        ratio: f64,
    },
    /// Mains hum is as loud as the impulse: the channel, the multiple of the mains frequency, Hz, and the
    /// amplitude over the largest distance of a sample from the mean.
    #[error(
        "{1:.0} Hz hum in {0} has {2:.2} times the amplitude of its impulse: keep the cables away from the mains"
    )]
    LoudHum(Channel, f64, f64),
    /// The fit leaves more than noise.
    #[error(
        "the fit leaves {ratio:.2} times the noise power at {at:.3} s, {channel}, mostly near {frequency_hz:.0} Hz"
    )]
    Residual {
        /// Middle of the worst stretch, s.
        at: f64,
        /// Worst channel.
        channel: Channel,
        /// Residual power over noise power.
        ratio: f64,
        /// Strongest frequency of the residual, Hz.
        frequency_hz: f64,
    },
    /// The tone of the record is not in the band, and nothing in the band can be fitted.
    #[error(
        "{what} {driven_hz:.1} Hz, and the mode is sought from {:.0} to {:.0} Hz: state the band of the wanted mode, as \
         `band_hz` in the manifest or with --band, or correct the sampling rate",
        band_hz.0, band_hz.1
    )]
    DrivenOutside {
        /// What sounds, and its verb: `the loudspeaker drives`, or `most of the sound is at`.
        what: &'static str,
        /// The frequency of that, Hz.
        driven_hz: f64,
        /// Where the mode was sought, Hz.
        band_hz: (f64, f64),
    },
    /// What decays in the band is not what was driven.
    #[error(
        "the loudspeaker drives {driven_hz:.1} Hz, and the strongest decay from {:.0} to {:.0} Hz is at {mode_hz:.1} Hz: state the \
         band of the wanted mode, as `band_hz` in the manifest or with --band; if it is this one, drive it within a quarter of its frequency",
        band_hz.0, band_hz.1
    )]
    DrivenElsewhere {
        /// Frequency of the forcing, Hz.
        driven_hz: f64,
        /// Frequency of the mode that was fitted, Hz.
        mode_hz: f64,
        /// Where it was sought, Hz.
        band_hz: (f64, f64),
    },
    /// The rig sounds by itself.
    #[error(transparent)]
    Unstable(#[from] Unstable),
    /// The oscillation does not decay: its growth rate, 1/s.
    #[error("the oscillation does not decay: growth rate {0:.3} 1/s")]
    NotDecaying(f64),
    /// The loudspeaker goes on.
    #[error(
        "the loudspeaker is not off: after the forcing a tone at {frequency_hz:.1} Hz goes on with {:.1} % of its amplitude. Switch the \
         loudspeaker off by a relay, not by the volume",
        100.0 * share
    )]
    StillDriven {
        /// Frequency of the forcing, Hz.
        frequency_hz: f64,
        /// Amplitude after the forcing over that of the forcing.
        share: f64,
    },
    /// A channel is loud and bent.
    #[error(
        "{channel} saturates: at the loudest part its third harmonic has {:.1} % of its amplitude, and falls faster than the tone. Lower the \
         gain, or drive the loudspeaker less. If only this channel saturates, write `dead = [{dead}]` in the manifest",
        100.0 * share, dead = channel.number()
    )]
    Saturated {
        /// The channel.
        channel: Channel,
        /// Amplitude of the third harmonic over that of the first.
        share: f64,
    },
    /// Mains hum as loud as the mode, all the time.
    #[error(
        "hum at {frequency_hz:.0} Hz has {share:.2} times the amplitude of the forcing in {channel}, from the beginning to the end of the record, \
         and what is left of it is more than the noise. Ground the amplifiers at one point, and keep the cables away from the mains"
    )]
    SteadyHum {
        /// The channel with most hum.
        channel: Channel,
        /// Multiple of the mains frequency, Hz.
        frequency_hz: f64,
        /// Amplitude over that of the forcing.
        share: f64,
    },
    /// A channel holds hum and no signal.
    #[error(
        "{channel} carries no signal but hum at {frequency_hz:.0} Hz: look after its microphone and cable, or write `dead = [{dead}]` in the manifest", dead = channel.number()
    )]
    OnlyHum {
        /// The channel.
        channel: Channel,
        /// Multiple of the mains frequency, Hz.
        frequency_hz: f64,
    },
    /// Where the decay is taken to begin decides what comes out.
    #[error("{}", not_free(*from, *growth_rates, *distance))]
    NotFree {
        /// Begin of two fits, s.
        from: [f64; 2],
        /// Their growth rates, 1/s.
        growth_rates: [f64; 2],
        /// Difference over its standard deviation.
        distance: f64,
    },
    /// A decay that can be read in two ways.
    #[error(transparent)]
    TwoReadings(#[from] TwoReadings),
    /// The gain of a channel drifts during the decay.
    #[error(
        "the growth rate of {channel} differs from that of the others: {:.3} and {:.3} 1/s, {distance:.1} standard deviations apart. Its gain \
         drifts by {:+.2} % per second: let its microphone and amplifier warm up",
        growth_rates[0], growth_rates[1], 100.0 * (growth_rates[0] - growth_rates[1])
    )]
    GainDrifts {
        /// The channel.
        channel: Channel,
        /// Its growth rate and that of the others, 1/s.
        growth_rates: [f64; 2],
        /// Standard deviation of the difference, 1/s.
        sd: f64,
        /// The difference in standard deviations.
        distance: f64,
    },
    /// Channels decay otherwise than each other, and it is not known which of them is right.
    #[error(
        "the growth rates of {} and {} differ by {rate:.3} 1/s, {distance:.1} standard deviations, and no other channels show which of the two \
         has a gain that drifts. Let microphones and amplifiers warm up, or declare the one that drifts, `dead = [..]` in the manifest",
        channels[0], channels[1]
    )]
    GainsApart {
        /// The two channels that differ most.
        channels: [Channel; 2],
        /// How far one of them is from the others, 1/s.
        rate: f64,
        /// The same in standard deviations.
        distance: f64,
    },
    /// The fit did not settle: steps taken, and the length of the last in standard deviations.
    #[error("the fit did not settle in {0} steps: the last step was {1:.2e} standard deviations")]
    NotConverged(usize, f64),
    /// A channel has the opposite sign of the others.
    #[error("{0} has the opposite polarity")]
    Inverted(Channel),
    /// The result lies away from those of the other repeats: the quantity, and how many of their robust
    /// standard deviations, or of its own stated one if that is larger.
    #[error("{0} lies {1:.1} standard deviations from the other repeats")]
    Outlier(String, f64),
    /// Something went wrong when the record was taken.
    #[error(transparent)]
    Mishap(#[from] crate::Mishap),
    /// A steady tone beside the mode.
    #[error(transparent)]
    SteadyTone(#[from] crate::SteadyTone),
    /// Sound does not reach the channels as a gas carries it.
    #[error(transparent)]
    OutOfOrder(#[from] crate::OutOfOrder),
    /// The algebra failed, as it does when two modes coincide.
    #[error("the fit is singular: {0}")]
    Singular(#[from] rijke_numerics::DenseError),
}
