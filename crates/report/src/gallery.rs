//! A page that holds little but pictures.

/// An HTML page with a heading. `body` is HTML; pictures in it are named relative to the page.
///
/// ```
/// let page = rijke_report::gallery("Priors", "<p><img src=\"tube.svg\" alt=\"tube\"></p>\n");
/// assert!(page.contains("<h1>Priors</h1>") && page.ends_with("</html>\n"));
/// ```
#[must_use]
pub fn gallery(title: &str, body: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
         <style>body {{ font-family: sans-serif; max-width: 75em; margin: 1em auto; padding: 0 1em }} \
         img {{ max-width: 100% }} table {{ border-collapse: collapse }} \
         td, th {{ padding: 0.15em 0.8em; text-align: right }} td:first-child {{ text-align: left }}</style>\n\
         <h1>{title}</h1>\n{body}</html>\n"
    )
}
