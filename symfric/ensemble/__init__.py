"""Sweeps, basins of attraction and bifurcation diagrams, in parallel."""
