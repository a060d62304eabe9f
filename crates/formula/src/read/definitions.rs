//! Named parts of a formula: each is read once, and its tree stands wherever its name does.

use super::parser::{self, Definition};
use super::problem::{FormulaError, FormulaProblem, NameError, Outcome};
use super::scope::Context;
use super::{lexer, tree::Tree};

/// The tree of the formula `source`, its definitions put in.
///
/// A definition may use only those before it, so there are no circles. Each must be used by a later one or
/// by the formula, so each enters the formula in the end.
pub(crate) fn tree(source: &str, context: &Context<'_>) -> Result<Tree, FormulaError> {
    let mut before: Vec<Definition<'_>> = Vec::with_capacity(context.definitions.len());
    for (name, text) in context.definitions {
        check_name(name, context, &before).map_err(|e| in_definition(name, text, e))?;
        let (tree, words) = read(text, context, &mut before).map_err(|e| in_definition(name, text, e))?;
        before.push(Definition { name, tree, words, used: false });
    }
    let (tree, _) = read(source, context, &mut before).map_err(|e| fault(source, None, e))?;
    for (definition, (name, text)) in before.iter().zip(context.definitions) {
        if !definition.used {
            return Err(in_definition(
                name,
                text,
                (0, FormulaProblem::UnusedDefinition { name: name.clone() }),
            ));
        }
    }
    Ok(tree)
}

fn read(text: &str, context: &Context<'_>, before: &mut [Definition<'_>]) -> Outcome<(Tree, usize)> {
    parser::parse(&lexer::tokens(text)?, text.len(), context, before)
}

fn check_name(name: &str, context: &Context<'_>, before: &[Definition<'_>]) -> Outcome<()> {
    let double = |meaning: &str| NameError::Double { name: name.to_owned(), meaning: meaning.to_owned() };
    let checked = if context.parameters.iter().any(|p| p == name) {
        Err(double("a parameter"))
    } else if before.iter().any(|d| d.name == name) {
        Err(double("another definition"))
    } else {
        context.scope.check(name)
    };
    checked.map_err(|error| (0, FormulaProblem::DefinitionName(error)))
}

fn in_definition(name: &str, text: &str, found: (usize, FormulaProblem)) -> FormulaError {
    fault(text, Some(name.to_owned()), found)
}

fn fault(text: &str, definition: Option<String>, (at, problem): (usize, FormulaProblem)) -> FormulaError {
    FormulaError { source_text: text.to_owned(), definition, at, problem: Box::new(problem) }
}
