"""The smallest fast excitation that stops self-excited vibration."""
