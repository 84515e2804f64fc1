//! The work of the assist motor on the steering.

use super::rides::mean;
use crate::error::Result;
use crate::ride::Ride;
use serde::Serialize;

/// What the motor does, each a mean over the rides but the peak.
///
/// Power is torque × steer rate at the samples, each standing for one step. Of a torque that is held
/// over the steps of a simulation that is exact where the rate is the mean over the step in which
/// the torque acted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Motor {
    /// Largest torque, either way [N m].
    pub peak_torque: f64,
    /// Root mean square of the torque [N m].
    pub rms_torque: f64,
    /// Work that the motor puts into the steering, ∫ max(τ_a θ̇, 0) dt, a ride [J].
    pub delivered_energy: f64,
    /// Work in all, ∫ τ_a θ̇ dt, a ride [J]: negative where the motor brakes more than it drives.
    pub net_energy: f64,
    /// Delivered energy over the length of the ride [W].
    pub mean_power: f64,
}

impl Motor {
    /// Of at least one ride, all of one length.
    pub(super) fn of(rides: &[&Ride]) -> Result<Self> {
        let count = rides.len() as f64;
        let (mut peak_torque, mut square, mut delivered, mut net) = (0.0_f64, 0.0, 0.0, 0.0);
        for ride in rides {
            let torque = ride.channel("assist_torque")?;
            let rate = ride.channel("steer_rate")?;
            let power = || torque.iter().zip(rate).map(|(torque, rate)| torque * rate);
            peak_torque = torque.iter().fold(peak_torque, |most, t| most.max(t.abs()));
            square += mean(torque.iter().map(|t| t * t)) / count;
            delivered += mean(power().map(|power| power.max(0.0))) / count;
            net += mean(power()) / count;
        }
        let duration = rides[0].duration();
        Ok(Self {
            peak_torque,
            rms_torque: square.sqrt(),
            delivered_energy: delivered * duration,
            net_energy: net * duration,
            mean_power: delivered,
        })
    }
}
