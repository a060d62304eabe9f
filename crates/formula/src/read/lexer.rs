//! Text to tokens.

use super::problem::{FormulaProblem, Outcome};
use winnow::ascii::{float, multispace0};
use winnow::combinator::{alt, eof, opt, preceded, repeat_till, terminated};
use winnow::error::ContextError;
use winnow::prelude::*;
use winnow::stream::{LocatingSlice, Location};
use winnow::token::{one_of, take_while};

/// One word of a formula, and where it starts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Token<'a> {
    pub(crate) at: usize,
    pub(crate) kind: Kind<'a>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kind<'a> {
    Number(f64),
    Imaginary(f64),
    Name(&'a str),
    /// One of + - * / ^ ( ).
    Sign(char),
}

type Input<'a> = LocatingSlice<&'a str>;

/// Whether `text` is one name and nothing else.
pub(crate) fn is_name(text: &str) -> bool {
    name.parse(LocatingSlice::new(text)).is_ok()
}

/// All tokens of `source`.
pub(crate) fn tokens(source: &str) -> Outcome<Vec<Token<'_>>> {
    let mut input = LocatingSlice::new(source);
    let all: Result<(Vec<Token<'_>>, _), ContextError> =
        preceded(multispace0, repeat_till(0.., terminated(token, multispace0), eof)).parse_next(&mut input);
    match all {
        Ok((tokens, _)) => Ok(tokens),
        Err(_) => {
            // Everything before the first character that starts no token has been consumed.
            let mut rest = LocatingSlice::new(source);
            let mut at = 0;
            while preceded(multispace0::<_, ContextError>, token).parse_next(&mut rest).is_ok() {
                at = rest.current_token_start();
            }
            let blank = |c: char| matches!(c, ' ' | '\t' | '\r' | '\n');
            let start = source[at..].find(|c: char| !blank(c)).map_or(at, |skip| at + skip);
            let first = source[start..].chars().next().unwrap_or(' ');
            let broken = first.is_ascii_digit();
            Err((start, if broken { FormulaProblem::BrokenNumber } else { FormulaProblem::Character(first) }))
        }
    }
}

fn token<'a>(input: &mut Input<'a>) -> Result<Token<'a>, ContextError> {
    let at = input.current_token_start();
    let kind = alt((number, name, sign)).parse_next(input)?;
    Ok(Token { at, kind })
}

/// Unsigned; a sign is an operator. `inf` and `nan` are names, so a digit or a point must come first.
fn number<'a>(input: &mut Input<'a>) -> Result<Kind<'a>, ContextError> {
    let digits = take_while(1.., |c: char| c.is_ascii_digit() || c == '.');
    winnow::combinator::peek(digits).parse_next(input)?;
    let value: f64 = float.parse_next(input)?;
    // `2i` and `2j` are imaginary; `2in` is a number followed by a name, which the parser refuses.
    let next_is_name = |c: char| c.is_alphanumeric() || c == '_';
    let unit = opt(terminated(one_of(['i', 'j']), winnow::combinator::not(one_of(next_is_name))))
        .parse_next(input)?;
    Ok(if unit.is_some() { Kind::Imaginary(value) } else { Kind::Number(value) })
}

/// A word, or two with a point between them.
fn name<'a>(input: &mut Input<'a>) -> Result<Kind<'a>, ContextError> {
    (word, opt(('.', word))).take().map(Kind::Name).parse_next(input)
}

fn word<'a>(input: &mut Input<'a>) -> Result<&'a str, ContextError> {
    (
        one_of(|c: char| c.is_alphabetic() || c == '_'),
        take_while(0.., |c: char| c.is_alphanumeric() || c == '_'),
    )
        .take()
        .parse_next(input)
}

fn sign<'a>(input: &mut Input<'a>) -> Result<Kind<'a>, ContextError> {
    alt(("**".value('^'), one_of(['+', '-', '*', '/', '^', '(', ')']))).map(Kind::Sign).parse_next(input)
}
