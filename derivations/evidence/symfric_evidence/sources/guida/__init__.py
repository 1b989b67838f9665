"""Guida, Nilvetti and Pappalardo: drawn slides."""
