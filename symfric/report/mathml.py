"""Equations for a browser: presentation MathML, through SymPy's printer with what a reader of mechanics expects."""

import inspect
from collections.abc import Iterable
from xml.sax.saxutils import escape

import sympy as sp
from sympy.printing.mathml import MathMLPresentationPrinter

from symfric.model.laws import Law
from symfric.model.names import SPEED
from symfric.model.scene import Scene
from symfric.model.system import Contact
from symfric.scenefile import LawSpec, friction_laws

RELATIONS = {"<": "&lt;", ">": "&gt;", "<=": "≤", ">=": "≥", "==": "=", "!=": "≠"}
HIDDEN = "D_of_"  # before a velocity's name: its rate, written with a dot


class _Printer(MathMLPresentationPrinter):
    """Velocities' rates with a dot, cases with a brace, relations escaped."""

    def _print_Symbol(self, sym, style="plain"):
        if sym.name.startswith(HIDDEN):
            over = self.dom.createElement("mover")
            over.appendChild(super()._print_Symbol(sp.Symbol(sym.name.removeprefix(HIDDEN))))
            dot = self.dom.createElement("mo")
            dot.appendChild(self.dom.createTextNode("˙"))
            over.appendChild(dot)
            return over
        return super()._print_Symbol(sym)

    def _print_Piecewise(self, expr):
        row, table = self.dom.createElement("mrow"), self.dom.createElement("mtable")
        brace = self.dom.createElement("mo")
        brace.appendChild(self.dom.createTextNode("{"))
        row.appendChild(brace)
        for value, condition in expr.args:
            line = self.dom.createElement("mtr")
            word = "otherwise" if condition == sp.true else "if "
            cells = [self._print(value), self._text(word)]
            if condition != sp.true:
                both = self.dom.createElement("mrow")
                both.appendChild(cells[1])
                both.appendChild(self._print(condition))
                cells[1] = both
            for content in cells:
                cell = self.dom.createElement("mtd")
                cell.appendChild(content)
                line.appendChild(cell)
            table.appendChild(line)
        row.appendChild(table)
        return row

    def _text(self, words: str):
        node = self.dom.createElement("mtext")
        node.appendChild(self.dom.createTextNode(words.replace(" ", "\u2002")))
        return node

    def _print_Float(self, expr):
        number = self.dom.createElement("mn")
        number.appendChild(self.dom.createTextNode(format(float(expr), ".6g")))
        return number


def to_mathml(expr) -> str:
    """Return the inside of a ``<math>`` element."""
    text = _Printer().doprint(sp.sympify(expr))
    for raw, shown in RELATIONS.items():
        text = text.replace(f"<mo>{raw}</mo>", f"<mo>{shown}</mo>")
    return (
        text.replace("&InvisibleTimes;", "&#x2062;")
        .replace("&ApplyFunction;", "&#x2061;")
        .replace("&ExponentialE;", "e")
    )


def block(parts: Iterable[str], label: str) -> str:
    """Return one displayed equation from its parts; `label` is what a screen reader says."""
    return (
        f'<math display="block" aria-label="{escape(label, {chr(34): "&quot;"})}"><mrow>{"".join(parts)}</mrow></math>'
    )


def inline(expr) -> str:
    """Return an expression within a sentence."""
    return f"<math>{to_mathml(expr)}</math>"


def operator(sign: str) -> str:
    """Return an operator."""
    return f"<mo>{escape(sign)}</mo>"


def _force_name(contact: Contact) -> str:
    return f"<msub><mi>F</mi><mtext>{escape(contact.name)}</mtext></msub>"


def equations_of_motion(scene: Scene) -> list[str]:
    """Return one displayed equation for each coordinate and each first-order state, friction as F_contact."""
    system, lines = scene.system, []
    rates = [sp.Symbol(HIDDEN + u.name) for u in system.u]
    same = [f"{_dotted(q)}{operator('=')}{to_mathml(u)}" for q, u in zip(system.q, system.u, strict=True)]
    lines.append(block(["<mo>,</mo><mspace width='1em'/>".join(same)], "velocities are the rates of the coordinates"))
    for i, force in enumerate(system.force):
        left = sum((m * r for m, r in zip(system.mass.row(i), rates, strict=True)), sp.Integer(0))
        parts = [to_mathml(left), operator("=")]
        pulls = [(c, c.slip.diff(system.u[i])) for c in scene.contacts]
        pulls = [(c, slope) for c, slope in pulls if not slope.is_zero]
        if not (force.is_zero and pulls):
            parts.append(to_mathml(force))
        for contact, slope in pulls:
            negative = slope.could_extract_minus_sign()
            parts.append(operator("−" if negative else "+") if len(parts) > 2 or negative else "")
            size = -slope if negative else slope
            if size != 1:
                factor = to_mathml(size)
                parts.append(f"<mrow><mo>(</mo>{factor}<mo>)</mo></mrow>" if size.is_Add else factor)
            parts.append(_force_name(contact))
        lines.append(block(parts, f"equation of motion of {system.q[i].name}"))
    for z, rate in zip(system.z, system.z_rate, strict=True):
        lines.append(block([_dotted(z), operator("="), to_mathml(rate)], f"rate of {z.name}"))
    return lines


def _dotted(symbol: sp.Symbol) -> str:
    return to_mathml(sp.Symbol(HIDDEN + symbol.name))


def law_in_letters(spec: LawSpec | None, contact: Contact) -> Law:
    """Return a contact's law in its own letters where the file names it, else as it is."""
    if spec is None or spec.law in ("custom", "piecewise_linear"):
        return contact.law
    function = friction_laws()[spec.law]
    given = {n: sp.Symbol(n, positive=True) for n in inspect.signature(function).parameters if n in spec.coefficients}
    return function(**given)


def friction_of_contact(contact: Contact, law: Law) -> list[str]:
    """Return the displayed set-valued friction of one contact and its law: slipping, sticking, the coefficient."""
    w, load, size = "<mi>w</mi>", contact.normal * contact.profile, ""
    if load != 1:
        inside = to_mathml(load)
        size = (f"<mrow><mo>(</mo>{inside}<mo>)</mo></mrow>" if load.is_Add else inside) + "<mo>·</mo>"
    name = _force_name(contact)
    slipping = [name, operator("="), operator("−"), size, "<mi>μ</mi><mo>(</mo><mo>|</mo>", w, "<mo>|</mo><mo>)</mo>"]
    slipping += ["<mo>·</mo><mi>sgn</mi><mo>(</mo>", w, "<mo>)</mo>", _words("while"), w, operator("=")]
    slipping += [to_mathml(contact.slip), "<mo>≠</mo><mn>0</mn><mtext>,</mtext>"]
    stick = to_mathml(law.stick)
    sticking = [
        "<mo>|</mo>",
        name,
        "<mo>|</mo><mo>≤</mo>",
        size,
        stick,
        _words("while it sticks,"),
        w,
        "<mo>=</mo><mn>0</mn>",
    ]
    mu = ["<mi>μ</mi><mo>(</mo>", to_mathml(SPEED), "<mo>)</mo><mo>=</mo>", to_mathml(law.kinetic)]
    label = f"friction of contact {contact.name}"
    return [
        block(slipping, f"{label} while it slips"),
        block(sticking, f"{label} while it sticks"),
        block(mu, f"coefficient of {label}"),
    ]


def _words(text: str) -> str:
    return f"<mspace width='1em'/><mtext>{escape(text)}</mtext><mspace width='.5em'/>"
