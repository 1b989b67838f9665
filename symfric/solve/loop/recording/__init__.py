"""What a run stores of its steps: extremes, integrals, values at given times, trajectories."""
