//! The typesetter's parts that set pages. Its usual set brings web pages, their vector graphics and a second renderer with it, which nothing
//! here asks for: what is not named here is not linked.

use std::sync::LazyLock;

use typst::foundations::{Module, NativeRuleMap, Scope};
use typst::routines::Routines;
use typst::{Library, LibraryBuilder};

static ROUTINES: LazyLock<Routines> = LazyLock::new(|| Routines {
    rules: || {
        let mut rules = NativeRuleMap::new();
        typst_layout::register(&mut rules);
        rules
    },
    eval_string: typst_eval::eval_string,
    eval_closure: typst_eval::eval_closure,
    realize: typst_realize::realize,
    layout_frame: typst_layout::layout_frame,
    html_module: || Module::new("html", Scope::new()),
    html_mathml_body: |_, _| None,
    html_span_filled: |content, _| content,
});

/// The language of the typesetter.
pub fn library() -> Library {
    LibraryBuilder::from_routines(&ROUTINES).build()
}
