//! What a file of records holds, whatever its format: `cargo run --release -p rijke-rig --example
//! inspect_record -- FILE`.
#![allow(clippy::print_stdout, reason = "an example shows its results")]

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).ok_or("name a WAV, text, MATLAB or HDF5 file")?;
    let contents = rijke_rig::inspect(file.as_ref())?;
    println!("{}, sampling rate {:?} Hz", contents.format, contents.rate_hz);
    for (k, channel) in contents.channels.iter().enumerate() {
        let name = channel.name.as_deref().unwrap_or("without a name");
        println!("column {k}, {name}: {} samples, root mean square {:.4e}", channel.samples, channel.rms);
    }
    for other in contents.others {
        println!("also: {other}");
    }
    Ok(())
}
