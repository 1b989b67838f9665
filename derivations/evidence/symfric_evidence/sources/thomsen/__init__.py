"""Reproduction of Thomsen: figures 2-9, phase planes, the quenching of section 5 and its energy."""

from symfric_evidence.sources.panels import panels_entry
from symfric_evidence.sources.thomsen import amplitudes, friction, motions, quench

FIGURES = {
    "thomsen-2": panels_entry(friction.figure_2),
    "thomsen-3": panels_entry(motions.figure_3),
    "thomsen-4": panels_entry(motions.figure_4),
    "thomsen-5": panels_entry(amplitudes.figure_5),
    "thomsen-6": panels_entry(amplitudes.figure_6),
    "thomsen-7": panels_entry(friction.figure_7),
    "thomsen-8": panels_entry(motions.figure_8),
    "thomsen-9": panels_entry(quench.figure_9),
    "thomsen-phase-planes": panels_entry(motions.phase_planes),
    "thomsen-quench-speeds": panels_entry(quench.quench_speeds),
    "thomsen-quench-energy": panels_entry(quench.quench_energy),
}

__all__ = ["FIGURES"]
