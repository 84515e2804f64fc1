//! What can go wrong between a file and a result: one enum for the crate.
//!
//! Messages say where, what was found and what was expected, with units. A cause is part of the
//! message, not a `source()`, so that a chain prints each fact once.

use crate::ride::Span;
use bicycle::mass::Body;

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// An error of this crate, grouped by where it arises.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(
    missing_docs,
    reason = "the messages say what the fields are; numbers are SI"
)]
pub enum Error {
    // ── context ────────────────────────────────────────────────────────────────────────────
    /// Any error inside a file.
    #[error("{file}: {cause}")]
    InFile { file: String, cause: Box<Error> },
    /// Any error in what was typed on the command line.
    #[error("{argument}: {cause}")]
    Argument { argument: String, cause: Box<Error> },

    // ── files ──────────────────────────────────────────────────────────────────────────────
    /// A file that cannot be read.
    #[error("{file}: cannot be read: {cause}")]
    Read { file: String, cause: std::io::Error },
    /// A file that cannot be written.
    #[error("{file}: cannot be written: {cause}")]
    Write { file: String, cause: std::io::Error },
    /// A TOML file that is not what it should be.
    #[error("{file}, row {row}: {message}")]
    Toml {
        file: String,
        row: usize,
        message: String,
    },

    /// A file to write to that the same call reads.
    #[error("{file}: expected a file of its own to write to, found one that this call reads")]
    Taken { file: String },
    /// A file named for two outputs.
    #[error("{file}: expected a file for each output, found it named twice")]
    NamedTwice { file: String },

    /// A JSON file that is not what it should be.
    #[error("{file}, row {row}: {message}")]
    Json {
        file: String,
        row: usize,
        message: String,
    },

    /// A record whose parts do not go together.
    #[error("{name}: expected {expected} entries, found {found}")]
    Entries {
        name: &'static str,
        expected: usize,
        found: usize,
    },
    /// A file that is not the one a fit was made of.
    #[error("{file}: expected the {what} of the fit (SHA-256 {expected}), found another ({found})")]
    OtherFile {
        /// Path.
        file: String,
        /// What it is to the fit: its ride, its map.
        what: &'static str,
        /// SHA-256 of the fit's.
        expected: String,
        /// SHA-256 of the one found.
        found: String,
    },

    // ── units and names ────────────────────────────────────────────────────────────────────
    /// A text that is neither a number nor a number with a unit.
    #[error("{what}: expected a number or a number with a unit, found `{found}`")]
    Number { what: String, found: String },
    /// A unit that does not exist here.
    #[error("{what}: expected a unit such as {expected}, found `{found}`")]
    UnknownUnit {
        what: String,
        expected: &'static str,
        found: String,
    },
    /// A unit of another dimension.
    #[error("{what}: expected a unit of the dimension of {expected}, found `{found}`")]
    WrongUnit {
        what: String,
        expected: &'static str,
        found: String,
    },
    /// A value outside the range of its row.
    #[error("{name}: expected {min} to {max} {unit}, found {value} {unit}")]
    OutOfRange {
        name: String,
        value: f64,
        min: f64,
        max: f64,
        unit: &'static str,
    },
    /// A name that no table has.
    #[error("unknown {kind} `{name}`; nearest: {}", nearest.join(", "))]
    Unknown {
        kind: &'static str,
        name: String,
        nearest: Vec<String>,
    },
    /// An argument that is not of the form asked for.
    #[error("expected {expected}, found `{found}`")]
    Form {
        expected: &'static str,
        found: String,
    },

    // ── ride files ─────────────────────────────────────────────────────────────────────────
    /// A ride file that is no text.
    #[error("{file}: expected text, found a zero byte at offset {offset} (UTF-16 or binary?)")]
    NotText { file: String, offset: usize },
    /// A binary file that is not what its beginning or its name says, or that no reader was built
    /// in for.
    #[error("{file}: expected {expected}, found {found}")]
    Unreadable {
        file: String,
        expected: &'static str,
        found: String,
    },
    /// A column that is no row of numbers.
    #[error("{file}: expected a number a row in column `{column}`, found {found}")]
    Column {
        file: String,
        column: String,
        found: String,
    },
    /// A ride with fewer than two samples.
    #[error("{file}: expected a header and at least 2 rows of numbers, found {found}")]
    TooFew { file: String, found: &'static str },
    /// A header that cannot be used.
    #[error("{file}, row {row}: {cause}")]
    Header {
        file: String,
        row: usize,
        cause: Box<Error>,
    },
    /// Numbers where the names of the columns should be.
    #[error("expected a header with names such as steer[deg], found `{found}`")]
    NoHeader { found: String },
    /// Two columns for the same thing.
    #[error("column `{name}` appears twice")]
    Repeated { name: String },
    /// A foreign or mistyped column in a file read without a map.
    #[error(
        "unknown column `{name}`; nearest: {}; a file with other columns needs a map (--map)",
        nearest.join(", ")
    )]
    UnknownColumn { name: String, nearest: Vec<String> },
    /// A row with too few or too many cells.
    #[error("{file}, row {row}: expected {expected} cells, found {found}")]
    Cells {
        file: String,
        row: usize,
        expected: usize,
        found: usize,
    },
    /// A cell that is no finite number.
    #[error("{file}, row {row}: expected a number in column `{column}`, found {found}")]
    Cell {
        file: String,
        row: usize,
        column: String,
        found: String,
    },
    /// Neither a time column nor a sampling rate.
    #[error("{file}: expected a time column or a sampling rate (--rate), found neither")]
    NoTime { file: String },
    /// Time that stands still or runs backwards.
    #[error("{file}, row {row}: expected a time after {previous} s, found {found} s")]
    TimeOrder {
        file: String,
        row: usize,
        found: f64,
        previous: f64,
    },
    /// A gap in the record.
    #[error(
        "{file}, row {row}: time step {found} s, expected {expected} s; \
         {hint}"
    )]
    TimeStep {
        file: String,
        row: usize,
        found: f64,
        expected: f64,
        hint: &'static str,
    },
    /// A sampling rate that contradicts the time column.
    #[error("{file}: expected {expected} Hz as given, found {found} Hz in the time column")]
    Rate {
        file: String,
        expected: f64,
        found: f64,
    },

    // ── rides ──────────────────────────────────────────────────────────────────────────────
    /// A channel the ride does not have.
    #[error("{ride}: no channel `{name}`; it has {}", has.join(", "))]
    NoChannel {
        ride: String,
        name: String,
        has: Vec<&'static str>,
    },
    /// A channel of another length than the ride.
    #[error("channel `{name}`: expected {expected} samples, found {found}")]
    Length {
        name: String,
        expected: usize,
        found: usize,
    },
    /// A sample that is not finite.
    #[error("channel `{name}`: expected finite samples, found {found} at sample {sample}")]
    NotFinite {
        name: String,
        sample: usize,
        found: f64,
    },
    /// A channel that says nothing.
    #[error("{ride}: expected a signal in channel `{name}`, found {value} {unit} throughout")]
    Constant {
        ride: String,
        name: String,
        value: f64,
        unit: &'static str,
    },
    /// A bicycle that stands.
    #[error("{ride}: expected a speed above {threshold} m/s, found standstill in {span}")]
    Standstill {
        ride: String,
        threshold: f64,
        span: Span,
    },
    /// A bicycle that rides backwards.
    #[error(
        "{ride}: expected a speed above 0, found {found:.3} m/s: is the sign of the column right?"
    )]
    Backwards { ride: String, found: f64 },
    /// A window that the ride does not cover.
    #[error(
        "{ride}: expected a window of at least 2 samples within {from} to {to} s, \
         found {start} to {stop} s"
    )]
    Window {
        ride: String,
        start: f64,
        stop: f64,
        from: f64,
        to: f64,
    },

    /// Rides, or what is known of them, that cannot be held against each other.
    #[error("{what}: expected {expected}, found {found}")]
    Incomparable {
        what: String,
        expected: String,
        found: String,
    },

    // ── maps and bicycles ──────────────────────────────────────────────────────────────────
    /// A calibration that maps everything to one value.
    #[error(
        "{channel}: expected a finite scale other than 0 and a finite offset, found scale {scale}, offset {offset}"
    )]
    Calibration {
        channel: String,
        scale: f64,
        offset: f64,
    },
    /// A key that a section of a bicycle file must have.
    #[error("{section}: expected `{key}`, found none")]
    Missing {
        section: &'static str,
        key: &'static str,
    },
    /// A bicycle file without exactly one description of its masses.
    #[error("expected exactly one of {expected}, found {found}")]
    Masses {
        expected: &'static str,
        found: usize,
    },
    /// A row given twice: determined by the masses and given besides.
    #[error("{name}: given under [parameters] and determined by {by}")]
    Overdetermined {
        name: &'static str,
        by: &'static str,
    },
    /// A rider who cannot be put on.
    #[error("bicycle {bicycle}: a rider cannot be put on: {why}")]
    Rider { bicycle: String, why: &'static str },

    /// A sweep without points, or with more than there is time for.
    #[error("expected 1 to {most} points, found {found}")]
    Points { most: usize, found: String },
    /// A mass or inertia that no matter has.
    #[error(
        "expected {body} of positive mass and positive definite inertia, found {:.3} kg and {:.3} \
         (xx), {:.3} (zz), {:.3} (xz) kg.m2 about the centre of mass", found.mass,
        found.roll_inertia, found.yaw_inertia, found.cross_inertia
    )]
    Body { body: &'static str, found: Body },

    // ── spectra and fits ───────────────────────────────────────────────────────────────────
    /// A band that is none.
    #[error("band: expected 0 <= low < high <= {nyquist} Hz (Nyquist), found {low} to {high} Hz")]
    Band { low: f64, high: f64, nyquist: f64 },
    /// A moving average that does not fit the record.
    #[error("moving average: expected {} s to {duration} s (the record), found {average} s", 2.0 * step)]
    Average {
        average: f64,
        duration: f64,
        step: f64,
    },
    /// A line where no record has one.
    #[error("line: expected a frequency between 0 and {nyquist} Hz (Nyquist), found {found} Hz")]
    LineFrequency {
        /// The frequency [Hz].
        found: f64,
        /// Half the sampling rate [Hz].
        nyquist: f64,
    },
    /// Noise that cannot be estimated.
    #[error(
        "noise of `{channel}`: expected bins above {above} Hz to estimate it from, found a record \
         that ends at {nyquist} Hz; give it for every channel"
    )]
    NoNoise {
        /// Name of the channel.
        channel: String,
        /// Where the estimate begins [Hz].
        above: f64,
        /// Half the sampling rate [Hz].
        nyquist: f64,
    },
    /// A band in which no bin is left.
    #[error("band {low} to {high} Hz: no unmasked bin in it, bins are {width:.3} Hz apart")]
    NoBins { low: f64, high: f64, width: f64 },
    /// Fewer bins than free parameters.
    #[error(
        "expected at least as many bins as the {free} free parameters, found {found}: a wider \
         band, fewer lines or a longer ride has more"
    )]
    TooFewBins { free: usize, found: usize },
    /// Fewer observations than free parameters.
    #[error("expected more observations than the {free} free parameters, found {found}")]
    TooFewObservations { free: usize, found: usize },
    /// A bicycle that cannot be simulated or linearised with these parameters.
    #[error("{0}")]
    Refused(#[from] bicycle::simulate::Refusal),
    /// A batch of rides that cannot be simulated.
    #[error("{0}")]
    Unfit(#[from] bicycle::batch::Unfit),
    /// A torque that ends before the ride.
    #[error("torque: expected {expected} samples or more, found {found}")]
    TorqueTooShort {
        /// Samples of the ride.
        expected: usize,
        /// Samples of the torque.
        found: usize,
    },
    /// A communication step that does not go with a participant's own.
    #[error(
        "step: expected {own} s, the step of {member}, to be a multiple of the communication step or \
         to go into it, found {step} s"
    )]
    SampleTime { member: String, own: f64, step: f64 },
    /// A participant that ended of itself and with it the ride.
    #[error("expected {member} to go on to the stop, found its end at {time} s")]
    EndedEarly { member: String, time: f64 },
    /// An FMU, or several coupled.
    #[error(transparent)]
    Fmu(#[from] fmi_import::Error),
    /// A bicycle that no rider with preview can follow a course on.
    #[error(transparent)]
    Unridable(#[from] bicycle::rider::Unridable),
    /// A simulated ride that ended early.
    #[error("the simulated ride ended early: {0}")]
    Stopped(#[from] bicycle::simulate::Stop),
    /// Simulated rides that ended early; of all they were to ride the part cut off.
    #[error("{fallen} of {of} simulated rides ended early; the first: {first}")]
    Fell {
        fallen: usize,
        of: usize,
        cut: f64,
        first: String,
    },
    /// A step that an FMU could not take.
    #[error("the FMU stopped at {time} s: {why}")]
    FailedStep { time: f64, why: String },
    /// A variable of an FMU that cannot stand for a row of ours.
    #[error("{row}: expected a Real {expected} of the FMU, found {found}")]
    Counterpart {
        row: &'static str,
        expected: String,
        found: String,
    },
    /// A closed loop without a steady spectrum.
    #[error(
        "expected a stable closed loop, found growth of {growth:.2} 1/s at {frequency:.2} Hz: \
         rider gains, speed or trail do not let this bicycle stand"
    )]
    Unstable { growth: f64, frequency: f64 },
    /// Windows too long for an unstable bicycle.
    #[error(
        "window: expected at most {limit:.2} s, found {window} s: the bicycle without its rider \
         has the eigenvalue {re:+.2} ± {im:.2}i 1/s, and errors of the start grow by e^{exponent} in that time"
    )]
    WindowTooLong {
        window: f64,
        limit: f64,
        re: f64,
        im: f64,
        exponent: f64,
    },
    /// Windows too short, or too few of them.
    #[error(
        "window of {window} s: expected more than five samples of {step} s in each and more \
         windows than the {free} free parameters, found {found} windows"
    )]
    Windows {
        /// Length of a window [s].
        window: f64,
        /// Step of the record [s].
        step: f64,
        /// Number of windows.
        found: usize,
        /// Number of free parameters.
        free: usize,
    },
    /// Two windows that share samples, which would be counted twice.
    #[error(
        "{ride}: expected windows that do not overlap, found {} to {} s and {} to {} s",
        first.0, first.1, second.0, second.1
    )]
    Overlapping {
        ride: String,
        first: (f64, f64),
        second: (f64, f64),
    },
    /// An objective that lives on given windows, without any.
    #[error("objective {objective}: expected the windows to replay (--windows FILE), found none")]
    NoWindows { objective: &'static str },
    /// A window of frequency responses that the record does not hold one and a half times.
    #[error(
        "window of frf: expected {least} s to {most} s (the record holds two, overlapping by half), found {window} s"
    )]
    Averaging { window: f64, least: f64, most: f64 },
    /// A file of windows that is not what it should be.
    #[error("{file}, row {row}: {cause}")]
    WindowFile {
        file: String,
        row: u64,
        cause: String,
    },
    /// A free parameter that changes nothing.
    #[error(
        "free parameter `{name}` does not influence the {objective} objective of this ride: {why}"
    )]
    NoInfluence {
        name: String,
        objective: &'static str,
        why: &'static str,
    },
    /// A channel in which a formulation moves nothing.
    #[error("channel {channel}: {formulation} moves nothing there; it moves {moved}")]
    Unmoved {
        channel: &'static str,
        formulation: &'static str,
        moved: String,
    },
    /// Equations too stiff to be replayed.
    #[error(
        "expected a bicycle whose equations allow steps of {expected:.1e} s, found a stability limit \
         of {limit:.1e} s"
    )]
    Stiff { limit: f64, expected: f64 },
    /// A jump where only smooth equations are replayed.
    #[error(
        "{name}: expected a width above 0 with objective time, whose replay needs smooth equations, found 0"
    )]
    Jump { name: &'static str },
    /// Bounds the wrong way round, or outside the row's range.
    #[error(
        "bounds of `{name}`: expected lower < upper within {min} to {max} {unit}, found {lower} to {upper}"
    )]
    Bounds {
        name: String,
        lower: f64,
        upper: f64,
        min: f64,
        max: f64,
        unit: &'static str,
    },
    /// Bounds that leave out where the search would start.
    #[error(
        "bounds of `{name}`: expected them to hold its start value {value} {unit}, found {lower} to \
         {upper}; --set {name}=VALUE starts elsewhere"
    )]
    StartOutside {
        name: &'static str,
        value: f64,
        lower: f64,
        upper: f64,
        unit: &'static str,
    },
    /// A change of a parameter that is not sought.
    #[error("`{name}` is held, not free: expected one of {free}, or --free {name} besides")]
    NotFree { name: &'static str, free: String },
    /// A prior asked of the table, which has none.
    #[error("prior of `{name}`: the literature measured no interval; give {name}=MEAN:DEVIATION")]
    NoPrior { name: &'static str },
    /// A prior outside the bounds, or without a width.
    #[error(
        "prior of `{name}`: expected a mean within the bounds {lower} to {upper} {unit} and a deviation above 0, found {mean} ± {deviation}"
    )]
    Prior {
        name: &'static str,
        mean: f64,
        deviation: f64,
        lower: f64,
        upper: f64,
        unit: &'static str,
    },
    /// A tie that cannot hold.
    #[error("`{follower}` tied to `{leader}`: {why}")]
    Tie {
        follower: &'static str,
        leader: &'static str,
        why: &'static str,
    },
    /// A ride that would be counted twice.
    #[error("{ride}: expected each ride once, found it twice")]
    SameRide { ride: String },
    /// Rides of different sampling.
    #[error("{ride}: expected {expected} Hz as in {other}, found {found} Hz")]
    Sampling {
        ride: String,
        found: f64,
        other: String,
        expected: f64,
    },
    /// An objective that does not offer what is asked.
    #[error("{what} is offered for the objectives {expected}, not for {found}")]
    Objective {
        what: String,
        expected: String,
        found: &'static str,
    },
    /// No ride at all.
    #[error("expected a ride, found none")]
    NoRides,
    /// A search that its library gave up.
    #[error("the search failed: {0}")]
    Search(String),
    /// A start from which nothing can be computed.
    #[error(
        "no start found from which the {objective} objective can be computed; the last one: {cause}"
    )]
    NoStart {
        objective: &'static str,
        cause: String,
    },
    /// A budget that does not last for one generation.
    #[error(
        "--population: expected {least} evaluations of the cost, one generation, or more, found {found}"
    )]
    Population { least: u64, found: u64 },
    /// A journal of finished work that is not this run's.
    #[error("{file}: expected the journal of {what} {expected}, found {found}")]
    Journal {
        file: String,
        what: &'static str,
        expected: String,
        found: String,
    },
    /// A journal of another run.
    #[error(
        "{file}: expected what this very fit had finished, found that of a fit of other rides, \
         options or seed; call it as it was called, or name another file behind --resume"
    )]
    OtherRun { file: String },
    /// A journal that another process has open.
    #[error("{file}: expected a journal of its own, found one that another run is writing")]
    JournalInUse { file: String },
    /// A result that a journal cannot give back.
    #[error(
        "job {job}: expected a result of finite numbers, found one that cannot be written down: {cause}"
    )]
    Unwritable { job: u64, cause: String },
}

impl Error {
    /// This error as one of what was typed: `argument` as typed.
    #[must_use]
    pub fn typed(self, argument: impl Into<String>) -> Self {
        Self::Argument {
            argument: argument.into(),
            cause: Box::new(self),
        }
    }

    /// This error as one inside `file`.
    #[must_use]
    pub fn in_file(self, file: impl Into<String>) -> Self {
        Self::InFile {
            file: file.into(),
            cause: Box::new(self),
        }
    }

    /// A name that none of `known` is, with the nearest of them.
    pub fn unknown<'a>(
        kind: &'static str,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        Self::Unknown {
            kind,
            name: name.into(),
            nearest: nearest(name, known),
        }
    }

    /// Whether the fault is in what was typed on the command line (exit code 2).
    pub fn is_typed(&self) -> bool {
        // outside a file, a name, a band or bounds can only have been typed
        matches!(
            self,
            Self::Argument { .. }
                | Self::Unknown { .. }
                | Self::Band { .. }
                | Self::LineFrequency { .. }
                | Self::Bounds { .. }
                | Self::NoPrior { .. }
                | Self::NoWindows { .. }
                | Self::NotFree { .. }
                | Self::StartOutside { .. }
                | Self::Objective { .. }
                | Self::Population { .. }
                | Self::Taken { .. }
                | Self::NamedTwice { .. }
                | Self::Prior { .. }
                | Self::Tie { .. }
                | Self::SampleTime { .. }
                | Self::Fmu(
                    fmi_import::Error::Connection { .. }
                        | fmi_import::Error::TwoSources { .. }
                        | fmi_import::Error::UnknownMember { .. }
                        | fmi_import::Error::UnknownVariable { .. }
                        | fmi_import::Error::OwnStep { .. }
                        | fmi_import::Error::Untolerant { .. }
                        | fmi_import::Error::Plan { .. }
                )
        )
    }
}

pub use fmi_import::nearest;

/// A TOML parser's complaint about `text`, as one line with its row.
pub(crate) fn toml(file: &str, text: &str, error: &::toml::de::Error) -> Error {
    let before = error.span().map_or(0, |span| span.start.min(text.len()));
    Error::Toml {
        file: file.into(),
        row: text[..before].split('\n').count(),
        message: error.message().replace('\n', "; "),
    }
}

#[cfg(test)]
mod tests;
