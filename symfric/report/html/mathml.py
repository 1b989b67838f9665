"""Equations as presentation MathML, by SymPy's printer with the notation of mechanics."""

import inspect
import re
from collections.abc import Collection, Iterable
from dataclasses import replace
from typing import Any

import sympy as sp
from markupsafe import Markup, escape
from sympy.printing.mathml import MathMLPresentationPrinter

from symfric.locks import SYMBOLIC, alone
from symfric.model.contact_states import coefficient
from symfric.model.in_plane import along_lines
from symfric.model.laws import Law
from symfric.model.outputs import normal_force
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED
from symfric.model.system import Contact
from symfric.model.written_instants import instants_of
from symfric.report.html.letters import letter
from symfric.scenefile import LawSpec, friction_laws

SHOWN = {  # functions as SymPy prints them, and their replacements
    "<mo>-</mo>": "<mo>−</mo>",
    "<mo>&lt;=</mo>": "<mo>≤</mo>",
    "<mo>&gt;=</mo>": "<mo>≥</mo>",
    "<mo>==</mo>": "<mo>=</mo>",
    "<mo>!=</mo>": "<mo>≠</mo>",
    "<mo>&InvisibleTimes;</mo>": "<mo>&#x2062;</mo><mspace width='.14em'/>",  # names of several letters stay apart
    "&ApplyFunction;": "&#x2061;",
    "&ExponentialE;": "e",
}
ENTITY = re.compile(r"&(#x?)?\w+;")
MU, EQUALS = Markup("<mi>μ</mi>"), Markup("<mo>=</mo>")
LEFT, RIGHT = (Markup(f"<mo stretchy='false' form='{form}'>|</mo>") for form in ("prefix", "postfix"))
MINUS = Markup("<mo form='prefix'>−</mo>")
OPEN, CLOSE = Markup("<mo stretchy='false'>(</mo>"), Markup("<mo stretchy='false'>)</mo>")
DOT = Markup("<mo>·</mo>")
COMMA = Markup("<mo>,</mo><mspace width='1em'/>")
SLIPS, SPEEDS = ("w", "s", "r", "xi"), ("v", "s", "c", "nu")  # letters for the slip and the sliding speed in a law
PRESSED = f"{normal_force.__name__}("  # how the symbol of a normal force begins, written N with the contact as index
HIDDEN = "D_of_"  # prefix of a velocity's name that stands for its rate, written with a dot


class _Printer(MathMLPresentationPrinter):
    """MathML printer: rates of velocities with a dot, cases with a brace, all other texts escaped."""

    def __init__(self) -> None:
        super().__init__()
        unescaped = self.dom.createTextNode  # SymPy's own method, which does not escape
        self.dom.createTextNode = lambda text: unescaped(text if ENTITY.fullmatch(text) else str(escape(text)))

    def _node(self, name: str, *inside: Any) -> Any:
        """Return an element with what is inside, elements or text."""
        node = self.dom.createElement(name)
        for part in inside:
            node.appendChild(self.dom.createTextNode(part) if isinstance(part, str) else part)
        return node

    def _print_Symbol(self, sym: sp.Symbol, style: str = "plain") -> Any:
        if sym.name.startswith(HIDDEN):
            return self._node("mover", self._print(sp.Symbol(sym.name.removeprefix(HIDDEN))), self._node("mo", "˙"))
        if sym.name.startswith(PRESSED):
            return self._node("msub", self._print(sp.Symbol("N")), self._text(sym.name.removeprefix(PRESSED)[:-1]))
        return super()._print_Symbol(letter(sym))

    def _print_Piecewise(self, expr: sp.Piecewise) -> Any:
        lines = []
        for value, condition in expr.args:
            if condition == sp.true:
                case = self._text("otherwise")
            else:
                case = self._node("mrow", self._text("if "), self._print(condition))
            lines.append(self._node("mtr", self._node("mtd", self._print(value)), self._node("mtd", case)))
        return self._node("mrow", self._node("mo", "{"), self._node("mtable", *lines))

    def _text(self, words: str) -> Any:
        return self._node("mtext", words.replace(" ", "\u2002"))

    def _as_ordered_terms(self, expr: sp.Expr, order: str | None = None) -> list[sp.Expr]:
        """Return the terms of a sum, those without a minus first."""
        terms = super()._as_ordered_terms(expr, order=order)
        return sorted(terms, key=lambda term: term.could_extract_minus_sign())

    def _print_Float(self, expr: sp.Float) -> Any:
        return self._node("mn", format(float(expr), ".6g"))


@alone(SYMBOLIC)
def to_mathml(expr: Any) -> Markup:
    """Return the contents of a ``<math>`` element."""
    text = _Printer().doprint(_with_exponentials(sp.sympify(expr)))
    for printed, shown in SHOWN.items():
        text = text.replace(printed, shown)
    return Markup(text)


def _with_exponentials(expr: Any) -> Any:
    """Return an expression in which a product with an exponential is no fraction: a exp(-v/b), not a / exp(v/b)."""
    written = sp.Function("exp")
    return expr.replace(sp.exp, lambda e: written(e)) if isinstance(expr, sp.Basic) and expr.has(sp.exp) else expr


def block(parts: Iterable[Markup], label: str) -> Markup:
    """Return one displayed equation from its parts; `label` is the text for screen readers."""
    inside = Markup("").join(parts)
    return Markup('<math display="block" aria-label="{}"><mrow>{}</mrow></math>').format(label, inside)


def inline(expr: Any) -> Markup:
    """Return an inline expression as MathML."""
    return Markup("<math>{}</math>").format(to_mathml(expr))


def operator(sign: str) -> Markup:
    """Return an operator as MathML."""
    return Markup("<mo>{}</mo>").format(sign)


def number_in_letters(value: float) -> Markup:
    """Return a number in the form used in a matrix."""
    mantissa, _, exponent = f"{abs(value):.6g}".partition("e")
    sign = operator("−") if value < 0 else ""
    power = Markup("<mo>·</mo><msup><mn>10</mn><mn>{}</mn></msup>").format(int(exponent)) if exponent else ""
    return Markup("{}<mn>{}</mn>{}").format(sign, mantissa, power)


def _in_brackets(expr: sp.Expr) -> Markup:
    """Return an expression, in brackets if it is a sum."""
    inside = to_mathml(expr)
    return Markup("<mrow><mo>(</mo>{}<mo>)</mo></mrow>").format(inside) if expr.is_Add else inside


def _force_name(contact: Contact) -> Markup:
    return Markup("<msub><mi>F</mi><mtext>{}</mtext></msub>").format(contact.name)


@alone(SYMBOLIC)
def equations_of_motion(scene: Scene) -> list[Markup]:
    """Return one displayed equation for each coordinate and each first-order state, friction as F_contact."""
    scene = scene.written_out()
    system, lines = scene.system, []
    rates = [sp.Symbol(HIDDEN + u.name) for u in system.u]
    same = [_dotted(q) + EQUALS + to_mathml(u) for q, u in zip(system.q, system.u, strict=True)]
    lines.append(block([COMMA.join(same)], "velocities are the rates of the coordinates"))
    for i, force in enumerate(system.force):
        inertia = ((m, to_mathml(rate)) for m, rate in zip(system.mass.row(i), rates, strict=True) if not m.is_zero)
        parts = [*(_sum_of(inertia) or [Markup("<mn>0</mn>")]), EQUALS]
        pulls = [(_force_name(line), line.slip.diff(system.u[i])) for c in scene.contacts for line in along_lines(c)]
        pulls += [(to_mathml(c.normal), c.unilateral.gap.diff(system.q[i])) for c in scene.contacts if c.unilateral]
        pulls = [(shown, slope) for shown, slope in pulls if not slope.is_zero]
        if not (force.is_zero and pulls):
            parts.append(to_mathml(force))
        parts += _sum_of(((slope, shown) for shown, slope in pulls), first=parts[-1] == EQUALS)
        lines.append(block(parts, f"equation of motion of {system.q[i].name}"))
    still = {s for h in scene.held for s in h.states}
    for z, rate in ((z, rate) for z, rate in zip(system.z, system.z_rate, strict=True) if z not in still):
        lines.append(block([_dotted(z), EQUALS, to_mathml(rate)], f"rate of {z.name}"))
    for e in instants_of(scene, lambda s: s.name):
        lines.append(block([to_mathml(e.lhs), EQUALS, to_mathml(e.rhs)], "what happens at instants"))
    return lines


def _sum_of(terms: Iterable[tuple[sp.Expr, Markup]], first: bool = True) -> list[Markup]:
    """Return a sum of factors times what is shown behind them; `first` if nothing stands before it."""
    parts: list[Markup] = []
    for factor, shown in terms:
        negative = factor.could_extract_minus_sign()
        size = -factor if negative else factor
        sign = [operator("−" if negative else "+")] if parts or negative or not first else []
        parts += [*sign, *([_in_brackets(size)] if size != 1 else []), shown]
    return parts


def _dotted(symbol: sp.Symbol) -> Markup:
    return to_mathml(sp.Symbol(HIDDEN + symbol.name))


@alone(SYMBOLIC)
def law_in_letters(spec: LawSpec | None, contact: Contact) -> Law:
    """Return the law of a contact in symbols if the file names it, else with its numbers."""
    if spec is None or spec.law in ("custom", "piecewise_linear", "maxwell_slip"):
        return contact.law
    function = friction_laws()[spec.law]
    given = {n: sp.Symbol(n, positive=True) for n in inspect.signature(function).parameters if n in spec.coefficients}
    law: Law = function(**given)
    return law


@alone(SYMBOLIC)
def opening_of_contact(contact: Contact) -> list[Markup]:
    """Return the displayed normal direction of a contact that opens: gap, normal force, impact."""
    assert contact.unilateral is not None
    gap, force = contact.unilateral.gap, to_mathml(contact.normal)
    zero, own = Markup("<mn>0</mn>"), to_mathml(sp.Symbol(f"g_{contact.name}"))
    rate = Markup("<mover>{}<mo>˙</mo></mover>").format(own)
    shown = [own, EQUALS, to_mathml(gap), operator("≥"), zero, COMMA, force, operator("≥"), zero, COMMA]
    lines = [block([*shown, force, own, EQUALS, zero], f"gap and normal force of contact {contact.name}")]
    e = contact.unilateral.restitution
    before, after = (Markup("<msup>{}<mo>{}</mo></msup>").format(rate, sign) for sign in ("−", "+"))
    rebound = [zero] if e.is_zero else [MINUS, *([] if e == 1 else [_in_brackets(e)]), before]
    return [*lines, block([after, EQUALS, *rebound, _words("in an impact")], f"impact of contact {contact.name}")]


@alone(SYMBOLIC)
def friction_of_contact(contact: Contact, law: Law, taken: Collection[str] = ()) -> list[Markup]:
    """Return the displayed set-valued friction of one contact and its law: slipping, sticking, the coefficient.

    Of a law with memory, its friction; the rates of its states are among the equations of motion. The letters of the
    slip and of the sliding speed are none of those `taken` by the scene.
    """
    load = contact.normal * contact.profile
    size = [] if load == 1 else [_in_brackets(load), DOT]
    slip = next((sp.Symbol(n, real=True) for n in SLIPS if n not in taken), sp.Symbol("w", real=True))
    label = f"friction of contact {contact.name}"
    if contact.in_plane:
        name, speed, direction, w, given = _in_plane(contact, slip)
    else:
        name, given = _force_name(contact), [] if contact.slip.is_Symbol else [EQUALS, to_mathml(contact.slip)]
        slip = slip if given else contact.slip  # that has a letter already
        w = to_mathml(slip)
        if law.memory:
            shown = coefficient(replace(contact, law=law, slip=slip))
            line = [name, EQUALS, MINUS, *size, _in_brackets(shown)]
            return [block([*line, *([_words("with"), w, *given] if given else [])], label)]
        speed, direction = Markup("").join([LEFT, w, RIGHT]), Markup("<mi>sgn</mi>") + OPEN + w + CLOSE
    slipping = [name, EQUALS, MINUS, *size]
    slipping += [MU, OPEN, speed, CLOSE, DOT] if law.kinetic != 1 else []
    slipping += [direction, _words("while"), w, *given, operator("≠"), Markup("<mn>0</mn><mtext>,</mtext>")]
    sticking = [LEFT, name, RIGHT, operator("≤"), *(size[:-1] if law.stick == 1 else size)]
    sticking += [to_mathml(law.stick)] if law.stick != 1 or not size else []
    sticking += [_words("while it sticks,"), w, EQUALS, Markup("<mn>0</mn>")]
    lines = [block(slipping, f"{label} while it slips"), block(sticking, f"{label} while it sticks")]
    return [*lines, *_coefficient_of(law, {*taken, slip.name}, label)]


def _coefficient_of(law: Law, taken: Collection[str], label: str) -> list[Markup]:
    """Return the displayed coefficient of a law over the sliding speed; none if it is 1."""
    if law.kinetic == 1:
        return []
    speed = next((sp.Symbol(n, positive=True) for n in SPEEDS if n not in taken), SPEED)
    mu = [MU, OPEN, to_mathml(speed), CLOSE, EQUALS, to_mathml(_shortest(law.kinetic).xreplace({SPEED: speed}))]
    return [block(mu, f"coefficient of {label}")]


def _in_plane(contact: Contact, slip: sp.Symbol) -> tuple[Markup, Markup, Markup, Markup, list[Markup]]:
    """Return of a contact in the plane: force, speed, direction, the letter of the slip vector, and what it equals."""
    s = Markup("<mi mathvariant='bold'>{}</mi>").format(slip.name)
    length = Markup("<mrow>{}{}{}</mrow>").format(LEFT, s, RIGHT)

    def pair(parts: Iterable[Markup]) -> Markup:
        return Markup("<mrow>{}{}{}</mrow>").format(OPEN, Markup("<mo>,</mo>").join(parts), CLOSE)

    factors = contact.ellipse or (sp.S.One, sp.S.One)
    names = (_force_name(line) for line in along_lines(contact))
    force = pair(name if e == 1 else _over(name, to_mathml(e)) for name, e in zip(names, factors, strict=True))
    speed = length if contact.ellipse is None else to_mathml(sp.sqrt(sp.Add(*(w**2 for w in contact.slips))))
    slips = pair(to_mathml(e * w) for e, w in zip(factors, contact.slips, strict=True))
    return force, speed, _over(s, length), s, [EQUALS, slips]


def _over(above: Markup, below: Markup) -> Markup:
    return Markup("<mfrac>{}{}</mfrac>").format(above, below)


def _shortest(law: sp.Expr) -> sp.Expr:
    """Return a law with the terms of every section cancelled where that makes them shorter."""
    if not isinstance(law, sp.Piecewise):
        return law
    pairs = [(min(e, sp.cancel(e), sp.factor_terms(sp.cancel(e)), key=sp.count_ops), c) for e, c in law.args]
    return sp.Piecewise(*pairs)


def _words(text: str) -> Markup:
    return Markup("<mspace width='1em'/><mtext>{}</mtext><mspace width='.5em'/>").format(text)
