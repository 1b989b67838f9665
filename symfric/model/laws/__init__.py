"""Friction laws of a contact: of the sliding speed alone, and with memory."""

from typing import TYPE_CHECKING

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
from symfric.model.laws.rate_and_state import rate_and_state
from symfric.model.laws.sliders import bouc_wen, iwan, maxwell_slip
from symfric.model.public_names import names_of

__all__ = [
    "SHAPES",
    "Law",
    "bouc_wen",
    "coulomb",
    "cubic",
    "custom",
    "dahl",
    "elasto_plastic",
    "exponential",
    "gauss",
    "iwan",
    "lorentz",
    "lugre",
    "maxwell_slip",
    "piecewise_linear",
    "rate_and_state",
    "square_root",
    "stribeck",
    "thomsen_regularised",
]

if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
