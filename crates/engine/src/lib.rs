//! The headless workbench: sessions, edits with undo, the stage graph, its worker and the exports.
