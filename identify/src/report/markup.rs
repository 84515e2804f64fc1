//! Pieces of HTML.

use std::fmt::Write as _;

/// `text` with the letters of the markup escaped.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// What a page begins with: everything up to its heading, the style within.
pub(crate) fn head(heading: &str, title: &str) -> String {
    [
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n",
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n",
        &format!("<title>{}</title>\n", escape(title)),
        &format!("<style>\n{}</style>\n</head>\n", include_str!("style.css")),
        &format!("<body>\n<main>\n<h1>{}</h1>\n", escape(heading)),
    ]
    .concat()
}

/// What it ends with.
pub(crate) const FOOT: &str = "</main>\n</body>\n</html>\n";

/// A section of the page.
pub(crate) fn section(title: &str, body: &str) -> String {
    format!("<section>\n<h2>{title}</h2>\n{body}</section>\n")
}

/// A paragraph of plain text.
pub(crate) fn paragraph(class: &str, text: &str) -> String {
    format!("<p class=\"{class}\">{}</p>\n", escape(text))
}

/// A list of plain sentences.
pub(crate) fn list(items: &[String]) -> String {
    let mut text = String::from("<ul>\n");
    for item in items {
        let _ = writeln!(text, "<li>{}</li>", escape(item));
    }
    text + "</ul>\n"
}

/// A figure with its caption. An SVG inside HTML needs no name space.
pub(crate) fn figure(svg: &str, caption: &str) -> String {
    let svg = svg.replacen(r#" xmlns="http://www.w3.org/2000/svg""#, "", 1);
    format!(
        "<figure>\n<div class=\"scroll\">\n{svg}</div>\n<figcaption>{}</figcaption>\n</figure>\n",
        escape(caption)
    )
}

/// A table from markup: heads, and rows of a head and cells.
pub(crate) fn table(class: &str, heads: &[String], rows: &[(String, Vec<String>)]) -> String {
    let mut text = format!("<div class=\"scroll\">\n<table class=\"{class}\">\n<thead><tr>");
    for head in heads {
        let _ = write!(text, "<th>{head}</th>");
    }
    text += "</tr></thead>\n<tbody>\n";
    for (head, cells) in rows {
        let _ = writeln!(text, "<tr><th>{head}</th>{}</tr>", cells.concat());
    }
    text + "</tbody>\n</table>\n</div>\n"
}

/// A cell from markup.
pub(crate) fn cell(markup: &str) -> String {
    format!("<td>{markup}</td>")
}

/// A symbol of the tables, `C_θ`, with its index below.
pub(crate) fn symbol(text: &str) -> String {
    match text.split_once('_') {
        Some((letter, index)) => format!("<i>{}</i><sub>{}</sub>", escape(letter), escape(index)),
        None => format!("<i>{}</i>", escape(text)),
    }
}
