"""Reproduction of Younes and Ashour: figures 3-7 and 10 as data and pictures, its word claims tested."""

from symfric.report.younes_ashour.claims import Claim, Reading, claims, claims_table
from symfric.report.younes_ashour.figures import FIGURES, Curve, FigureData, Panel
from symfric.report.younes_ashour.pictures import draw, plot_panel

__all__ = [
    "FIGURES",
    "Claim",
    "Curve",
    "FigureData",
    "Panel",
    "Reading",
    "claims",
    "claims_table",
    "draw",
    "plot_panel",
]
