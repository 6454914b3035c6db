//! International Standard Atmosphere.
