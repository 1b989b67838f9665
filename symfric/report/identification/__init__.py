"""The page of a fit to a record."""
