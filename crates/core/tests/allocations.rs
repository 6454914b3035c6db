//! The reconstruction allocates per window, never per sample.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::sync::Arc;

use doublet_core::reconstruct::{FilterData, FilterSettings, InputSeries, MeasurementSeries, Method, reconstruct};

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

/// The system's allocator, counting the allocations of each thread.
struct Counting;

#[allow(unsafe_code)]
// SAFETY: every call is passed on unchanged; counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Level flight, every measurement at every sample.
#[cfg(test)]
fn flight(samples: u32) -> FilterData {
    let time_s: Vec<f64> = (0..samples).map(|k| f64::from(k) * 0.01).collect();
    let column = |value: f64| vec![value; time_s.len()];
    let columns = [0.0, 0.0, -9.806_65, 0.0, 0.0, 0.0].map(column);
    let mut measurements = [0.0, 0.0, -900.0, 80.0, 0.0, 0.0, 0.0, 0.0, 0.0, 80.0, 0.0, 0.0]
        .map(|value| MeasurementSeries { time_s: time_s.clone().into(), values: column(value).into() });
    measurements[0].values = time_s.iter().map(|t| 80.0 * t).collect();
    FilterData { inputs: InputSeries { time_s: time_s.into(), columns: columns.map(Arc::from) }, measurements }
}

#[cfg(test)]
fn allocations(samples: u32, settings: &FilterSettings) -> usize {
    let data = flight(samples);
    let settings = settings.check().unwrap();
    let before = COUNT.with(Cell::get);
    let result = reconstruct(&data, &settings, &mut |_| ControlFlow::Continue(()));
    let count = COUNT.with(Cell::get) - before;
    assert_eq!(result.unwrap().states[0].len(), samples as usize);
    count
}

#[test]
fn a_window_four_times_as_long_takes_no_more_allocations() {
    let methods = [Method::Ekf, Method::USUAL_IEKF, Method::Ukf { spread: Method::USUAL_SPREAD }];
    for method in methods {
        for smooth in [false, true] {
            let settings = FilterSettings { method, smooth, ..FilterSettings::default() };
            let (short, long) = (allocations(500, &settings), allocations(2_000, &settings));
            println!("{method:?}, smoothed {smooth}: {short} allocations");
            assert_eq!(short, long, "{method:?}, smoothed {smooth}");
            assert!(short > 50);
        }
    }
}
