"""Answers in many digits, independent of every route and peer."""
