//! The laboratory as a whole: determinism, files against memory, and records that show what is true.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use rijke_flow::{HeatedTube, TubeCampaign, TubeRig};
use rijke_lab::{Truth, VirtualRig};
use rijke_numerics::C64;
use rijke_rig::{RecordFolder, RecordSource};

fn lab(rows: &[&str], repeats: u32, seed: u64, truth: &Truth) -> VirtualRig {
    let rows: Vec<String> = rows.iter().map(|row| (*row).to_owned()).collect();
    let (rig, campaign) = (TubeRig::juniper_yoko_2022(), TubeCampaign::juniper_yoko_2022());
    VirtualRig::new(&rig, &campaign, truth, &rows, Some(repeats), seed).unwrap()
}

#[test]
fn exact_same_seed_same_bytes_for_any_number_of_threads() {
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let folder = std::env::temp_dir().join(format!("rijke-lab-{}-{threads}", std::process::id()));
        let campaign = TubeCampaign::juniper_yoko_2022();
        let points = campaign.row("C3").take(3).cloned().collect();
        let small = TubeCampaign { points, ..campaign };
        let truth = Truth::standard();
        let lab = VirtualRig::new(&TubeRig::juniper_yoko_2022(), &small, &truth, &[], Some(2), 5).unwrap();
        pool.install(|| lab.write(&folder, &|_| {})).unwrap();
        let read = RecordFolder::open(&folder).unwrap();
        assert_eq!(read.ping(1, 1).unwrap(), lab.ping(1, 1).unwrap(), "files and memory differ");
        assert_eq!(read.click(2, 0).unwrap(), lab.click(2, 0).unwrap());
        assert_eq!(read.calibration(0, 3).unwrap(), lab.calibration(0, 3).unwrap());
        assert_eq!((read.set().points.clone(), &read.set().rig), (lab.set().points.clone(), &lab.set().rig));
        let points = read.set().points.iter().map(|p| &p.point);
        assert_eq!(HeatedTube::read_within(&folder, points).unwrap().as_ref(), Some(lab.tube()));
        let files = read.set().points.iter().flat_map(|p| p.pings.iter().chain(&p.clicks));
        let all: Vec<Vec<u8>> = files
            .chain([&"manifest.toml".to_owned()])
            .map(|f| std::fs::read(folder.join(f)).unwrap())
            .collect();
        std::fs::remove_dir_all(&folder).unwrap();
        all
    };
    assert!(bytes(1) == bytes(2));
}

#[test]
fn exact_a_record_depends_on_seed_and_name_alone() {
    let truth = Truth::standard();
    let (few, many, other) =
        (lab(&["C3"], 2, 1, &truth), lab(&["C3"], 4, 1, &truth), lab(&["C3"], 2, 2, &truth));
    assert_eq!(few.ping(7, 1).unwrap(), many.ping(7, 1).unwrap());
    assert_ne!(few.ping(7, 1).unwrap(), other.ping(7, 1).unwrap());
    assert_ne!(few.ping(7, 1).unwrap(), few.ping(7, 0).unwrap());
}

/// The truth without noise, differences between channels, scatter or bad records.
fn silent() -> Truth {
    let mut truth = Truth::standard();
    truth.noise.white_pa_rt_hz = 1e-9;
    truth.noise.mains_pa.clear();
    truth.channels.gain_sd = 0.0;
    truth.channels.ping_delay_sd_s = 0.0;
    truth.channels.click_delay_sd_s = 0.0;
    truth.ambient.record_sd_k = 0.0;
    (truth.faults.pings, truth.faults.clicks) = (0.0, 0.0);
    truth
}

#[test]
fn lab_a_silent_ping_rings_with_the_true_mode() {
    // Two samples of the late decay, where the higher modes are gone, fix s; no estimator is involved.
    let mut truth = silent();
    truth.loudspeaker.modes = 1;
    let lab = lab(&["C3"], 1, 3, &truth);
    for point in [0, 9] {
        let (s, shape) = lab.true_mode(point);
        let record = lab.ping(point, 0).unwrap();
        let dt = 1.0 / record.rate_hz;
        // y[n+1] = 2 Re(e^{s dt}) y[n] - |e^{s dt}|^2 y[n-1] holds for a decaying cosine and nothing else.
        let step = (s * dt).exp();
        for channel in &record.channels {
            let scale = channel[4100].abs().max(channel[4105].abs()).max(channel[4109].abs());
            let worst = (4100..8000).map(|n| {
                (channel[n + 1] - 2.0 * step.re * channel[n] + step.norm_sqr() * channel[n - 1]).abs()
            });
            assert!(worst.fold(0.0, f64::max) < 4e-5 * scale.max(1.0));
        }
        // The complex amplitude of channel m from samples n and n + 1, against the true shape.
        let amplitude = |m: usize| {
            let (a, b) = (record.channels[m][4200], record.channels[m][4201]);
            C64::new(a, (a * step.re - b) / step.im)
        };
        for m in 0..8 {
            let relative = amplitude(m) / amplitude(5);
            assert!((relative - shape[m]).norm() < 3e-5, "{relative} against {}", shape[m]);
        }
    }
}

#[test]
fn oracle_true_reflections_against_the_geometry_of_the_mouths() {
    let truth = Truth::standard();
    let lab = lab(&["C3"], 1, 1, &truth);
    let (rig, gas) = (TubeRig::juniper_yoko_2022(), |k: usize| {
        TubeRig::juniper_yoko_2022().gas.at(lab.true_temperature(k), 101_325.0)
    });
    let point = |k: usize| rig.point(&lab.set().points[k].point).unwrap();
    let [lower, upper] = rijke_lab::open_ends(&rig, &truth, &point(0), 1);
    // Without prongs both open ends reflect as the bare end does; with prongs the bottom's end correction is
    // as long.
    let (s, [bottom, top]) = (lab.true_mode(0).0, lab.true_reflections(0));
    let [bare_bottom, bare_top] = [lower, upper].map(|end| end.reflection(&gas(0), s));
    assert!((top - bare_top).norm() < 1e-12 && (bottom - bare_bottom).norm() < 1e-12);
    let [other, _] = rijke_lab::open_ends(&rig, &truth, &point(9), 1);
    assert!(
        (other.extension - lower.extension).abs() > 1e-4,
        "every setting of the rig has mouths of its own"
    );
    let (s, [bottom, top]) = (lab.true_mode(9).0, lab.true_reflections(9));
    let [lower, upper] =
        rijke_lab::open_ends(&rig, &truth, &point(9), 1).map(|end| end.reflection(&gas(9), s));
    assert!((top - upper).norm() < 1e-12 && (bottom - lower).norm() < 1e-4);
}

#[test]
fn lab_bad_records_occur_as_often_as_the_truth_says() {
    let mut truth = Truth::standard();
    (truth.faults.pings, truth.faults.clicks) = (0.3, 0.2);
    let lab = lab(&["C3"], 40, 1, &truth);
    let count = |bad: &dyn Fn(usize, usize) -> bool| {
        (0..20).flat_map(|p| (0..40).map(move |r| (p, r))).filter(|(p, r)| bad(*p, *r)).count() as f64 / 800.0
    };
    let (pings, clicks) =
        (count(&|p, r| lab.ping_fault(p, r).is_some()), count(&|p, r| lab.click_fault(p, r).is_some()));
    assert!((pings - 0.3).abs() < 0.05 && (clicks - 0.2).abs() < 0.05, "{pings} {clicks}");
    // A bad record is bad: it differs from the same record of a laboratory without faults.
    truth.faults.pings = 0.0;
    let good = self::lab(&["C3"], 40, 1, &truth);
    let bad = (0..40).find(|r| lab.ping_fault(0, *r).is_some()).unwrap();
    let fine = (0..40).find(|r| lab.ping_fault(0, *r).is_none()).unwrap();
    assert_ne!(lab.ping(0, bad).unwrap(), good.ping(0, bad).unwrap());
    assert_eq!(lab.ping(0, fine).unwrap(), good.ping(0, fine).unwrap());
}

#[test]
fn exact_sweeps_depend_on_seed_and_name_alone() {
    let written = |name: &str, seed: u64, repeats: u32| {
        let campaign = TubeCampaign::juniper_yoko_2022();
        let points = campaign.row("C3").take(1).cloned().collect();
        let small = TubeCampaign { points, ..campaign };
        let mut truth = Truth::standard();
        truth.loudspeaker.sweep_s = 0.3;
        let lab =
            VirtualRig::new(&TubeRig::juniper_yoko_2022(), &small, &truth, &[], Some(repeats), seed).unwrap();
        let folder = std::env::temp_dir().join(format!("rijke-lab-sweeps-{}-{name}", std::process::id()));
        let count = std::sync::atomic::AtomicUsize::new(0);
        let written = |more: usize| {
            count.fetch_add(more, std::sync::atomic::Ordering::Relaxed);
        };
        lab.write_sweeps(&folder, [150.0, 300.0], &written).unwrap();
        assert_eq!(count.into_inner(), lab.sweep_count());
        let id = &lab.set().points[0].point.id;
        let read = |file: String| std::fs::read(folder.join(file)).unwrap();
        let found = [
            read(format!("{id}/sweep-01.wav")),
            read("calibration/switched-3.wav".into()),
            read("manifest.toml".into()),
        ];
        std::fs::remove_dir_all(&folder).unwrap();
        found
    };
    let [few, many, other] = [written("few", 1, 2), written("many", 1, 3), written("other", 2, 2)];
    assert!(few[..2] == many[..2] && few[0] != other[0]);
    let text = String::from_utf8(few[2].clone()).unwrap();
    assert!(text.contains("kind = \"virtual\"") && text.matches("[[sweep.switched]]").count() == 7, "{text}");
}
