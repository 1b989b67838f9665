"""The compiled event loop of piecewise smooth motions, and common parts of all compiled loops."""
