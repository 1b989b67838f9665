"""Design of a drive that positions without stick-slip."""
