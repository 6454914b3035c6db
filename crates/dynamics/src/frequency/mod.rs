//! Frequency responses from recordings, and low-order equivalent systems fitted to them.
