//! HDF5, and the files of MATLAB 7.3, which are HDF5 behind 512 bytes of MATLAB's.

use super::array::{Array, Contents};
use hdf5_pure::{AttrValue, DType, Dataset, File, Group};

/// Groups inside groups are followed this far.
const DEPTH: usize = 8;

/// Deflate packs no more than 1032 bytes into one ("Maximum Compression Factor", zlib): a file cannot hold
/// more values than this per byte. The library makes room for as many as a file announces, and a damaged one
/// may announce 10^13.
const DENSEST: usize = 1032;

/// Reads the arrays of a file; one in a group is called `group/array`.
pub(crate) fn read(bytes: Vec<u8>) -> Result<Contents, String> {
    let format = if bytes.starts_with(b"MATLAB") { "MATLAB 7.3" } else { "HDF5" };
    let most = DENSEST * bytes.len();
    let file = File::from_bytes(bytes).map_err(|e| e.to_string())?;
    let mut contents = Contents { format, ..Contents::default() };
    group(&file.root(), "", 0, most, &mut contents)?;
    Ok(contents)
}

fn group(group: &Group, path: &str, depth: usize, most: usize, into: &mut Contents) -> Result<(), String> {
    let failed = |name: &str| {
        let name = format!("{path}{name}");
        let place = if name.is_empty() { String::new() } else { format!("{name}: ") };
        move |error: hdf5_pure::Error| format!("{place}{error}")
    };
    for name in group.datasets().map_err(failed(""))? {
        let dataset = group.dataset(&name).map_err(failed(&name))?;
        let shape = dataset.shape().map_err(failed(&name))?;
        let count = shape.iter().try_fold(1_u64, |all, n| all.checked_mul(*n));
        if count.is_none_or(|count| count > most as u64) {
            let sizes = shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(" x ");
            return Err(format!(
                "{path}{name}: announces {sizes} values, more than the file can hold: it is damaged"
            ));
        }
        array(&dataset, &shape, format!("{path}{name}"), into).map_err(failed(&name))?;
    }
    for name in group.groups().map_err(failed(""))? {
        // What MATLAB refers to, such as cells, has no name of its own.
        if name.starts_with('#') || depth == DEPTH {
            continue;
        }
        let inner = group.group(&name).map_err(failed(&name))?;
        self::group(&inner, &format!("{path}{name}/"), depth + 1, most, into)?;
    }
    Ok(())
}

fn array(
    dataset: &Dataset,
    shape: &[u64],
    name: String,
    into: &mut Contents,
) -> Result<(), hdf5_pure::Error> {
    let kind = dataset.dtype()?;
    let largest = match kind {
        DType::F32 | DType::F64 | DType::U8 | DType::U16 | DType::U32 | DType::U64 => None,
        DType::I8 => Some(7),
        DType::I16 => Some(15),
        DType::I32 => Some(31),
        DType::I64 => Some(63),
        _ => Some(0),
    };
    let text = match dataset.attrs()?.get("MATLAB_class") {
        Some(AttrValue::String(class) | AttrValue::AsciiString(class)) => class == "char" || class == "cell",
        _ => false,
    };
    if largest == Some(0) || text || shape.len() > 2 {
        let sizes: Vec<String> = shape.iter().map(ToString::to_string).collect();
        into.others.push(format!(
            "{name} ({}, {})",
            sizes.join(" x "),
            if text { "text".into() } else { kind.to_string() }
        ));
        return Ok(());
    }
    // Row by row here is column by column of the transpose.
    let size = |k: usize| shape.get(k).map_or(1, |n| *n as usize);
    let (rows, columns) = if shape.len() == 2 { (size(1), size(0)) } else { (size(0), 1) };
    let values = dataset.read_f64()?;
    if rows * columns == values.len() {
        into.arrays.push(Array { name, rows, columns, values, largest: largest.map(|bits| 2f64.powi(bits)) });
    }
    Ok(())
}
