//! What may look wrong in a ride, and its words.

use crate::report::number::with_unit;
use crate::ride::Span;
use serde::Serialize;
use std::fmt;

/// Something to know before trusting a ride.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Finding {
    /// The bicycle stands.
    Standstill {
        /// Where.
        spans: Vec<Span>,
    },
    /// A speed below 0.
    Backwards {
        /// The lowest [m/s].
        speed: f64,
    },
    /// A channel larger than that of any bicycle that is ridden.
    Improbable {
        /// The channel.
        channel: &'static str,
        /// Root mean square [SI].
        rms: f64,
        /// What it stays below where somebody rides [SI].
        most: f64,
        /// SI unit.
        unit: &'static str,
    },
    /// A channel that says nothing.
    Constant {
        /// The channel.
        channel: &'static str,
        /// Its only value [SI].
        value: f64,
        /// SI unit.
        unit: &'static str,
    },
    /// Single samples far off both their neighbours.
    Glitch {
        /// The channel.
        channel: &'static str,
        /// How many.
        count: usize,
        /// The farthest value [SI].
        value: f64,
        /// SI unit.
        unit: &'static str,
        /// Where the farthest is.
        at: Span,
    },
    /// A channel in steps, as encoders give it.
    Quantised {
        /// The channel.
        channel: &'static str,
        /// The step [SI].
        step: f64,
        /// Standard deviation of the noise that rounding to it makes, step/√12 [SI] (Bennett 1948).
        noise: f64,
        /// SI unit.
        unit: &'static str,
    },
    /// A recording that stood still and then jumped, or fell to a value and came back.
    Dropout {
        /// The channels that did.
        channels: Vec<&'static str>,
        /// How often.
        count: usize,
        /// The longest stretch.
        span: Span,
    },
    /// A mean that wanders over the ride, as of a gyroscope that warms up.
    Drift {
        /// The channel.
        channel: &'static str,
        /// By how much over the ride [SI].
        change: f64,
        /// SI unit.
        unit: &'static str,
    },
    /// A sine that stands out of the spectrum: pedalling, a slalom, or a test signal.
    Line {
        /// The channel.
        channel: &'static str,
        /// Frequency [Hz].
        frequency: f64,
        /// Amplitude of the sine [SI].
        amplitude: f64,
        /// SI unit.
        unit: &'static str,
        /// Distance [m] of cones that would be passed alternately at that frequency, where the
        /// speed is recorded.
        cones: Option<f64>,
    },
    /// A channel that runs into its largest or smallest value and stays there.
    Clipped {
        /// The channel.
        channel: &'static str,
        /// The value [SI].
        value: f64,
        /// SI unit.
        unit: &'static str,
        /// The longest stretch.
        span: Span,
    },
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Standstill { spans } => standstill(spans, f),
            Self::Backwards { speed } => write!(
                f,
                "speed: down to {speed:.3} m/s, backwards: is the sign of the column right?"
            ),
            Self::Improbable {
                channel,
                rms,
                most,
                unit,
            } => write!(
                f,
                "{channel}: {rms:.3} {unit} rms, where a ridden bicycle stays below {most} {unit}: \
                 degrees under another name?"
            ),
            Self::Constant {
                channel,
                value,
                unit,
            } => {
                write!(f, "{channel}: {value} {unit} throughout")
            }
            Self::Glitch {
                channel,
                count,
                value,
                unit,
                at,
            } => match count {
                1 => write!(f, "{channel}: a glitch, {value} {unit} in {at}"),
                n => write!(
                    f,
                    "{channel}: {n} glitches, the farthest {value} {unit} in {at}"
                ),
            },
            Self::Quantised {
                channel,
                step,
                noise,
                unit,
            } => {
                write!(
                    f,
                    "{channel}: in steps of {step:.3e} {unit}, which makes noise of {noise:.1e} \
                     {unit} rms"
                )
            }
            Self::Dropout {
                channels,
                count,
                span,
            } => {
                let channels = channels.join(", ");
                match count {
                    1 => write!(f, "{channels}: a dropout in {span}"),
                    n => write!(f, "{channels}: {n} dropouts, the longest in {span}"),
                }
            }
            Self::Drift {
                channel,
                change,
                unit,
            } => {
                let change = with_unit(*change, unit, 2);
                write!(f, "{channel}: the mean drifts by {change} over the ride")
            }
            Self::Line {
                channel,
                frequency,
                amplitude,
                unit,
                cones,
            } => {
                let amplitude = with_unit(*amplitude, unit, 2);
                write!(
                    f,
                    "{channel}: a line at {frequency:.3} Hz, a sine of {amplitude}: pedalling at \
                     {:.0} rpm",
                    60.0 * frequency
                )?;
                match cones {
                    Some(distance) => write!(f, ", or a slalom about cones {distance:.2} m apart"),
                    None => Ok(()),
                }
            }
            Self::Clipped {
                channel,
                value,
                unit,
                span,
            } => {
                write!(
                    f,
                    "{channel}: stays at its extreme {value} {unit} in {span}: clipped?"
                )
            }
        }
    }
}

fn standstill(spans: &[Span], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let list: Vec<String> = spans.iter().take(3).map(Span::to_string).collect();
    write!(f, "speed: standstill in {}", list.join("; "))?;
    match spans.len() {
        0..=3 => Ok(()),
        n => write!(f, "; and {} more", n - 3),
    }
}
