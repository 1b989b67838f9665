"""The route `exact`: closed forms between events."""
