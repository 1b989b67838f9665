"""One mass under a sampled input, in closed form between samples."""
