//! What is wrong with the columns of a text file, beside what the manifest says of them.

/// Columns that are not what the manifest says.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ColumnFault {
    /// Channels are listed by name, and the line of names is not read.
    #[error(
        "`channels` lists columns by name, and no line of names follows the {lines} lines that `header_lines` passes over: the line of \
         names must not be among them; count the lines before it alone"
    )]
    NamesPassedOver {
        /// Lines that are passed over.
        lines: usize,
    },
    /// A column that has the name of another microphone than the list says.
    #[error(
        "the column is called `{name}`, which is microphone {named}, and `channels` lists it as microphone {listed}; list columns by name, as \
         in `channels = {{ {name} = {named} }}`, or correct the names in the file"
    )]
    OtherMicrophone {
        /// The name.
        name: String,
        /// The microphone of that name, counted from 0.
        named: usize,
        /// The microphone of the list.
        listed: usize,
    },
    /// Times in another unit than seconds.
    #[error(
        "the time of sample {sample} is {step} s after the one before, and {need} s were expected: the times look like {unit}; write the \
         unit into the heading, as in `t [{symbol}]`"
    )]
    TimeUnit {
        /// The sample, from 0.
        sample: usize,
        /// The step found, s.
        step: f64,
        /// One over the sampling rate, s.
        need: f64,
        /// The unit.
        unit: &'static str,
        /// Its symbol.
        symbol: &'static str,
    },
    /// Channels are listed by name, and the file has no names.
    #[error(
        "the file has no names of columns, and `channels` lists them by name; list them by their place: `channels = [0, 1, -1]`"
    )]
    NoNames,
}
