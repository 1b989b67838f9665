"""One oscillator with one contact, from event to event in closed form."""
