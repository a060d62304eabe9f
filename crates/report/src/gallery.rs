//! A page that holds little but pictures.

use rijke_draw::escape;
use rijke_draw::{plot_svg, write_figure};
use rijke_numerics::{Failed, write_within};
use rijke_rig::Plot;
use std::path::Path;

/// A folder of pictures, each as SVG and PDF, with a page that shows or lists them. Nobody else writes the
/// folder.
pub struct Gallery<'a> {
    folder: &'a Path,
    body: String,
}

impl<'a> Gallery<'a> {
    /// Begins the page with a piece of HTML.
    pub fn new(folder: &'a Path, html: &str) -> Self {
        Self { folder, body: html.to_owned() }
    }

    /// Shows a picture under its title.
    pub fn show(&mut self, name: &str, plot: &Plot) -> Result<(), Failed> {
        let title = &plot.title;
        self.body += &format!("<h2>{title}</h2>\n<p><img src=\"{name}.svg\" alt=\"{title}\"></p>\n");
        write_figure(self.folder, name, &plot_svg(plot))
    }

    /// Begins a list of pictures.
    pub fn begin_list(&mut self, title: &str) {
        self.body += &format!("<h2>{title}</h2>\n<ul>\n");
    }

    /// Lists a picture, with the reason why its record was rejected.
    pub fn list(&mut self, name: &str, rejected: Option<&str>, plot: &Plot) -> Result<(), Failed> {
        let reason = rejected.map_or(String::new(), |reason| format!(": rejected, {}", escape(reason)));
        self.body += &format!("<li><a href=\"{name}.svg\">{}</a>{reason}</li>\n", escape(name));
        write_figure(self.folder, name, &plot_svg(plot))
    }

    /// Ends the page with a piece of HTML, and writes it.
    pub fn write(self, title: &str, html: &str) -> Result<(), Failed> {
        let page = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
             <style>body {{ font-family: sans-serif; max-width: 75em; margin: 1em auto; padding: 0 1em }} \
             img {{ max-width: 100% }} table {{ border-collapse: collapse }} \
             td, th {{ padding: 0.15em 0.8em; text-align: right }} td:first-child {{ text-align: left }}</style>\n\
             <h1>{title}</h1>\n{}{html}</html>\n",
            self.body
        );
        write_within(self.folder, "index.html", page)
    }
}
