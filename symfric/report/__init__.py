"""Studies of scene files, reproductions of sources, and the interactive explorer, as HTML pages."""
