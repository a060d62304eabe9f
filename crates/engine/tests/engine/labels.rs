//! Labels of modes that jump between operating points, on a tube whose modes have a closed form.

use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_engine::run::{Run, Trusted};
use rijke_study::Study;

/// The remark of the model on modes of the given orders, labelled `1` and `2` at each of three lengths.
fn remark(name: &str, orders: [[u8; 2]; 3]) -> Option<String> {
    let row = |id: &str, length: f64, label: usize, n: u8| {
        let c = speed();
        format!(
            "{id},{label},{:.12},1,{:.12},0.5\n",
            c * 0.85_f64.ln() / length,
            f64::from(n) * 0.5 * c / length
        )
    };
    let points = [("a", 1.0), ("b", 0.9), ("c", 0.75)];
    let both = |((id, length), orders): (&(&str, f64), &[u8; 2])| {
        [1, 2].map(|label| row(id, *length, label, orders[label - 1])).concat()
    };
    let head = "point,mode,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    let modes = [head.to_owned()].into_iter().chain(points.iter().zip(&orders).map(both)).collect::<String>();
    let folder = Folder::new(
        &format!("labels-{name}"),
        &[
            ("rig.toml", TUBE),
            ("campaign.csv", "point,x [cm],T_amb [degC]\na,100,20\nb,90,20\nc,75,20\n"),
            ("study.toml", "name = \"t\"\n[[stage]]\nid = \"s\"\npoints = {}\n"),
            ("observations/observations.toml", "kind = \"virtual\"\nsource = \"closed form\"\n"),
            ("observations/modes.csv", &modes),
        ],
    );
    let study = Study::open(&folder.0).unwrap();
    let mut run = Run::new(study.clone(), &study.observations().unwrap(), Trusted::Laplace).unwrap();
    run.next_stage().unwrap().unwrap().models.remove(0).remark
}

#[test]
fn message_labels_that_jump_are_named() {
    let same = remark("same", [[1, 2], [1, 2], [1, 2]]);
    assert!(!same.as_ref().is_some_and(|said| said.contains("inconsistent")), "{same:?}");
    // By the order of frequency, where the first mode was not heard at the second point.
    let jump = remark("jump", [[1, 2], [2, 3], [1, 2]]).unwrap();
    let wanted = "labels of modes are inconsistent: mode `1` of point b, followed to a, is the one labelled `2` there, and 2 more like this";
    assert!(jump.contains(wanted), "{jump}");
}
