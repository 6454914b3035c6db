//! Frequency responses and low-order equivalent systems against systems whose answers are exact.
mod equivalent;
mod signals;
mod spectra;
