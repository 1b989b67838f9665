"""The route `taylor`: adaptive Taylor series in machine code, with events on the polynomials."""
