//! Rides in; parameters with their uncertainty and a report out.
