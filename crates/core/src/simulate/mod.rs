//! Six-degree-of-freedom simulation with sensors and clocks: recordings whose every answer is known.
