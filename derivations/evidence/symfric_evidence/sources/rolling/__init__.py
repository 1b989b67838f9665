"""The study of scaled rolling isolation."""
