//! Recorder clocks (offset and drift) and lags between channels.
