//! The header of a measurement file of LabVIEW (.lvm): its lines have as many cells as there are channels and
//! hold numbers, so that they look like rows of data.

/// Ends the header of the file, then that of the segment with the data.
const END: &str = "***End_of_Header***";

/// What is known of such a file from its first lines.
pub(crate) struct LabviewHeader {
    /// Lines before the names of the columns.
    pub(crate) lines: usize,
    /// Units of the columns, time first; empty where the file does not state them.
    pub(crate) units: Vec<String>,
}

impl LabviewHeader {
    /// That of a file with these lines; none if LabVIEW did not write it so.
    pub(crate) fn of(lines: &[String]) -> Option<Self> {
        lines.first().filter(|first| first.trim_end() == "LabVIEW Measurement")?;
        let last = lines.iter().rposition(|line| line.starts_with(END))?;
        let units = lines[..last].iter().rfind(|line| line.starts_with("Y_Unit_Label"));
        let units = units.map_or_else(Vec::new, |line| {
            let of_channels = line.split('\t').skip(1).map(str::trim).map(str::to_owned);
            std::iter::once("s".to_owned()).chain(of_channels).collect()
        });
        Some(Self { lines: last + 1, units })
    }
}
