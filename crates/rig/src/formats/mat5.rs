//! MATLAB's file format of versions 5 to 7: a header of 128 bytes, then elements of a tag and data, each
//! perhaps compressed by zlib ("MAT-File Format", The MathWorks, R2019b). Numeric arrays and fields of single
//! structures are read; all else is listed.

use super::array::{Array, Contents, LARGEST};
use std::io::Read;

/// Structures inside structures are followed this far.
const DEPTH: usize = 8;

/// Types of data, with the bytes of one number.
const COMPRESSED: u32 = 15;
const MATRIX: u32 = 14;

/// Classes of arrays.
const CELL: u8 = 1;
const STRUCTURE: u8 = 2;
const DOUBLE: u8 = 6;

/// Reads the arrays of a file.
pub(crate) fn read(bytes: &[u8]) -> Result<Contents, String> {
    if !bytes.starts_with(b"MATLAB 5.0 MAT-file") {
        return Err("it begins neither as MATLAB 5 nor as HDF5".into());
    }
    let header = bytes.get(..128).ok_or("it ends inside its header")?;
    let big = match &header[126..128] {
        b"IM" => false,
        b"MI" => true,
        _ => return Err("its header has no mark of byte order".into()),
    };
    let mut contents = Contents { format: "MATLAB 5", ..Contents::default() };
    let mut rest = Bytes { bytes: &bytes[128..], big };
    while !rest.bytes.is_empty() {
        let (kind, data) = rest.element()?;
        match kind {
            COMPRESSED => {
                let mut inflated = Vec::new();
                let failed = |_| "a compressed array is damaged or cut off".to_owned();
                // A megabyte of zeros packs into a kilobyte.
                let unpacked =
                    flate2::read::ZlibDecoder::new(data).take(LARGEST + 1).read_to_end(&mut inflated);
                if unpacked.map_err(failed)? as u64 > LARGEST {
                    return Err(format!("an array unpacks to more than {} MiB", LARGEST >> 20));
                }
                let (kind, data) = Bytes { bytes: &inflated, big }.element()?;
                if kind == MATRIX {
                    matrix(Bytes { bytes: data, big }, None, 0, &mut contents)?;
                }
            }
            MATRIX => matrix(Bytes { bytes: data, big }, None, 0, &mut contents)?,
            _ => {}
        }
    }
    Ok(contents)
}

/// One array, called `outer` if it is a field (whose own name is empty).
fn matrix(
    mut rest: Bytes<'_>,
    outer: Option<String>,
    depth: usize,
    into: &mut Contents,
) -> Result<(), String> {
    if rest.bytes.is_empty() {
        return Ok(()); // an empty field
    }
    let flags = rest.element()?.1;
    let flags = rest.u32(flags.get(..4).ok_or("an array without flags")?);
    let (class, complex) = ((flags & 0xff) as u8, flags & 0x800 != 0);
    let sizes = rest.element()?.1;
    let sizes: Vec<usize> = sizes.chunks_exact(4).map(|b| rest.u32(b) as usize).collect();
    let own = String::from_utf8_lossy(rest.element()?.1).into_owned();
    let name = outer.unwrap_or(own);
    let shown = || sizes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" x ");
    if class == STRUCTURE && sizes.iter().all(|n| *n == 1) && depth < DEPTH {
        return structure(rest, &name, depth, into);
    }
    let numeric = (DOUBLE..=15).contains(&class);
    if !numeric || complex || sizes.len() != 2 {
        let kind = match class {
            _ if numeric && complex => "complex",
            _ if numeric => "numbers",
            CELL => "cell",
            STRUCTURE => "structure",
            4 => "text",
            _ => "neither numbers nor text",
        };
        into.others.push(format!("{name} ({}, {kind})", shown()));
        return Ok(());
    }
    let (kind, data) = rest.element()?;
    let values = rest.numbers(kind, data)?;
    if sizes[0].checked_mul(sizes[1]) != Some(values.len()) {
        return Err(format!("{name} announces {} values and has {}", shown(), values.len()));
    }
    let bits = match class {
        8 => Some(7),
        10 => Some(15),
        12 => Some(31),
        14 => Some(63),
        _ => None,
    };
    let largest = bits.map(|bits| 2f64.powi(bits));
    into.arrays.push(Array { name, rows: sizes[0], columns: sizes[1], values, largest });
    Ok(())
}

/// The fields of a structure, as `name.field`.
fn structure(mut rest: Bytes<'_>, name: &str, depth: usize, into: &mut Contents) -> Result<(), String> {
    let length = rest.element()?.1;
    let length = rest.u32(length.get(..4).ok_or("a structure without names")?) as usize;
    let names = rest.element()?.1;
    if length == 0 {
        return Ok(());
    }
    for field in names.chunks_exact(length) {
        let field = field.split(|b| *b == 0).next().unwrap_or_default();
        let field = format!("{name}.{}", String::from_utf8_lossy(field));
        let (_, data) = rest.element()?;
        matrix(Bytes { bytes: data, big: rest.big }, Some(field), depth + 1, into)?;
    }
    Ok(())
}

/// What is left to read.
struct Bytes<'a> {
    bytes: &'a [u8],
    big: bool,
}

impl<'a> Bytes<'a> {
    fn u32(&self, bytes: &[u8]) -> u32 {
        let bytes = [bytes[0], bytes[1], bytes[2], bytes[3]];
        if self.big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
    }

    /// Type and data of the next element. Up to four bytes of data may stand inside the tag.
    fn element(&mut self) -> Result<(u32, &'a [u8]), String> {
        let ended = || "it ends in the middle of an array: it is truncated".to_owned();
        let tag = self.bytes.get(..8).ok_or_else(ended)?;
        let (first, second) = (self.u32(&tag[..4]), self.u32(&tag[4..]) as usize);
        let (kind, start, length, next) = if first >> 16 != 0 {
            (first & 0xffff, 4, (first >> 16) as usize, 8)
        } else {
            // All but compressed data are filled up to eight bytes.
            let filled = if first == COMPRESSED { second } else { second.div_ceil(8) * 8 };
            (first, 8, second, 8 + filled)
        };
        if length > 4 && start == 4 {
            return Err("an element is damaged".into());
        }
        let data = self.bytes.get(start..start + length).ok_or_else(ended)?;
        self.bytes = self.bytes.get(next..).unwrap_or_default();
        Ok((kind, data))
    }

    /// Numbers of any type as f64.
    fn numbers(&self, kind: u32, data: &[u8]) -> Result<Vec<f64>, String> {
        macro_rules! each {
            ($type:ty) => {{
                let number = |bytes: &[u8]| {
                    let mut all = [0; size_of::<$type>()];
                    all.copy_from_slice(bytes);
                    if self.big { <$type>::from_be_bytes(all) } else { <$type>::from_le_bytes(all) }
                };
                data.chunks_exact(size_of::<$type>()).map(|b| number(b) as f64).collect()
            }};
        }
        Ok(match kind {
            1 => each!(i8),
            2 => each!(u8),
            3 => each!(i16),
            4 => each!(u16),
            5 => each!(i32),
            6 => each!(u32),
            7 => each!(f32),
            9 => each!(f64),
            12 => each!(i64),
            13 => each!(u64),
            _ => return Err(format!("numbers of the unknown type {kind}")),
        })
    }
}
