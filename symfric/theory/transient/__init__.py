"""Decay of a free oscillator by friction: exact stop under Coulomb friction, and averaged decay time."""

from typing import TYPE_CHECKING

from symfric.model.public_names import names_of
from symfric.theory.transient.averaged import (
    DAMPER,
    DamperSymbols,
    amplitude_rate,
    averaged_decay_time,
    mean_friction,
)
from symfric.theory.transient.decay import Decisions, EnergyBalance, damper_numbers, decisions, energy_balance
from symfric.theory.transient.stop import SYMBOLS, TransientSymbols, half_cycles, stop_position, stop_time

__all__ = [
    "DAMPER",
    "SYMBOLS",
    "DamperSymbols",
    "Decisions",
    "EnergyBalance",
    "TransientSymbols",
    "amplitude_rate",
    "averaged_decay_time",
    "damper_numbers",
    "decisions",
    "energy_balance",
    "half_cycles",
    "mean_friction",
    "stop_position",
    "stop_time",
]

if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
