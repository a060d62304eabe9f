//! Sweeps and periodic excitations: what several microphones hear of one source, from spectra of whole records.
//!
//! A record that begins and ends in silence, and a whole period of a steady response, are transformed as they are: a window would weight the frequencies of a sweep by the
//! moment at which they sound (Müller & Massarani, J. Audio Eng. Soc. 49 (2001) 443). At one frequency of one record the spectra of the microphones are X = p a + noise
//! with the pressures p and a source of unknown strength a. Divided by its length, X counts alike in every record and at every frequency of a band, and the sum of the
//! products X_i* X_j over them has p as its leading eigenvector. Of two microphones that is H_v, which noise of like power in both leaves right, while H1 and H2 are
//! off by it (Rocklin, Crowley & Vold, Proc. 3rd Int. Modal Analysis Conf. (1985) 272). Its errors are those of principal components (Brillinger, Time Series
//! (1981), section 9.4); of two microphones they are those of Bendat & Piersol, Random Data (4th ed. 2010), section 9.1.

use super::spectra::{Spectra, checked};
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
    /// Standard deviation of the real and of the imaginary part of each. Errors of different microphones are independent, but for a common factor,
    /// which is nothing because the strength of the source is not known.
    pub sd: f64,
    /// Coherence of two microphones of middle level, 0 to 1.
    pub coherence: f64,
}

impl Swept {
    /// From records of the same length. The noise is what differs between records, or between periods; of a single one what differs between the frequencies of a band,
    /// and the field that changes within the band then counts as noise. The first period, in which the rig settles, is left out.
    ///
    /// # Errors
    /// As [`Spectra::welch`]; [`Fault::TooShort`] for records of different lengths, less than two microphones, two periods or two averages, or a band without a
    /// frequency.
    pub fn new(records: &[Vec<Vec<f64>>], rate_hz: f64, options: &SweptOptions) -> Result<Self, Fault> {
        let whole = records.iter().filter_map(|r| r.first()).map(Vec::len).max().unwrap_or(0);
        let length = options.period.unwrap_or(whole);
        let n = records.first().map_or(0, Vec::len);
        let short =
            |what, have, need| if have < need { Err(Fault::TooShort { what, have, need }) } else { Ok(()) };
        short("list of microphones", n, 2)?;
        short("record or period", length, 16)?;
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
        short("list of records and of frequencies in a band", together * repeats, 2)?;
        let (mut frequency_hz, mut cross, mut fields) = (Vec::new(), Vec::new(), Vec::new());
        for (band, group) in bins.chunks_exact(together).enumerate() {
            let first = band * together;
            frequency_hz.push(0.5 * (group[0] + group[together - 1]) as f64 * spacing);
            let all = heard.iter().flat_map(|record| &record[first..first + together]);
            let sums = products(n, all);
            let (largest, pressures) = principal(&sums);
            // Share of the power in each direction that is noise.
            let left = |largest: f64, count: usize| {
                (count as f64 - largest).max(0.0) / (count - 1) as f64 / (n - 1) as f64
            };
            let noise = if repeats > 1 {
                let of_bin = |k: usize| {
                    let sums = products(n, heard.iter().map(|record| &record[k]));
                    left(principal(&sums).0, repeats)
                };
                (first..first + together).map(of_bin).sum::<f64>() / together as f64
            } else {
                left(largest, together)
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

/// The largest eigenvalue of such sums, and the p of unit length of which they are the products, by the power method: as exact as rounding allows where there is a signal, and
/// not needed where there is none.
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
