"""One mass under a sampled input, from sample to sample in closed form."""
