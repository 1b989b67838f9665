"""Design of a seismic isolator."""
