//! Files of named arrays: MATLAB, HDF5.

use super::array::{Array, Contents, LARGEST};
use super::mat5;
use crate::error::RigError;
use crate::problem::Problem;
use rijke_numerics::{open_file, read_bytes};
use std::io::Read;
use std::path::Path;

/// Whether the file holds arrays; told by its first bytes, since both kinds of MATLAB file end in `.mat`.
pub(crate) fn is_file_of_arrays(path: &Path) -> Result<bool, RigError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let mut head = [0; 8];
    let mut file = open_file(path).map_err(RigError::read(path))?;
    let signed = file.read_exact(&mut head).is_ok() && (head == *HDF5 || head.starts_with(b"MATLAB"));
    Ok(signed || matches!(extension.as_str(), "mat" | "h5" | "hdf5" | "hdf"))
}

/// First bytes of an HDF5 file; in a MATLAB 7.3 file they come after 512 bytes of MATLAB's.
const HDF5: &[u8; 8] = b"\x89HDF\r\n\x1a\n";

/// Reads all arrays of a file.
pub(crate) fn read_arrays(path: &Path) -> Result<Contents, RigError> {
    let bytes = read_bytes(path, LARGEST).map_err(RigError::read(path))?;
    let bad = |reason: String| RigError::invalid(path, "contents", Problem::BadArrays { reason });
    if bytes.starts_with(HDF5) || bytes.get(512..520) == Some(HDF5) {
        #[cfg(feature = "hdf5")]
        return super::hdf5::read(bytes).map_err(bad);
        #[cfg(not(feature = "hdf5"))]
        return Err(bad("this program was built without the feature hdf5".into()));
    }
    mat5::read(&bytes).map_err(bad)
}

/// All vectors of a MATLAB or HDF5 file with their names; of a matrix `m` those are `m[0]`, `m[1]`.
///
/// # Errors
/// [`RigError`] for a file that cannot be read or is of neither format.
pub fn named_columns(path: &Path) -> Result<Vec<(String, Vec<f64>)>, RigError> {
    let contents = read_arrays(path)?;
    let vectors = contents.arrays.iter().flat_map(|a| (0..a.channels()).map(move |c| (a, c)));
    Ok(vectors.map(|(a, c)| (heading((a, c)), (0..a.samples()).map(|n| a.at(c, n)).collect())).collect())
}

/// Name of one channel of an array.
pub(crate) fn heading((array, channel): (&Array, usize)) -> String {
    if array.channels() > 1 { format!("{}[{channel}]", array.name) } else { array.name.clone() }
}
