"""Mode selection: which contacts stick and which way the others slip after an event."""
