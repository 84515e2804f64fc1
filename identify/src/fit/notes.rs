//! What a reader of a fit should know: assumptions, warnings, implications.

use crate::closed_loop::{STEER_CHECKED, sign_gain};
use crate::error::Result;
use crate::free::Variable;
use crate::objective::Objective;
use crate::objective::spectral::{Source, Spectral};
use crate::plan::Plan;
use crate::problem::{Problem, Rides};
use nalgebra::DVector;

/// Variation of the speed, rms over mean, above which a spectrum at the mean speed is remarked on.
const STEADY: f64 = 0.03;

/// What the calibration found of `whittle`.
const NARROW: &str = "the standard error of camber_stiffness is too small: its 95 % interval held the \
    truth in 86 of 100 synthetic rides, in 77 of 100 sextets of rides; a bootstrap's held it in 94 to 96";

/// The notes on `problem` solved at `z`; what is said of one of several rides names it.
pub(super) fn notes(problem: &Problem, z: &DVector<f64>, plan: &Plan) -> Result<Vec<String>> {
    match &problem.rides {
        Rides::Time(windows) => {
            let count: usize = windows.members.iter().map(|m| m.landscape.windows()).sum();
            Ok(vec![format!(
                "{count} windows, each with a free initial state; standard errors from the \
                 scatter between windows"
            )])
        }
        Rides::Frf(_) => Ok(vec![
            "cost and weights are CIFER's, a convention; standard errors come from the random \
             error of the measured responses"
                .into(),
        ]),
        Rides::Amplitude(spectra) | Rides::Whittle(spectra) => {
            let mut notes = vec![format!(
                "torque not measured: assumed to be the rider law plus first-order noise with a \
                 corner of {} Hz",
                plan.excitation.remnant_corner
            )];
            notes.extend(plan.model.note(spectra.members.len())?);
            let camber = |v: &Variable| v.free.row.name == "camber_stiffness";
            if problem.objective == Objective::Whittle && problem.variables.iter().any(camber) {
                notes.push(NARROW.into());
            }
            let own = spectra.each(z, |ride, z| of_ride(&ride.spectral, z));
            let several = own.len() > 1;
            for (own, name) in own.into_iter().zip(&problem.names) {
                let named = |note| {
                    if several {
                        format!("{name}: {note}")
                    } else {
                        note
                    }
                };
                notes.extend(own?.into_iter().map(named));
            }
            Ok(notes)
        }
    }
}

/// What is to be said of one ride's spectrum.
fn of_ride(spectral: &Spectral, z: &DVector<f64>) -> Result<Vec<String>> {
    let candidate = spectral.unknowns.candidate(z);
    let mut notes = Vec::new();
    let beside = spectral.beside(z)?;
    if let (Some(closed_loop), Source::Linearised) = (&beside, &spectral.source) {
        let steer = closed_loop.steer_deviation();
        if steer > STEER_CHECKED {
            notes.push(format!(
                "steering of {:.1}° rms: above 5° the linearised model spectrum has not been checked",
                steer.to_degrees()
            ));
        }
    }
    if let (Some(closed_loop), true) = (beside, spectral.unknowns.seeks("effective_damping")) {
        let p = &candidate.parameters;
        let gain = sign_gain(closed_loop.steer_rate_deviation());
        let implied = candidate.excitation.effective_damping - gain * p.coulomb_friction;
        notes.push(format!(
            "effective damping at a steer rate of {:.3} rad/s rms; with the assumed Coulomb friction of \
             {} N.m it implies a viscous friction of {implied:.3} N.m.s/rad{}",
            closed_loop.steer_rate_deviation(),
            p.coulomb_friction,
            if implied < 0.0 { ", which no bicycle has: too much Coulomb friction is assumed, or the damping is too uncertain to say" } else { "" },
        ));
    }
    let measured = &spectral.measured;
    if measured.speed_spread > STEADY {
        notes.push(format!(
            "the speed varies by {:.0} % rms; the model rides at its mean of {:.2} m/s throughout",
            100.0 * measured.speed_spread,
            measured.speed
        ));
    }
    for line in &measured.unmasked {
        notes.push(format!(
            "the steering has a line at {line:.2} Hz that noise does not explain: slalom or \
             pedalling? Masked with --line it would no longer bias friction and intensity"
        ));
    }
    for line in &measured.lines {
        notes.push(format!(
            "line at {} Hz masked, its steer amplitude of {:.2}° put into the linearisation",
            line.frequency,
            line.steer_amplitude.to_degrees()
        ));
    }
    Ok(notes)
}
