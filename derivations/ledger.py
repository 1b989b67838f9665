"""The ledger: what each equation claims, and what a derivation from first principles leaves of the claim.

An entry holds the claim and a check. The check receives the claim, derives the same quantity without it, and returns
the difference; so a wrong claim (the printed one of a correction, or a mutant in the tests) leaves something.
"""

import random
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from enum import StrEnum

import sympy as sp

_POINTS = 3  # at which a residual is evaluated to see whether it vanishes
_DIGITS = 30


class Verdict(StrEnum):
    """What became of an equation."""

    VERIFIED = "verified"
    CORRECTED = "corrected"
    DEFINITION = "definition"
    UNVERIFIABLE = "unverifiable"


@dataclass(frozen=True)
class Entry:
    """One equation or statement of a source.

    Attributes
    ----------
    source, equation : str
        File of ``derivations`` and number or place: "(19)", "(19) line 2", "after (29)", "Table 1", "Ex 19.5 (iv)".
    title : str
        What it says, in a few words.
    verdict : Verdict
    right : tuple of Expr
        The claim that holds.
    printed : tuple of Expr or str
        The claim as printed, where it differs; words where it has no form as an expression.
    check : callable or None
        ``check(*claim) -> residuals``: one expression or several, all zero if and only if the claim holds.
    note : str
        Why a correction is one, or why nothing can be verified; where the audit missed it, that.
    """

    source: str
    equation: str
    title: str
    verdict: Verdict
    right: tuple[sp.Expr, ...] = ()
    printed: tuple[sp.Expr, ...] | str = ()
    check: Callable | None = None
    note: str = ""

    def residuals(self, claim: tuple[sp.Expr, ...]) -> tuple[sp.Expr, ...]:
        """Return what the derivation leaves of a claim, simplified."""
        left = self.check(*claim)
        left = tuple(left) if isinstance(left, Iterable) else (left,)
        return tuple(_simplified(e) for e in left)


@dataclass(frozen=True)
class Row:
    """An entry after its check.

    Attributes
    ----------
    source, equation, title, verdict, printed, right, note : str
    residual : str
        "0", or what is left; empty for definitions and what cannot be verified.
    sound : bool
        The residual is zero and, for a correction with a printed expression, that of the printed form is not.
    """

    source: str
    equation: str
    title: str
    verdict: str
    printed: str
    right: str
    residual: str
    sound: bool
    note: str


@dataclass
class Ledger:
    """The entries of one source, in the order in which they are written.

    Attributes
    ----------
    source : str
    document : str
        Author, title and place of the source.
    entries : list of Entry
    """

    source: str
    document: str
    entries: list[Entry] = field(default_factory=list)

    def verified(self, equation: str, title: str, *claim, note: str = ""):
        """Enter an equation that is right as printed; decorates its check."""
        return self._enter(equation, title, Verdict.VERIFIED, claim, (), note)

    def corrected(self, equation: str, title: str, *, right, printed, note: str):
        """Enter an equation that is wrong as printed; decorates its check, which the printed form must fail.

        `printed` may be words where the print has no form as an expression; the note then shows why it fails.
        """
        return self._enter(equation, title, Verdict.CORRECTED, _tuple(right), _printed(printed), note)

    def definition(self, equation: str, title: str, *right, note: str = "") -> None:
        """Enter a definition or an equation of the model: there is nothing to prove."""
        self.entries.append(Entry(self.source, equation, title, Verdict.DEFINITION, _tuple(right), note=note))

    def unverifiable(self, equation: str, title: str, reason: str) -> None:
        """Enter a statement that cannot be checked, and why."""
        self.entries.append(Entry(self.source, equation, title, Verdict.UNVERIFIABLE, note=reason))

    def _enter(self, equation, title, verdict, right, printed, note):
        def decorate(check):
            self.entries.append(Entry(self.source, equation, title, verdict, _tuple(right), printed, check, note))
            return check

        return decorate


def evaluate(entry: Entry) -> Row:
    """Carry out the check of an entry."""
    residual, sound = "", True
    if entry.check is not None:
        left = entry.residuals(entry.right)
        sound = all(e == 0 for e in left)
        residual = "0" if sound else "; ".join(str(e) for e in left if e != 0)
        if isinstance(entry.printed, tuple) and entry.printed:
            sound = sound and fails(entry, entry.printed)
    return Row(
        entry.source,
        entry.equation,
        entry.title,
        str(entry.verdict),
        entry.printed if isinstance(entry.printed, str) else _written(entry.printed),
        _written(entry.right),
        residual,
        sound,
        entry.note,
    )


def fails(entry: Entry, claim: tuple[sp.Expr, ...]) -> bool:
    """Return whether the check rejects a claim; decided by numbers, which is quicker than to simplify."""
    left = entry.check(*claim)
    left = tuple(left) if isinstance(left, Iterable) else (left,)
    return any(not vanishes(e) for e in left)


def vanishes(expr) -> bool:
    """Return whether an expression is zero at random points, to 20 digits against the size of its terms.

    Points where it has no real or complex value say nothing and are drawn again.
    """
    expr = sp.sympify(expr)
    if expr == 0:
        return True
    symbols = sorted(expr.free_symbols, key=str)
    draw = random.Random(19)
    seen = 0
    for _ in range(20):
        point = {s: sp.Rational(draw.randint(10, 90), 100) for s in symbols}
        number = expr.subs(point).evalf(_DIGITS)
        if not number.is_number or number.has(sp.nan, sp.zoo, sp.oo):
            continue
        if abs(number) > sp.Float(10) ** -20:
            return False
        seen += 1
        if seen == _POINTS:
            return True
    return seen > 0


def mutants(claim: tuple[sp.Expr, ...]):
    """Yield name and mutated claim: another sign, factor or exponent in each of its expressions."""
    for k, expr in enumerate(claim):
        expr = sp.sympify(expr)
        changes = {"sign": -expr, "factor": 2 * expr} if expr != 0 else {"value": sp.Integer(1)}
        terms = sp.Add.make_args(expr)
        if len(terms) > 1:
            changes["sign of a term"] = sp.Add(*terms[:-1], -terms[-1])
        power = next((p for p in sp.preorder_traversal(expr) if p.is_Pow and p.exp.is_number), None)
        if power is not None:
            changes["exponent"] = expr.xreplace({power: power.base ** (power.exp + 1)})
        for name, changed in changes.items():
            if changed != expr:
                yield f"{name} of claim {k + 1}", (*claim[:k], changed, *claim[k + 1 :])


def _tuple(claim) -> tuple[sp.Expr, ...]:
    parts = claim if isinstance(claim, tuple | list) else (claim,)
    return tuple(sp.sympify(e) for e in parts)


def _printed(claim):
    return claim if isinstance(claim, str) else _tuple(claim)


def _written(claim: tuple[sp.Expr, ...]) -> str:
    return "; ".join(str(e) for e in claim)


def _simplified(expr) -> sp.Expr:
    expr = sp.sympify(expr)
    return expr if expr == 0 else sp.simplify(expr)
