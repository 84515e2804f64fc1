//! Rides beside each other as one HTML file that needs nothing else.

use super::markup::{FOOT, escape, figure, head, paragraph, section};
use super::words::words;

/// The page of a comparison of `channel` of the rides called `what`: its table as plain text, its
/// figure (SVG), and the command as it was typed.
pub fn comparison(what: &str, channel: &str, table: &str, svg: &str, command: &str) -> String {
    let title = format!("{what}: {} compared", words(channel));
    let mut page = head(&title, &title);
    let plain = |text: &str| format!("<pre>{}</pre>\n", escape(text));
    page += &section("Bands", &(plain(table) + &paragraph("text", BANDS)));
    page += &section("Spectra", &figure(svg, SPECTRA));
    let program = concat!("wobble ", env!("CARGO_PKG_VERSION"));
    page += &section(
        "Provenance",
        &(paragraph("text", program) + &plain(command)),
    );
    page + FOOT
}

const BANDS: &str = "A band rises or falls where the 95 % interval of the ratio leaves out 1. The \
    residual is taken for noise: a slalom or pedalling line is none, and is to be masked.";
const SPECTRA: &str = "Amplitudes of sines in the residual of the moving average.";
