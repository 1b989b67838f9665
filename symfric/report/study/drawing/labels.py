"""Labels of a sketch: mathematics where there is room for it, else a mark that a key below the drawing explains."""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import sympy as sp

from symfric.report.study.drawing.diagram import Diagram

SCALE, WIDTH, POINTS = 0.7, 6.2, 9  # inches in a unit, units, size of the letters at the width of a narrow screen
SMALLEST = 6.5  # points of a line of the key
MARKS = "①②③④⑤⑥⑦⑧⑨⑩⑪⑫⑬⑭⑮⑯⑰⑱⑲⑳"


@dataclass
class Sheet:
    """The Axes, and the lines of the key below the drawing."""

    ax: Any
    key: list[str] = field(default_factory=list)
    marks: dict[tuple[str, str], str] = field(default_factory=dict)
    pale: bool = False
    dotted: bool = False

    def label(self, expr: sp.Expr, room: float, what: str) -> str:
        """Return an expression as mathematics, or a mark of the key if there is no room for it."""
        text = mathematics(expr)
        return text if width(text) <= room else self.mark(what, text)

    def words(self, text: str, room: float, what: str) -> str:
        """Return words, or a mark of the key if there is no room for them."""
        shown = text.replace("$", r"\$")
        return shown if width(shown) <= room else self.mark(what, shown)

    def mark(self, what: str, text: str) -> str:
        """Return the mark of a line of the key."""
        if (what, text) not in self.marks:
            self.marks[what, text] = MARKS[min(len(self.marks), len(MARKS) - 1)]
            self.key.append(f"{self.marks[what, text]} {what} {text}")
        return self.marks[what, text]


@lru_cache(1024)
def width(text: str, points: float = POINTS) -> float:
    """Return the width of a text in units of the drawing; infinite if it cannot be set."""
    from matplotlib.textpath import TextPath

    try:
        return float(TextPath((0, 0), text, size=points).get_extents().width) / 72 / SCALE if text else 0.0
    except ValueError:  # what matplotlib's mathematics does not know
        return float("inf")


def mathematics(expr: sp.Expr) -> str:
    """Return an expression as matplotlib's mathematics, or on what it depends if it cannot be set on a line."""
    text = f"${_on_a_line(sp.sympify(expr))}$"
    if width(text, SMALLEST) <= WIDTH - 1.6:
        return text
    names = ", ".join(sp.latex(s) for s in sorted(expr.free_symbols, key=str))
    short = f"$f({names})$"
    return short if width(short, SMALLEST) <= WIDTH - 1.6 else r"$f(\ldots)$"


def _on_a_line(expr: sp.Expr) -> str:
    """Return LaTeX of an expression with its quotients on one line and its decimals rounded."""
    expr = expr if expr.is_number else sp.factor_terms(expr)
    expr = expr.xreplace({n: sp.Float(n, 4) for n in expr.atoms(sp.Float)})
    above, below = sp.fraction(expr)
    if expr.is_Add or below == 1:
        return str(sp.latex(expr, mul_symbol=r"\,"))
    parts = [sp.latex(e, mul_symbol=r"\,") for e in (above, below)]
    compound = (above.is_Add, below.is_Add or below.is_Mul)
    return "/".join(rf"\left({p}\right)" if c else p for p, c in zip(parts, compound, strict=True))


def write_key(sheet: Sheet, diagram: Diagram, low: float) -> float:
    """Write the lines of the key below the drawing; return the lower end."""
    lines = list(sheet.key)
    if diagram.states:
        names = ", ".join(mathematics(z) for z in diagram.states)
        lines.append(f"first-order states: {names}")
    if sheet.dotted:
        lines.append("dotted: coupled by inertia, or by forces without reaction")
    if sheet.pale:
        lines.append("grey: zero with the values of the scene")
    for line in lines:
        low -= 0.34
        size = max(SMALLEST, min(POINTS, POINTS * (WIDTH - 0.4) / max(width(line), 1e-9)))
        sheet.ax.text(0.2, low + 0.12, line, fontsize=size, ha="left", va="baseline")
    return low
