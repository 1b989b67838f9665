"""Decay of a free oscillator by friction: exact stop under Coulomb friction, and averaged decay time."""

from symfric.model.offering import offer
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

offer(__name__)
