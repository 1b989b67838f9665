"""One oscillator with one contact, in closed form between events."""
