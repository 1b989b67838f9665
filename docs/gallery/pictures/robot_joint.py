"""The encoder's record and the fitted joint, residuals below."""

fit.plot().set(ylabel="angle [rad]")
