"""Cases of one scene in the lanes of vectors; what is rare in them is done by the event loop, one lane at a time."""
