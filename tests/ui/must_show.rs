//! The shipped flight marked by keyboard alone, timed: manoeuvres accepted and corrected, a gust excluded. Run alone:
//! `cargo test --test ui must_show -- --ignored --nocapture`.

use std::time::Instant;

use egui::{Key, Modifiers};

use crate::picture;
use crate::workbench::Bench;

/// Manoeuvres that are accepted or corrected, and every how many of them an edge is moved.
const WANTED: usize = 35;
const CORRECTED: usize = 5;
/// Longest time, s.
const MARKING_S: f64 = 180.0;

struct Hand<'b, 'a> {
    bench: &'b mut Bench<'a>,
    actions: usize,
}

impl Hand<'_, '_> {
    fn key(&mut self, key: Key) {
        self.keys(Modifiers::NONE, key);
    }

    fn keys(&mut self, modifiers: Modifiers, key: Key) {
        self.actions += 1;
        self.bench.harness.key_press_modifiers(modifiers, key);
        self.bench.harness.run_steps(2);
    }

    fn windows(&self) -> usize {
        self.bench.session().windows.len()
    }
}

#[test]
#[ignore = "measures time: run alone"]
fn manoeuvres_of_the_shipped_flight_are_marked_by_keyboard_and_a_gust_is_excluded() {
    let mut bench = Bench::shipped_in(1280.0, 720.0);
    bench.harness.hover_at(egui::pos2(640.0, 718.0));
    let began = Instant::now();
    let mut hand = Hand { bench: &mut bench, actions: 0 };
    hand.keys(Modifiers::COMMAND, Key::Num5);
    // The manoeuvres of the session go: all are marked anew.
    hand.keys(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::A);
    hand.key(Key::Delete);
    hand.bench.settle();
    assert_eq!(hand.windows(), 0);
    let (mut done, mut corrected) = (0, 0);
    while done < WANTED {
        let before = hand.windows();
        // The first press behind a correction brings the next candidate on screen, the second accepts it.
        hand.key(Key::Y);
        if hand.windows() == before {
            hand.key(Key::Y);
        }
        if hand.windows() == before {
            break;
        }
        done += 1;
        if done % CORRECTED == 0 {
            let name = hand.bench.harness.state().state.selection.window.clone().expect("the new one is chosen");
            let was = hand.bench.session().window(&name).expect("it is there").window;
            // Marker A in the middle of what is seen, moved by keys to where the manoeuvre shall end.
            hand.key(Key::W);
            hand.key(Key::A);
            (0..12).for_each(|_| hand.keys(Modifiers::COMMAND, Key::ArrowRight));
            hand.key(Key::CloseBracket);
            let now = hand.bench.session().window(&name).expect("it is there").window;
            assert!(now.end_s != was.end_s && now.start_s == was.start_s, "{was:?} {now:?}");
            corrected += 1;
        }
    }
    hand.bench.settle();
    picture(&mut hand.bench.harness, "must_marked");
    // A gust in the last one, between the markers.
    hand.key(Key::W);
    hand.key(Key::Escape);
    hand.key(Key::A);
    hand.key(Key::B);
    (0..8).for_each(|_| hand.keys(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::ArrowRight));
    hand.key(Key::E);
    hand.bench.settle();
    let excluded = hand.bench.session().windows.iter().filter(|window| !window.excluded.is_empty()).count();
    let (actions, took_s) = (hand.actions, began.elapsed().as_secs_f64());
    picture(&mut bench.harness, "must_excluded");
    println!(
        "{done} accepted, {corrected} of them corrected, a gust excluded: {actions} keys, {took_s:.1} s with every result computed"
    );
    assert_eq!(excluded, 1);
    assert!(done >= WANTED, "{done} of {WANTED}");
    assert!(took_s < MARKING_S);
    assert!(bench.snapshot().pooled.ready().is_some());
}
