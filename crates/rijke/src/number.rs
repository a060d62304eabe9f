//! Numbers of the command line. Every option that takes a real number names one of these as its parser.

use clap::Command;

/// A number that is neither infinite nor undefined.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "it is not a number".to_owned())?;
    if number.is_finite() { Ok(number) } else { Err("it must be finite".to_owned()) }
}

/// A finite number above zero.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let number = finite(text)?;
    if number > 0.0 { Ok(number) } else { Err("it must be positive".to_owned()) }
}

/// A finite number that is zero or above.
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    let number = finite(text)?;
    if number >= 0.0 { Ok(number) } else { Err("it must not be negative".to_owned()) }
}

/// Lets every option take what looks like a negative number, so that `--mains -50` is judged as a number and
/// not taken for an option of that name.
pub(crate) fn negative_is_no_option(command: Command) -> Command {
    let command = command.mut_args(|arg| {
        let numbers = arg.get_action().takes_values() && !arg.is_positional();
        arg.allow_negative_numbers(numbers)
    });
    command.mut_subcommands(negative_is_no_option)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Program;
    use clap::{CommandFactory, builder::ValueParser, error::ErrorKind};

    #[test]
    fn behaviour_numbers_are_judged_as_they_are_read() {
        assert_eq!((finite("-1e3"), positive("50"), not_negative("0")), (Ok(-1e3), Ok(50.0), Ok(0.0)));
        for text in ["nan", "NaN", "inf", "-inf", "infinity", "1e999", "", "fifty"] {
            assert!(finite(text).is_err() && positive(text).is_err(), "{text}");
        }
        assert!(positive("0").is_err() && positive("-0").is_err() && positive("-50").is_err());
        assert!(not_negative("-1").is_err() && not_negative("-0.0").is_ok());
    }

    /// No command has an option that takes a real number unjudged, or takes a negative number for an option.
    #[test]
    fn behaviour_every_option_of_a_number_refuses_what_is_no_number() {
        let program = negative_is_no_option(Program::command());
        let real = ValueParser::from(finite).type_id();
        let whole = [ValueParser::from(clap::value_parser!(u64)), clap::value_parser!(u32).into()];
        let (mut reals, mut wholes) = (0, 0);
        for command in program.get_subcommands() {
            for option in command.get_opts() {
                let parser = option.get_value_parser().type_id();
                let (is_real, is_whole) = (parser == real, whole.iter().any(|w| w.type_id() == parser));
                (reals, wholes) = (reals + usize::from(is_real), wholes + usize::from(is_whole));
                let texts: &[&str] = match (is_real, is_whole) {
                    (true, _) => &["nan", "inf", "-inf", "x"],
                    (_, true) => &["-1", "nan"],
                    _ => continue,
                };
                let long = format!("--{}", option.get_long().unwrap());
                for text in texts {
                    let values = option.get_num_args().map_or(1, |range| range.min_values().max(1));
                    let words: Vec<&str> =
                        ["rijke", command.get_name(), &long].into_iter().chain(vec![*text; values]).collect();
                    let refused = program.clone().try_get_matches_from(&words).unwrap_err();
                    // What begins like an option and is no number is refused as an option.
                    let as_option = *text == "-inf" && refused.kind() == ErrorKind::UnknownArgument;
                    let as_value = refused.kind() == ErrorKind::ValueValidation;
                    assert!(as_value || as_option, "{words:?}: {refused}");
                }
            }
        }
        assert!(reals >= 8 && wholes >= 4, "{reals} real, {wholes} whole");
    }
}
