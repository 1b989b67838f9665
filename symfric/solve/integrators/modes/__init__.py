"""Selection of the next mode by trial."""
