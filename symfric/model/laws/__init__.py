"""Friction laws of a contact: of the sliding speed alone, and with memory."""

from symfric.model.laws.bristles import dahl, elasto_plastic, lugre
from symfric.model.laws.dry import (
    coulomb,
    cubic,
    custom,
    exponential,
    gauss,
    lorentz,
    piecewise_linear,
    square_root,
    stribeck,
    thomsen_regularised,
)
from symfric.model.laws.law import SHAPES, Law
from symfric.model.offering import offer

__all__ = [
    "SHAPES",
    "Law",
    "coulomb",
    "cubic",
    "custom",
    "dahl",
    "elasto_plastic",
    "exponential",
    "gauss",
    "lorentz",
    "lugre",
    "piecewise_linear",
    "square_root",
    "stribeck",
    "thomsen_regularised",
]

offer(__name__)
