//! A design keeps what it promises: errors and excursions of many simulated flights against those before flying.
//!
//! `DOUBLET_DESIGN_FLIGHTS=200 cargo test --workspace --test engine planning -- --nocapture` flies as many as docs/planning.md states.

use std::path::Path;

use doublet_core::simulate::scenario;
use doublet_dynamics::design::{Criterion, DesignKind, Request};
use doublet_engine::graph::Context;
use doublet_engine::planning::{DesignCoverage, design_coverage};
use doublet_engine::{builtin, session};

/// Flights of each design unless the environment asks for more.
const FLIGHTS: usize = 24;

fn flights() -> usize {
    std::env::var("DOUBLET_DESIGN_FLIGHTS").ok().and_then(|text| text.parse().ok()).unwrap_or(FLIGHTS)
}

/// Flights each design starts from: the residuals of one of 150 s of windows know their own spectrum to a tenth.
fn known_flights() -> usize {
    if flights() > FLIGHTS { 16 } else { 6 }
}

fn flown(kind: DesignKind, surfaces: &[usize], time_s: f64) -> DesignCoverage {
    let session = session::parse(builtin::session("demo").unwrap()).unwrap();
    let known = scenario::build("coverage").unwrap();
    let request = Request {
        surfaces: surfaces.to_vec(),
        time_s,
        kind,
        criterion: Criterion::A,
        rounds: 0,
        search_samples: 0,
        samples: 40,
        usage: 0.9,
        seed: 1,
        with_flown: false,
    };
    let found =
        design_coverage(&session, &known, &request, (known_flights(), flights(), 1), &Context::new(Path::new(".")))
            .unwrap();
    for row in &found.derivatives {
        println!(
            "{} {}: predicted {:.3e}, scatter {:.3e}, ratio {:.3}, corrected over scatter {:.3}",
            found.kind,
            row.name,
            row.predicted,
            row.scatter,
            row.predicted / row.scatter,
            row.corrected / row.scatter
        );
    }
    for row in &found.excursions {
        println!("{}: {:?}, flown {:?}, {:.3} inside", row.name, row.predicted, row.flown, row.inside);
    }
    println!("all inside: {:.3}; {:?}", found.inside, found.correlations);
    found
}

fn assert_kept(found: &DesignCoverage, derivatives: usize) {
    assert_eq!(found.derivatives.len(), derivatives);
    for row in &found.derivatives {
        // What the fits of the flights say of themselves is known better than their scatter.
        let ratio = row.predicted / row.corrected;
        assert!((0.9..1.1).contains(&ratio), "{}: predicted {}, corrected {}", row.name, row.predicted, row.corrected);
        // The scatter of n flights is known to 1 / sqrt(2 n): three of these beside the tenth.
        let off = (row.predicted / row.scatter).ln().abs();
        let allowed = 0.1 + 3.0 / (2.0 * flights() as f64).sqrt();
        assert!(off < allowed, "{}: predicted {}, scatter {}", row.name, row.predicted, row.scatter);
    }
    // 95 % of the flights, less three deviations of a share of as many.
    let least = 0.95 - 3.0 * (0.95f64 * 0.05 / flights() as f64).sqrt();
    for row in &found.excursions {
        assert!(row.inside >= least, "{}: {} of the flights inside", row.name, row.inside);
    }
}

#[test]
fn three_two_one_ones_keep_errors_and_excursions() {
    assert_kept(&flown(DesignKind::ThreeTwoOneOne, &[0, 1, 2], 120.0), 25);
}

#[test]
fn multisines_keep_errors_and_excursions() {
    assert_kept(&flown(DesignKind::Multisine, &[0, 1, 2], 60.0), 25);
}

#[test]
fn doublets_keep_errors_and_excursions() {
    assert_kept(&flown(DesignKind::Doublet, &[0, 1, 2], 120.0), 25);
}
