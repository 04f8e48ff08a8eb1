//! GP2: Gaussian processes pushed through known, possibly constrained, linear maps.
