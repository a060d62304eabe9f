//! Sweeps and periodic excitations: what several microphones hear of one source, from spectra of whole
//! records.
//!
//! A record that begins and ends in silence, and a whole period of a steady response, are transformed as they
//! are: a window would weight the frequencies of a sweep by the moment at which they sound (Müller &
//! Massarani, J. Audio Eng. Soc. 49 (2001) 443). At one frequency of one record the spectra of the
//! microphones are X = p a + noise with the pressures p and a source of unknown strength a. Divided by its
//! length, X counts alike in every record and at every frequency of a band, and the sum of the products X_i*
//! X_j over them has p as its leading eigenvector. Of two microphones that is H_v, which noise of like power
//! in both leaves right, while H1 and H2 are off by it (Rocklin, Crowley & Vold, Proc. 3rd Int. Modal
//! Analysis Conf. (1985) 272). Its errors are those of principal components (Brillinger, Time Series (1981),
//! section 9.4); of two microphones they are those of Bendat & Piersol, Random Data (4th ed. 2010), section
//! 9.1.

use super::spectra::{Spectra, asked, checked};
use crate::Fault;
use crate::dsp::transform;
use rijke_numerics::C64;

/// How records are averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweptOptions {
    /// Frequencies that are wanted, Hz.
    pub band_hz: [f64; 2],
    /// Width of the bands over which neighbouring frequencies are averaged, Hz.
    pub resolution_hz: f64,
    /// Samples of a period of a periodic excitation; none for a sweep that begins and ends in silence.
    pub period: Option<usize>,
}

/// What microphones hear of one source.
#[derive(Clone, Debug, PartialEq)]
pub struct Swept {
    /// Cross spectra, in which every record and every frequency of a band counts alike.
    pub spectra: Spectra,
    /// The pressures in every band.
    pub fields: Vec<Field>,
}

/// Pressures of one source at one frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// By microphone; the sum of their squares is one, and their common phase has no meaning.
    pub pressures: Vec<C64>,
    /// Standard deviation of the real and of the imaginary part of each. Errors of different microphones are
    /// independent, but for a common factor, which is nothing because the strength of the source is not
    /// known.
    pub sd: f64,
    /// Coherence of two microphones of middle level, 0 to 1.
    pub coherence: f64,
}

impl Swept {
    /// From records of the same length. The noise is what differs between records, or between periods. Of a
    /// single one, and where that is far more, it is what differs between the frequencies of a band beyond a
    /// linear change: a hum that is louder than the sweep is the same in all records. The first period, in
    /// which the rig settles, is left out.
    ///
    /// # Errors
    /// As [`Spectra::welch`]; [`Fault::Options`] for a resolution that is no positive number;
    /// [`Fault::TooShort`] for records of different lengths, less than two microphones or two periods, a
    /// single record with less than three frequencies in a band, or a band without a frequency.
    pub fn new(records: &[Vec<Vec<f64>>], rate_hz: f64, options: &SweptOptions) -> Result<Self, Fault> {
        asked(rate_hz, options.band_hz)?;
        if !(options.resolution_hz.is_finite() && options.resolution_hz > 0.0) {
            return Err(Fault::Options("the resolution is no number above zero"));
        }
        let whole = records.iter().filter_map(|r| r.first()).map(Vec::len).max().unwrap_or(0);
        let length = options.period.unwrap_or(whole);
        let n = records.first().map_or(0, Vec::len);
        let short =
            |what, have, need| if have < need { Err(Fault::TooShort { what, have, need }) } else { Ok(()) };
        short("list of microphones", n, 2)?;
        short("record or period", length, 16)?;
        short("record, beside its period,", whole, length)?;
        let spacing = rate_hz / length as f64;
        let together = ((options.resolution_hz / spacing).round() as usize).max(1);
        let [low, high] = options.band_hz;
        let bins: Vec<usize> =
            (1..length / 2).filter(|k| (low..=high).contains(&(*k as f64 * spacing))).collect();
        short("band", bins.len(), together)?;
        // By record or period, frequency and microphone.
        let mut heard: Vec<Vec<Vec<C64>>> = Vec::new();
        for channels in records {
            let have = checked(channels)?;
            let starts = match options.period {
                None => {
                    short("record, beside the longest,", have, whole)?;
                    0..1
                }
                Some(_) => {
                    short("record of two periods", have, 2 * length)?;
                    1..have / length
                }
            };
            heard.extend(starts.map(|k| directions(channels, k * length..(k + 1) * length, &bins)));
        }
        let repeats = heard.len();
        if repeats < 2 {
            short("list of frequencies in a band, of a single record,", together, 3)?;
        }
        let (mut frequency_hz, mut cross, mut fields) = (Vec::new(), Vec::new(), Vec::new());
        for (band, group) in bins.chunks_exact(together).enumerate() {
            let first = band * together;
            frequency_hz.push(0.5 * (group[0] + group[together - 1]) as f64 * spacing);
            let all = heard.iter().flat_map(|record| &record[first..first + together]);
            let sums = products(n, all);
            let pressures = principal(&sums).1;
            let of_bin = |k: usize| principal(&products(n, heard.iter().map(|record| &record[k])));
            let own: Vec<(f64, Vec<C64>)> = (first..first + together).map(of_bin).collect();
            // The share of the power in each direction that differs between records, and what between
            // frequencies.
            let (of_records, of_line) =
                ((n - 1) * together * (repeats - 1), (n - 1) * together.saturating_sub(2));
            let within = own.iter().map(|(largest, _)| repeats as f64 - largest).sum::<f64>().max(0.0)
                / of_records as f64;
            let between = repeats as f64 * bent(&own, &pressures) / of_line as f64;
            let noise = match (repeats > 1, of_line > 0) {
                (true, true) if chance(between / within, of_line, of_records) < BY_CHANCE => between,
                (true, _) => within,
                (false, _) => between,
            };
            let signal = (1.0 - n as f64 * noise).max(0.0);
            let variance = noise * (signal + noise)
                / (signal * signal).max(f64::MIN_POSITIVE)
                / (together * repeats) as f64;
            fields.push(Field { pressures, sd: (0.5 * variance).sqrt(), coherence: signal * signal });
            cross.push(sums);
        }
        Ok(Self { spectra: Spectra { frequency_hz, averages: (together * repeats) as f64, cross }, fields })
    }
}

/// Probability by which two measures of one noise that far apart are taken for different ones.
const BY_CHANCE: f64 = 1e-4;

/// The probability that the mean of `above` squares of complex normal numbers exceeds that of `below` others
/// `ratio` times: Fisher's distribution of twice as many degrees of freedom. The incomplete beta function is
/// a finite sum for whole numbers (Abramowitz & Stegun 26.6.4).
fn chance(ratio: f64, above: usize, below: usize) -> f64 {
    let (p, q) = (above as f64, below as f64);
    let share = q / (q + p * ratio);
    // Terms in logarithms: the first one may lie below the least number where the sum is near one.
    let mut term = q * share.ln();
    let mut sum = term.exp();
    for i in 1..above {
        let i = i as f64;
        term += ((q + i - 1.0) / i).ln() + (-share).ln_1p();
        sum += term.exp();
    }
    sum
}

/// The sum of squares of what the directions of single frequencies have beside `middle`, less what rises in
/// proportion to frequency: over a band that is nothing.
fn bent(own: &[(f64, Vec<C64>)], middle: &[C64]) -> f64 {
    let apart = |(_, p): &(f64, Vec<C64>)| -> Vec<C64> {
        let along: C64 = middle.iter().zip(p).map(|(a, b)| a.conj() * b).sum();
        let turn = along.conj() / along.norm().max(f64::MIN_POSITIVE);
        p.iter().zip(middle).map(|(b, a)| (b - along * a) * turn).collect()
    };
    let apart: Vec<Vec<C64>> = own.iter().map(apart).collect();
    let place = |k: usize| k as f64 - 0.5 * (own.len() - 1) as f64;
    let lever = (0..own.len()).map(|k| place(k).powi(2)).sum::<f64>().max(f64::MIN_POSITIVE);
    let left = |c: usize| {
        let mean = apart.iter().map(|d| d[c]).sum::<C64>() / own.len() as f64;
        let slope = apart.iter().enumerate().map(|(k, d)| place(k) * d[c]).sum::<C64>() / lever;
        apart.iter().enumerate().map(|(k, d)| (d[c] - mean - place(k) * slope).norm_sqr()).sum::<f64>()
    };
    (0..middle.len()).map(left).sum()
}

/// Spectra of some samples at the frequencies `bins`, by frequency and channel, each over its length.
fn directions(channels: &[Vec<f64>], samples: std::ops::Range<usize>, bins: &[usize]) -> Vec<Vec<C64>> {
    let plan = transform::forward(samples.len());
    let mut all = vec![Vec::with_capacity(channels.len()); bins.len()];
    for channel in channels {
        let mut part = channel[samples.clone()].to_vec();
        let mut spectrum = plan.make_output_vec();
        // The lengths are those of the plan.
        let _ = plan.process(&mut part, &mut spectrum);
        all.iter_mut().zip(bins).for_each(|(heard, bin)| heard.push(spectrum[*bin]));
    }
    for heard in &mut all {
        let length = heard.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        heard.iter_mut().for_each(|z| *z /= length);
    }
    all
}

/// The sums of conj(X_i) X_j, by i and j.
fn products<'a>(n: usize, all: impl Iterator<Item = &'a Vec<C64>>) -> Vec<Vec<C64>> {
    let mut sums = vec![vec![C64::ZERO; n]; n];
    for heard in all {
        for (row, a) in sums.iter_mut().zip(heard) {
            row.iter_mut().zip(heard).for_each(|(sum, b)| *sum += a.conj() * b);
        }
    }
    sums
}

/// The largest eigenvalue of such sums, and the p of unit length of which they are the products, by the power
/// method: as exact as rounding allows where there is a signal, and not needed where there is none.
fn principal(sums: &[Vec<C64>]) -> (f64, Vec<C64>) {
    let loudest = (0..sums.len()).max_by(|a, b| sums[*a][*a].re.total_cmp(&sums[*b][*b].re)).unwrap_or(0);
    // Row i is conj(p_i) p.
    let mut p = sums[loudest].clone();
    let mut value = 0.0;
    for _ in 0..30 {
        let length = p.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        p.iter_mut().for_each(|z| *z /= length);
        let next = (0..p.len())
            .map(|j| sums.iter().zip(&p).map(|(row, p)| row[j] * p).sum::<C64>())
            .collect::<Vec<_>>();
        value = next.iter().zip(&p).map(|(a, b)| (a * b.conj()).re).sum();
        p = next;
    }
    let length = p.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    (value, p.iter().map(|z| z / length).collect())
}
