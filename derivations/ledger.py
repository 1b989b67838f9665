"""The ledger: what each equation claims, and what a derivation from first principles leaves of the claim.

An entry holds the claim and a check. The check receives the claim, derives the same quantity without it, and returns
the difference; so a wrong claim (the printed one of a correction, or a mutant in the tests) leaves something.
"""

import random
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from enum import StrEnum
from types import ModuleType

import sympy as sp
from sympy.core.function import AppliedUndef

_POINTS = 3  # at which a residual is evaluated to see whether it vanishes
_DIGITS = 30
_SMALL = sp.Float(10) ** -20


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
        Why a correction is one, or why nothing can be verified.
    numbers : str
        What stands in the place of a proof, "25 digits at 8 points"; empty where the residual is an identity or exact
        arithmetic.
    """

    source: str
    equation: str
    title: str
    verdict: Verdict
    right: tuple[sp.Expr, ...] = ()
    printed: tuple[sp.Expr, ...] | str = ()
    check: Callable | None = None
    note: str = ""
    numbers: str = ""

    def residuals(self, claim: tuple[sp.Expr, ...]) -> tuple[sp.Expr, ...]:
        """Return what the derivation leaves of a claim, simplified."""
        return tuple(_simplified(e) for e in self.differences(claim))

    def differences(self, claim: tuple[sp.Expr, ...]) -> Iterator[sp.Expr]:
        """Yield what the derivation leaves of a claim, as the check comes to it."""
        left = self.check(*claim)
        return iter(left) if isinstance(left, Iterable) else iter((left,))


@dataclass(frozen=True)
class Row:
    """An entry after its check.

    Attributes
    ----------
    source, equation, title, verdict, printed, right, note, numbers : str
        `printed` in quotation marks where it is words.
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
    numbers: str
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

    def verified(self, equation: str, title: str, *claim, note: str = "", numbers: str = ""):
        """Enter an equation that is right as printed; decorates its check."""
        entry = Entry(self.source, equation, title, Verdict.VERIFIED, _tuple(claim), (), None, note, numbers)
        return self._enter(entry)

    def corrected(self, equation: str, title: str, *, right, printed, note: str, numbers: str = ""):
        """Enter an equation that is wrong as printed; decorates its check, which the printed form must fail.

        `printed` may be words where the print has no form as an expression; the note then shows why it fails.
        """
        printed = printed if isinstance(printed, str) else _tuple(printed)
        right = _tuple(right)
        return self._enter(Entry(self.source, equation, title, Verdict.CORRECTED, right, printed, None, note, numbers))

    def definition(self, equation: str, title: str, *right, note: str = "") -> None:
        """Enter a definition or an equation of the model: there is nothing to prove."""
        self.entries.append(Entry(self.source, equation, title, Verdict.DEFINITION, _tuple(right), note=note))

    def unverifiable(self, equation: str, title: str, reason: str) -> None:
        """Enter a statement that cannot be checked, and why."""
        self.entries.append(Entry(self.source, equation, title, Verdict.UNVERIFIABLE, note=reason))

    def _enter(self, entry):
        def decorate(check):
            self.entries.append(replace(entry, check=check))
            return check

        return decorate


def joined(source: str, document: str, *parts: ModuleType) -> Ledger:
    """Collect what the files of a source entered in their own ledgers, each named PART."""
    return Ledger(source, document, [entry for part in parts for entry in part.PART.entries])


def evaluate(entry: Entry) -> Row:
    """Carry out the check of an entry."""
    row = stated(entry)
    if entry.check is None:
        return row
    left = [e for e in entry.residuals(entry.right) if e != 0]
    if left:
        return replace(row, residual=_written(left), sound=False)
    accepted = isinstance(entry.printed, tuple) and entry.printed and not fails(entry, entry.printed)
    return replace(row, sound=not accepted)


def stated(entry: Entry) -> Row:
    """Return the row of an entry, its check taken as passed."""
    return Row(
        source=entry.source,
        equation=entry.equation,
        title=entry.title,
        verdict=str(entry.verdict),
        printed=f'"{entry.printed}"' if isinstance(entry.printed, str) else _written(entry.printed),
        right=_written(entry.right),
        residual="" if entry.check is None else "0",
        numbers=entry.numbers,
        sound=True,
        note=entry.note,
    )


def fails(entry: Entry, claim: tuple[sp.Expr, ...]) -> bool:
    """Return whether the check rejects a claim; decided by numbers, which is quicker than to simplify."""
    begun = []
    for left in entry.differences(claim):  # one value of each, because to see that one is zero takes all its values
        begun.append(_values(left))
        if abs(next(begun[-1], 0)) > _SMALL:
            return True
    return any(abs(value) > _SMALL for values in begun for value in values)


def vanishes(expr) -> bool:
    """Return whether an expression is zero, to 20 digits behind the point, at random values of its symbols.

    Undefined functions become definite ones. Points where the expression has no value say nothing and are drawn again.

    Raises
    ------
    ValueError
        If it has no value anywhere: nothing is known then.
    """
    return all(abs(value) <= _SMALL for value in _values(expr))


def _values(expr) -> Iterator[sp.Expr]:
    """Yield three values of an expression, none if it is the number zero."""
    expr = sp.sympify(expr)
    if expr == 0:
        return
    if expr.is_infinite:
        yield sp.oo
        return
    expr = _definite(expr)
    draw = random.Random(19)
    symbols = sorted(expr.free_symbols, key=str)
    seen = 0
    for _ in range(20):
        number = expr.subs({s: _drawn(s, draw) for s in symbols}).evalf(_DIGITS, maxn=2 * _DIGITS)
        if not number.is_number or number.has(sp.nan, sp.zoo, sp.oo):
            continue
        yield number
        seen += 1
        if seen == _POINTS:
            return
    if not seen:
        raise ValueError(f"no value at any point: {expr}")


def _drawn(symbol: sp.Symbol, draw: random.Random) -> sp.Expr:
    """Return a value that a symbol may have."""
    if symbol.is_integer:
        return sp.Integer(draw.randint(1, 9))
    size = sp.Rational(draw.randint(10, 90), 100)
    return size if symbol.is_nonnegative else size * draw.choice((-1, 1))


def _definite(expr: sp.Expr) -> sp.Expr:
    """Put an exponential and a constant, both of its own, in the place of each undefined function."""

    def curve(function):
        draw = random.Random(f"{function.func} {len(function.args)}")
        rates = [sp.Rational(draw.randint(20, 99), 50) for _ in function.args]
        return draw.randint(1, 9) + sp.exp(sum(rate * at for rate, at in zip(rates, function.args, strict=True)))

    filled = expr.replace(lambda e: isinstance(e, AppliedUndef), curve)
    return filled.replace(lambda e: isinstance(e, sp.Derivative | sp.Subs), lambda e: e.doit())


def mutants(claim: tuple[sp.Expr, ...]) -> Iterator[tuple[str, tuple[sp.Expr, ...]]]:
    """Yield name and mutated claim: another sign, factor or exponent in each of its expressions.

    Raises
    ------
    ValueError
        If a change leaves an expression as it is: it would show nothing.
    """
    for k, expr in enumerate(map(sp.sympify, claim)):
        changes = {"sign": -expr, "factor": 2 * expr} if expr != 0 else {"value": sp.Integer(1)}
        terms = sp.Add.make_args(expr)
        if len(terms) > 1:
            changes["sign of a term"] = sp.Add(*terms[:-1], -terms[-1])
        power = next((p for p in sp.preorder_traversal(expr) if p.is_Pow and p.exp.is_number), None)
        if power is not None:
            changes["exponent"] = expr.xreplace({power: power.base ** (power.exp + 1)})
        for name, changed in changes.items():
            if changed == expr:
                raise ValueError(f"another {name} leaves {expr} as it is")
            yield f"{name} of claim {k + 1}", (*claim[:k], changed, *claim[k + 1 :])


def _tuple(claim) -> tuple[sp.Expr, ...]:
    parts = claim if isinstance(claim, tuple | list) else (claim,)
    return tuple(sp.sympify(e) for e in parts)


def _written(claim: Iterable[sp.Expr]) -> str:
    """Write expressions as text; floats with 10 digits, because the last ones differ between machines."""
    return "; ".join(str(e.xreplace({f: f.n(10) for f in e.atoms(sp.Float)})) for e in claim)


def _simplified(expr) -> sp.Expr:
    expr = sp.sympify(expr)
    if expr == 0 or sp.expand(expr) == 0:
        return sp.Integer(0)
    return sp.simplify(expr)
