"""The compiled event loop over piecewise smooth motions, and what all compiled loops share."""
