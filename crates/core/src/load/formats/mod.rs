//! Readers of recordings: what a file of one format holds, as sources and channels.

mod clock_columns;
pub(crate) mod dataflash;
pub(crate) mod finish;
pub(crate) mod flysight;
pub(crate) mod hdf5;
pub(crate) mod hdf5_decode;
pub(crate) mod mat;
pub(crate) mod mat_contents;
pub(crate) mod mcap;
pub(crate) mod mdf4;
pub(crate) mod parquet;
pub(crate) mod recognise;
pub(crate) mod stored_number;
mod tall;
pub(crate) mod tdms;
pub(crate) mod text;
pub(crate) mod text_layout;
mod topics;
pub(crate) mod ulog;
mod unsupported;
pub(crate) mod vbox;
pub(crate) mod xplane_fdr;
