//! The same records in WAV, CSV, MATLAB 5, MATLAB 7.3 and HDF5 give the same observations, byte by byte. What
//! h5py and SciPy write is in `fixtures/records`; here the files are made by hand, as short as the formats
//! allow.

use crate::{rijke, scratch};
use rijke_rig::{RecordFolder, RecordSource};
use std::{fs, path::Path};

#[test]
fn exact_records_in_every_format_give_the_same_observations() {
    let folder = scratch("formats");
    let campaign = "name = \"two\"\n[[row]]\nid = \"C3\"\nplates = false\nthermometers = false\npower_w = 0.0\nrepeats = 2\n\
                    empty_tube = true\npositions_cm = [15, 35, 55, 75]\n";
    fs::write(folder.join("campaign.toml"), campaign).unwrap();
    let run = |words: &str| {
        let output = rijke(&folder, &words.split(' ').collect::<Vec<_>>());
        assert!(output.status.success(), "{words}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    run("lab --campaign campaign.toml --seed 4 --out wav");
    let said = run("process wav --out from-wav");
    let source = RecordFolder::open(&folder.join("wav")).unwrap();
    for (name, ending, line, write) in [
        ("csv", "csv", "", write_csv as fn(&Path, &[Vec<f64>])),
        ("mat5", "mat", "arrays = { names = [\"p\"] }\n", write_mat5),
        ("mat73", "mat", "arrays = { names = [\"p\"] }\n", write_mat73),
        ("hdf5", "h5", "arrays = { names = [\"run/left\", \"run/right\"] }\n", write_hdf5),
    ] {
        let target = folder.join(name);
        fs::create_dir(&target).unwrap();
        for file in ["rig.toml", "campaign.csv", "tube.toml"] {
            fs::copy(folder.join("wav").join(file), target.join(file)).unwrap();
        }
        let manifest = fs::read_to_string(folder.join("wav/manifest.toml")).unwrap();
        let manifest = manifest.replace(".wav\"", &format!(".{ending}\"")).replacen(
            "\nchannels",
            &format!("\n{line}channels"),
            1,
        );
        fs::write(target.join("manifest.toml"), manifest).unwrap();
        let set = source.set();
        let save = |wav: &str, channels: &[Vec<f64>]| {
            let path = target.join(wav).with_extension(ending);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            write(&path, channels);
        };
        for (k, point) in set.points.iter().enumerate() {
            point.pings.iter().enumerate().for_each(|(r, f)| save(f, &source.ping(k, r).unwrap().channels));
            point.clicks.iter().enumerate().for_each(|(r, f)| save(f, &source.click(k, r).unwrap().channels));
        }
        for (k, calibration) in set.calibrations.iter().enumerate() {
            let clicks = calibration.clicks.iter().enumerate();
            clicks.for_each(|(r, f)| save(f, &source.calibration(k, r).unwrap().channels));
        }
        assert!(run(&format!("process {name} --out from-{name}")) == said, "{name}: another table");
        for file in fs::read_dir(folder.join("from-wav")).unwrap() {
            let file = file.unwrap();
            // It names the records, which differ.
            if file.file_name() == "made_of.json" {
                continue;
            }
            let same = fs::read(folder.join(format!("from-{name}")).join(file.file_name())).unwrap();
            let wav = String::from_utf8(fs::read(file.path()).unwrap()).unwrap();
            // Rejections name the file.
            let wav = wav.replace(".wav", &format!(".{ending}"));
            assert!(same == wav.into_bytes(), "{name}: {} differs", file.path().display());
        }
        // The comparison can fail.
        let pings = fs::read_to_string(folder.join(format!("from-{name}/pings.csv"))).unwrap();
        assert!(pings.lines().count() == 6, "{pings}");
    }
}

fn write_csv(path: &Path, channels: &[Vec<f64>]) {
    let row = |n: usize| channels.iter().map(|c| c[n].to_string()).collect::<Vec<_>>().join(",") + "\n";
    fs::write(path, (0..channels[0].len()).map(row).collect::<String>()).unwrap();
}

/// Header, one array of doubles, channels in rows (MATLAB counts column by column).
fn write_mat5(path: &Path, channels: &[Vec<f64>]) {
    let (rows, columns) = (channels.len() as u32, channels[0].len() as u32);
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend(0x0100u16.to_le_bytes());
    bytes.extend(b"IM");
    let data = 8 * rows * columns;
    let words = |bytes: &mut Vec<u8>, words: &[u32]| words.iter().for_each(|w| bytes.extend(w.to_le_bytes()));
    words(
        &mut bytes,
        &[14, 16 + 16 + 16 + 8 + data, 6, 8, 6, 0, 5, 8, rows, columns, 1, 1, u32::from(b'p'), 0, 9, data],
    );
    for n in 0..columns as usize {
        channels.iter().for_each(|c| bytes.extend(c[n].to_le_bytes()));
    }
    fs::write(path, bytes).unwrap();
}

/// HDF5 behind 512 bytes of MATLAB's.
fn write_mat73(path: &Path, channels: &[Vec<f64>]) {
    let mut file = hdf5_pure::FileBuilder::new();
    let all: Vec<f64> = channels.concat();
    file.with_userblock(512);
    file.create_dataset("p")
        .with_f64_data(&all)
        .with_shape(&[channels.len() as u64, channels[0].len() as u64]);
    let mut bytes = file.finish().unwrap();
    bytes[..19].copy_from_slice(b"MATLAB 7.3 MAT-file");
    fs::write(path, bytes).unwrap();
}

/// Two arrays in a group: the first three channels, and the others.
fn write_hdf5(path: &Path, channels: &[Vec<f64>]) {
    let mut file = hdf5_pure::FileBuilder::new();
    let mut group = file.create_group("run");
    for (name, part) in [("left", &channels[..3]), ("right", &channels[3..])] {
        // A row per sample.
        let all: Vec<f64> = (0..part[0].len()).flat_map(|n| part.iter().map(move |c| c[n])).collect();
        group.create_dataset(name).with_f64_data(&all).with_shape(&[part[0].len() as u64, part.len() as u64]);
    }
    file.add_group(group.finish());
    fs::write(path, file.finish().unwrap()).unwrap();
}
