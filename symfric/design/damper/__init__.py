"""The smallest damper."""
