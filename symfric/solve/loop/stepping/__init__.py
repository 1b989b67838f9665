"""One step without events: Taylor coefficients, its length, and the check that it holds."""
