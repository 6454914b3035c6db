//! The list from which the channel of a role is chosen, narrowed by what is typed.

use doublet_core::load::ChannelName;
use eframe::egui::{ComboBox, Id, Key, PopupCloseBehavior, ScrollArea, TextEdit, Ui};

/// Channels above which a list has a field to narrow it.
const MANY: usize = 12;
/// Height of the field above the list with its gap.
const NARROWING: f32 = 30.0;
const HEIGHT: f32 = 320.0;

/// Draws the list of the role called `key`; what was chosen in this frame, `Some(None)` for no channel. `other_side` is sign and channel of the
/// other side, where a deflection is read from both.
pub(super) fn show(
    ui: &mut Ui,
    key: &str,
    (now, other_side): (Option<&ChannelName>, Option<&str>),
    names: &[ChannelName],
    shown: impl Fn(&ChannelName) -> String,
) -> Option<Option<ChannelName>> {
    let text = match (now.map_or_else(|| "–".to_owned(), &shown), other_side) {
        (own, Some(other)) => format!("½ ({own} {other})"),
        (own, None) => own,
    };
    let mut chosen = None;
    let combo = ComboBox::from_id_salt(("channel", key)).selected_text(&text).width(172.0).truncate().height(HEIGHT);
    let combo = combo.close_behavior(PopupCloseBehavior::CloseOnClickOutside).show_ui(ui, |ui| {
        let typed = if names.len() > MANY { narrowing(ui, key) } else { Typed::default() };
        let fits = |name: &&ChannelName| shown(name).to_lowercase().contains(&typed.text.to_lowercase());
        if typed.entered {
            chosen = names.iter().find(fits).map(|name| Some(name.clone()));
        }
        ScrollArea::vertical().max_height(HEIGHT - NARROWING).show(ui, |ui| {
            if typed.text.is_empty() && ui.selectable_label(now.is_none(), "– none").clicked() {
                chosen = Some(None);
            }
            for name in names.iter().filter(fits) {
                if ui.selectable_label(now == Some(name), shown(name)).clicked() {
                    chosen = Some(Some(name.clone()));
                }
            }
        });
        if chosen.is_some() {
            ui.close();
        }
    });
    ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label(format!("channel of {key}")));
    if now.is_some() {
        combo.response.on_hover_text(text);
    }
    chosen
}

/// What is typed into the field above a list, and whether it was entered in this frame.
#[derive(Default)]
struct Typed {
    text: String,
    entered: bool,
}

/// The field above a list, which has the keyboard from the frame it appears in.
fn narrowing(ui: &mut Ui, key: &str) -> Typed {
    let id = Id::unique(("part of a channel's name", key));
    let frame = ui.ctx().cumulative_frame_nr();
    let (last, mut text) = ui.data(|data| data.get_temp::<(u64, String)>(id)).unwrap_or_default();
    let appears = last + 1 < frame;
    if appears {
        text.clear();
    }
    let field = ui.add(TextEdit::singleline(&mut text).hint_text("part of its name").desired_width(f32::INFINITY));
    ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(format!("part of the channel's name for {key}")));
    if appears {
        field.request_focus();
    }
    let entered = field.lost_focus() && !text.is_empty() && ui.input(|input| input.key_pressed(Key::Enter));
    ui.data_mut(|data| data.insert_temp(id, (frame, text.clone())));
    Typed { text, entered }
}
