//! Pieces of HTML.

use std::fmt::Write as _;

/// `text` with the letters of the markup escaped.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// A section of the page.
pub(super) fn section(title: &str, body: &str) -> String {
    format!("<section>\n<h2>{title}</h2>\n{body}</section>\n")
}

/// A paragraph of plain text.
pub(super) fn paragraph(class: &str, text: &str) -> String {
    format!("<p class=\"{class}\">{}</p>\n", escape(text))
}

/// A list of plain sentences.
pub(super) fn list(items: &[String]) -> String {
    let mut text = String::from("<ul>\n");
    for item in items {
        let _ = writeln!(text, "<li>{}</li>", escape(item));
    }
    text + "</ul>\n"
}

/// A figure with its caption. An SVG inside HTML needs no name space.
pub(super) fn figure(svg: &str, caption: &str) -> String {
    let svg = svg.replacen(r#" xmlns="http://www.w3.org/2000/svg""#, "", 1);
    format!(
        "<figure>\n<div class=\"scroll\">\n{svg}</div>\n<figcaption>{}</figcaption>\n</figure>\n",
        escape(caption)
    )
}

/// A table from markup: heads, and rows of a head and cells.
pub(super) fn table(class: &str, heads: &[String], rows: &[(String, Vec<String>)]) -> String {
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
pub(super) fn cell(markup: &str) -> String {
    format!("<td>{markup}</td>")
}

/// A symbol of the tables, `C_θ`, with its index below.
pub(super) fn symbol(text: &str) -> String {
    match text.split_once('_') {
        Some((letter, index)) => format!("<i>{}</i><sub>{}</sub>", escape(letter), escape(index)),
        None => format!("<i>{}</i>", escape(text)),
    }
}
