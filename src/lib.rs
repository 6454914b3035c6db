//! The doublet workbench: draws snapshots and sends edits. It never computes.

pub mod app;
pub mod command;
pub mod layouts;
pub mod notation;
mod pane;
pub mod panels;
pub mod step;
pub mod theme;
pub mod ui_state;
pub mod widgets;
