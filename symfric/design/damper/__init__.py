"""Design of the smallest damper against friction-induced vibration."""
