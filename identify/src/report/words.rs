//! What a fit says, in sentences.

use super::number::{Numbers, significant, supported};
use crate::fit::Fit;
use crate::objective::Objective;
use crate::verdict::{Estimate, Verdict};

/// What would determine the parameters that this fit leaves undetermined; none where there is no
/// such parameter.
pub fn advice(fit: &Fit) -> Option<String> {
    let lost: Vec<&Estimate> = with(fit, Verdict::NotDetermined);
    if lost.is_empty() {
        return None;
    }
    let mut sentences = vec![format!("{} not determine {}.", subject(fit), names(&lost))];
    if Reading::of(fit) == Reading::Unexplained {
        sentences.push(
            "As long as the model does not explain the ride, more of it does not help: look at \
             signs, speed, bicycle and formulation first."
                .into(),
        );
    }
    sentences.extend(channels(fit, &lost));
    let bound: Vec<&Estimate> = lost.iter().copied().filter(|p| p.at_bound).collect();
    if !bound.is_empty() {
        sentences.push(format!(
            "The search ended at a bound of {}, which is no estimate.",
            names(&bound)
        ));
    }
    let others = of(&lost, |name| {
        !tyre(name) && !friction(name) && name != DAMPING
    });
    if !others.is_empty() {
        sentences.push(format!(
            "Where {} can be measured directly, hold it at that value.",
            names(&others)
        ));
    }
    Some(sentences.join(" "))
}

/// What further channels and rides would tell of the `lost` parameters.
fn channels(fit: &Fit, lost: &[&Estimate]) -> Vec<String> {
    let (tyres, pair) = (of(lost, tyre), of(lost, friction));
    let mut sentences = Vec::new();
    let recorded = |name: &&&str| fit.channels.iter().any(|c| c == **name);
    let missing = ["roll_rate", "yaw_rate"];
    let missing: Vec<&&str> = missing.iter().filter(|name| !recorded(name)).collect();
    let missing_words = join(missing.iter().map(|name| words(name)));
    if fit.objective.has_remnant() {
        if !tyres.is_empty() && !missing.is_empty() {
            sentences.push(format!(
                "{} recorded besides would determine the tyres ({}), given a ride \
                 long enough.",
                capitalised(&missing_words),
                names(&tyres)
            ));
        } else if !tyres.is_empty() && fit.objective == Objective::Amplitude {
            sentences.push(format!(
                "The objective whittle, which uses the cross-spectra of these channels, would \
                 determine the tyres ({}).",
                names(&tyres)
            ));
        }
        let torque = of(lost, |name| tyre(name) || friction(name) || name == DAMPING);
        if !torque.is_empty() {
            let all = if pair.len() == 2 && tyres.len() == 2 {
                "all four".into()
            } else {
                names(&torque)
            };
            let all = all.replace(
                DAMPING,
                "viscous and Coulomb friction, which effective_damping stands for",
            );
            sentences.push(format!("A measured steer torque would determine {all}."));
        }
        if !pair.is_empty() {
            sentences.push(
                "Of viscous and Coulomb friction a spectrum knows one sum only; several rides at \
                 clearly different intensities would separate the two weakly."
                    .into(),
            );
        } else if torque.iter().any(|p| p.name == DAMPING) {
            sentences.push("More rides narrow effective_damping slowly.".into());
        }
    } else {
        let besides = match missing[..] {
            [] => String::new(),
            _ => format!("{missing_words} recorded besides, "),
        };
        sentences.push(capitalised(&format!(
            "{besides}a longer or livelier ride or quieter sensors would help."
        )));
    }
    sentences
}

/// Those of `estimates` whose name is of a kind.
fn of<'a>(estimates: &[&'a Estimate], kind: fn(&str) -> bool) -> Vec<&'a Estimate> {
    let of_kind = estimates.iter().copied().filter(|p| kind(&p.name));
    of_kind.collect()
}

fn names(estimates: &[&Estimate]) -> String {
    join(named(estimates, str::to_owned).into_iter())
}

/// The names of `estimates`, each once; of what rides or conditions have of their own, how many.
fn named(estimates: &[&Estimate], name: impl Fn(&str) -> String) -> Vec<String> {
    let of = |known: &str| estimates.iter().filter(|p| p.name == known).count();
    let counted = |known: &str| match of(known) {
        1 => name(known),
        n => format!("{} ({n} of them)", name(known)),
    };
    let each = distinct(estimates.iter().map(|p| p.name.as_str()));
    each.into_iter().map(counted).collect()
}

/// Each of `items` once, in their order.
pub(super) fn distinct<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<T> {
    let mut seen = Vec::new();
    for item in items {
        if !seen.contains(&item) {
            seen.push(item);
        }
    }
    seen
}

const DAMPING: &str = "effective_damping";

fn tyre(name: &str) -> bool {
    name.ends_with("cornering_stiffness") || name.ends_with("camber_stiffness")
}

fn friction(name: &str) -> bool {
    ["viscous_friction", "coulomb_friction"].contains(&name)
}

/// What the fit looked at, and a verb.
fn subject(fit: &Fit) -> String {
    let channels = join(fit.channels.iter().map(|name| words(name)));
    match (fit.objective, fit.channels.len()) {
        (Objective::Time | Objective::Frf, _) => match fit.explained.len() {
            0 | 1 => "This ride, although its steer torque was measured, does".into(),
            n => format!("These {n} rides, although their steer torque was measured, do"),
        },
        (Objective::FreeResponse, _) => "Free responses do".into(),
        (_, 1) if fit.explained.len() > 1 => {
            format!("{} of {} alone does", capitalised(&channels), rides(fit))
        }
        (_, 1) => format!("{} alone does", capitalised(&channels)),
        _ => format!("{} of {} do", capitalised(&channels), rides(fit)),
    }
}

/// How many rides were fitted, in words.
fn rides(fit: &Fit) -> String {
    match fit.explained.len() {
        0 | 1 => "one ride".into(),
        n => format!("{n} rides"),
    }
}

/// The estimates with a verdict.
fn with(fit: &Fit, verdict: Verdict) -> Vec<&Estimate> {
    fit.parameters
        .iter()
        .filter(|p| p.verdict == verdict)
        .collect()
}

/// How the misfit of a fit is to be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    /// Within the scatter that chance gives a true model.
    Explained,
    /// Less than that.
    Small,
    /// More than that, but below one and a half.
    Slight,
    /// More than that, and above one and a half.
    Unexplained,
    /// More than that, of frequency responses: their random error knows nothing of leakage.
    Unjudged,
}

/// Half width of the range in which the misfit of a true model lies 95 times in 100: the mean of
/// `observations` squares of normal residuals has the standard deviation √(2/n). That of Rayleigh
/// amplitudes is √(2.2/n), of powers under a Hann window √(35/18/n).
pub(super) fn scatter(observations: usize) -> f64 {
    2.0 * (2.0 / observations as f64).sqrt()
}

impl Reading {
    /// Of a fit.
    pub(super) fn of(fit: &Fit) -> Self {
        let scatter = scatter(fit.observations);
        match fit.misfit - 1.0 {
            over if over < -scatter => Self::Small,
            over if over <= scatter => Self::Explained,
            _ if fit.objective == Objective::Frf => Self::Unjudged,
            over if over <= 0.5 => Self::Slight,
            _ => Self::Unexplained,
        }
    }

    /// A clause on `what` was looked at.
    fn clause(self, what: &str) -> String {
        match self {
            Self::Explained => format!("the model explains {what}"),
            Self::Small => {
                format!("the model comes closer to {what} than the assumed scatter lets expect")
            }
            Self::Slight => format!("the model explains {what} almost, not to within chance"),
            Self::Unexplained => format!("the model does not explain {what}"),
            Self::Unjudged => {
                format!("how well the model explains {what} CIFER’s cost says")
            }
        }
    }
}

/// What the objective compares.
fn compared(fit: &Fit) -> &'static str {
    match (fit.objective, fit.channels.len()) {
        (Objective::Time | Objective::FreeResponse, _) => "the recorded motion",
        (Objective::Frf, _) => "the frequency responses",
        (Objective::Whittle, 2..) => "the spectra and cross-spectra",
        (_, 1) => "the spectrum",
        _ => "the spectra",
    }
}

/// The result of a fit in one sentence, or two where the search did not come to an end.
pub(super) fn headline(fit: &Fit) -> String {
    let judged = fit
        .parameters
        .iter()
        .filter(|p| p.verdict != Verdict::Nuisance)
        .count();
    let determined = with(fit, Verdict::Determined);
    let value = |p: &&Estimate| format!("{} {}", words(&p.name), Numbers::of(p).in_words());
    let mut parts = Vec::new();
    if judged > 0 {
        // of what many rides have of their own the table gives the values
        let (own, one): (Vec<&Estimate>, Vec<&Estimate>) = (determined.iter()).partition(|p| {
            determined
                .iter()
                .filter(|other| other.name == p.name)
                .count()
                > 1
        });
        let own = named(&own, words);
        let values = join(one.iter().map(value).chain(own));
        parts.push(match (determined.len(), judged) {
            (0, 1) => format!("the one parameter is {}", one_verdict(fit)),
            (0, _) => format!("none of {judged} parameters determined"),
            (1, 1) => format!("the one parameter is determined: {values}"),
            (n, _) => format!("{n} of {judged} parameters determined: {values}"),
        });
    }
    for verdict in [Verdict::Weak, Verdict::NotDetermined] {
        let names = with(fit, verdict);
        // where all are lost, the advice names them
        if !names.is_empty() && names.len() < judged {
            parts.push(format!(
                "{}: {}",
                verdict.name(),
                join(named(&names, words).into_iter())
            ));
        }
    }
    let reading = Reading::of(fit);
    let caution = match reading {
        Reading::Unexplained => {
            ", so the numbers are those of the nearest bicycle of this model, not of the ridden \
             one"
        }
        _ => "",
    };
    let misfit = significant(fit.misfit, 3);
    parts.push(format!(
        "{} (misfit {misfit}){caution}",
        reading.clause(compared(fit))
    ));
    let sentence = format!("{}.", capitalised(&parts.join("; ")));
    if fit.converged {
        sentence
    } else {
        format!(
            "{sentence} The search did not converge: {}.",
            fit.termination
        )
    }
}

/// The verdict on the parameter of a fit that judges one.
fn one_verdict(fit: &Fit) -> &'static str {
    match with(fit, Verdict::Weak).len() {
        1 => "weakly determined",
        _ => "not determined",
    }
}

/// The misfit with what it means.
pub(super) fn misfit(fit: &Fit) -> String {
    let scatter = scatter(fit.observations);
    let residual = match fit.objective {
        Objective::Amplitude => {
            "difference of measured and expected amplitude over its standard deviation"
        }
        Objective::Whittle => "Fourier coefficient over the model's cross-spectral matrix",
        Objective::Time | Objective::FreeResponse => {
            "difference of record and replay over the noise of its channel"
        }
        Objective::Frf => "logarithm of measured over expected response over its random error",
    };
    let meaning = match Reading::of(fit) {
        Reading::Explained => {
            "This fit lies in that range: nothing in these data speaks against the model."
        }
        Reading::Small => {
            "This fit lies below: the assumed scatter or noise is too large for this ride, and \
             the standard errors are rather too wide."
        }
        Reading::Slight => {
            "This fit lies above: something small is missing in the model or the assumed noise \
             is a little too small; the standard errors are somewhat too narrow."
        }
        Reading::Unexplained => {
            "This fit lies well above: the model does not describe the ride. The estimates are \
             those of its nearest bicycle; their standard errors say how sharp that nearest \
             point is, not how close it is to the truth."
        }
        Reading::Unjudged => {
            "The random error of a response knows nothing of what leaks between few windows: true \
             models of rides of 24 s reach 2 to 20. CIFER takes a mean cost J below 100 for a model \
             that serves, below 50 for one that is nearly the data."
        }
    };
    format!(
        "The misfit is {}: the mean square of the {residual}, over {} observations. It is 1 \
         where the model is true; by chance alone it then lies between {} and {} in 95 of 100 \
         rides. {meaning}",
        significant(fit.misfit, 3),
        fit.observations,
        supported((1.0 - scatter).max(0.0), scatter),
        supported(1.0 + scatter, scatter),
    )
}

/// What the search did, in words.
pub(super) fn work(fit: &Fit) -> String {
    let work = fit.work;
    let count = |n: u64, noun: &str| format!("{n} {noun}{}", if n == 1 { "" } else { "s" });
    let passes = match work.passes {
        0 | 1 => String::new(),
        n => format!(" over {n} passes, the weights renewed between them"),
    };
    format!(
        "The search took {}{passes}, {} of the cost and {} of gradient and curvature, and ended: \
         {}. Least cost {} ({}).",
        count(work.iterations, "iteration"),
        count(work.cost_evaluations, "evaluation"),
        work.curvature_evaluations,
        fit.termination,
        significant(fit.cost, 6),
        match fit.objective {
            Objective::Whittle => "−log likelihood but for a constant",
            Objective::Amplitude | Objective::Time | Objective::FreeResponse => "½ Σ r²",
            Objective::Frf => "½ J of CIFER's",
        }
    )
}

/// A name of the tables as words.
pub(crate) fn words(name: &str) -> String {
    name.replace('_', " ").replace("coulomb", "Coulomb")
}

/// `a`, `a and b`, `a, b and c`.
pub(crate) fn join<S: Into<String>>(items: impl Iterator<Item = S>) -> String {
    let mut items: Vec<String> = items.map(Into::into).collect();
    match items.pop() {
        None => String::new(),
        Some(last) if items.is_empty() => last,
        Some(last) => format!("{} and {last}", items.join(", ")),
    }
}

/// `text` with a capital letter first.
pub(crate) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}
