"""The study of a scene file: computed, drawn and written."""
