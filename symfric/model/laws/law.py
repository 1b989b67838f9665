"""A friction law: the coefficient of friction of a contact as a function of sliding speed and internal states."""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeAlias

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.arguments import is_one_of
from symfric.model.averaged_across import coefficient_across
from symfric.model.averaged_law import effective_coefficient
from symfric.model.laws.memory import Memory
from symfric.model.laws.requirements import Requirement, open_ones
from symfric.model.numeric import numeric_function
from symfric.model.steps import with_steps
from symfric.model.symbols import SPEED, expression, finite, numbers_of, refuse_speed, scalar, shortened
from symfric.spelling import spelt

_REGULARISATIONS = {  # by shape, what is done to a law
    "linear": "straight up to v_s, then the law moved by v_s",
    "arctan": "times (2/pi) atan(v/v_s), proposed after Thomsen (6)",
    "tanh": "times tanh(v/v_s)",
}
SHAPES = tuple(_REGULARISATIONS)
Shape: TypeAlias = Literal["linear", "arctan", "tanh"]


def _short(e: sp.Expr) -> str:
    """Return an expression as text; a number has ten digits at most."""
    return f"{float(e):.10g}" if e.is_Float else str(e)


def refuse_memory(law: "Law", what: str) -> None:
    """Raise if a law has memory, for calculations that take the coefficient as a function of the speed alone."""
    if law.memory is not None:
        raise SceneError(
            f"{what} takes laws of the sliding speed alone, and this one has memory ({law.source}); "
            "simulate, stability, hopf and limit_cycle take it"
        )


@spelt
@dataclass(frozen=True)
class Law:
    """Coefficient of friction of one dry contact.

    The friction on the body is ``-sign(slip) * normal * kinetic(|slip|)`` while it slips, and anything up to
    ``normal * stick`` while it sticks. A law with memory instead has states of its own, and is never said to stick:
    its friction on the body is ``-normal * memory.force``.

    Attributes
    ----------
    kinetic : Expr
        mu(v) for sliding speed ``SPEED`` > 0, dimensionless; of a law with memory, in steady sliding.
    stick : Expr
        Largest ``|friction / normal force|`` that sticking can carry, dimensionless. Zero together with
        ``kinetic(0) = 0`` makes a smooth law, which never sticks.
    breaks : tuple of Expr
        Speeds at which `kinetic` changes its branch, increasing.
    source : str
        Document and equation, or the file of ``derivations/`` that establishes the formula.
    steep : tuple of Expr
        Those of the `breaks` where the law has no Taylor series, an infinite slope for example; solvers bridge them by
        a straight line over the nearest part in 1e9 of the speed.
    memory : Memory, optional
        States of a law with memory, their rates and the coefficient; see `symfric.model.laws.memory`.
    requirements : tuple of Requirement
        What its parameters must satisfy, whatever values they get.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> law = sf.laws.stribeck(0.5, 0.4, sp.Symbol("v_s", positive=True))
    >>> round(law.where({"v_s": 0.1})(0.1), 6)
    0.436788
    >>> round(sf.laws.coulomb(0.4).regularised(0.01)(0.005), 6)
    0.2
    >>> round(sf.laws.cubic(0.4, 0.25, 0.5).averaged(0.3)(0.0), 6)
    0.0
    """

    kinetic: sp.Expr
    stick: sp.Expr
    breaks: tuple[sp.Expr, ...] = ()
    source: str = ""
    steep: tuple[sp.Expr, ...] = field(default=(), repr=False)
    memory: Memory | None = None
    requirements: tuple[Requirement, ...] = field(default=(), repr=False, compare=False)

    @alone(SYMBOLIC)
    def __post_init__(self) -> None:
        for name, what in (("kinetic", "the kinetic coefficient"), ("stick", "the static coefficient")):
            object.__setattr__(self, name, with_steps(scalar(getattr(self, name), what), what))
        object.__setattr__(self, "breaks", tuple(scalar(b, "a break of the law") for b in self.breaks))
        for what, value in (("static coefficient", self.stick), ("breaks", self.breaks), ("steep", self.steep)):
            refuse_speed(value, f"the {what} of a law")
        if self.stick.is_number and self.stick < 0:
            raise SceneError(f"the static coefficient is {self.stick}; it must not be negative")
        speeds = [0, *self.breaks]
        for low, high in itertools.pairwise(speeds):
            if (high - low).is_number and high - low <= 0:
                raise SceneError(f"the breaks of a law must increase and be positive; {high} follows {low}")
        object.__setattr__(self, "requirements", open_ones(self.requirements))

    def __repr__(self) -> str:
        """Return the law without its memory, of which only the number of states is told."""
        said = [f"kinetic={_short(self.kinetic)}", f"stick={_short(self.stick)}"]
        said += [f"breaks=({', '.join(map(_short, self.breaks))})"] if self.breaks else []
        said += [f"states={len(self.memory.rates)}"] if self.memory is not None else []
        return f"Law({', '.join([*said, f'source={self.source!r}'])})"

    @property
    def free_symbols(self) -> set[sp.Symbol]:
        """Parameters of the law, without the speed itself."""
        symbols = set().union(*(e.free_symbols for e in self.expressions)) - {SPEED}
        return symbols if self.memory is None else symbols - self.memory.reserved

    @property
    def expressions(self) -> tuple[sp.Expr, ...]:
        """Every expression of the law."""
        own = (self.kinetic, self.stick, *self.breaks)
        return own if self.memory is None else (*own, *self.memory.expressions)

    @property
    def steady(self) -> sp.Expr:
        """Coefficient in steady sliding at the speed ``SPEED``, dimensionless."""
        return self.kinetic

    @property
    def stiffness(self) -> sp.Expr:
        """Slope of the coefficient over a small displacement from rest, 1/length; infinite without memory."""
        return sp.oo if self.memory is None else self.memory.stiffness

    @property
    def smooth(self) -> bool:
        """Whether friction passes through zero without a jump, so that the contact never sticks."""
        return self.memory is not None or (bool(self.stick.is_zero) and bool(self.at_rest.is_zero))

    @property
    def at_rest(self) -> sp.Expr:
        """Kinetic coefficient in the limit of vanishing speed."""
        if self.memory is not None:
            return self.stick
        start = _at_low_speed(self.kinetic)
        if self.stick.is_zero and start.has(sp.Integral):
            return sp.Integer(0)  # the mean of an odd law over a symmetric vibration; quadrature leaves rounding
        return start.subs(SPEED, 0)

    def __call__(self, v: Any) -> Any:
        """Evaluate the law on numbers, odd in `v`; zero at v = 0.

        Parameters
        ----------
        v : float or array_like
            Relative velocity, any shape.

        Returns
        -------
        float or ndarray
            ``sign(v) * kinetic(|v|)``, same shape.

        Raises
        ------
        SceneError
            If the law still has symbols.
        """
        if self.free_symbols:
            names = ", ".join(sorted(s.name for s in self.free_symbols))
            raise SceneError(f"the law has no number for {names}; use law.where({{...}}) first")
        v = numbers_of(v, "v")
        speed = np.where(v == 0, 1.0, np.abs(v))
        result = np.sign(v) * numeric_function((SPEED,), self.kinetic)(speed)
        return result if result.ndim else float(result)

    @alone(SYMBOLIC)
    def where(self, values: Mapping[Any, Any]) -> "Law":
        """Return the law with numbers or expressions in place of its symbols, given by symbol or by name.

        Parameters
        ----------
        values : mapping of symbol or name to number or Expr

        Returns
        -------
        Law
        """
        named = {s.name: s for s in self.free_symbols}
        mapping = {named.get(key, key) if isinstance(key, str) else key: value for key, value in values.items()}
        present = set().union(*(e.free_symbols for e in self.expressions))
        if all(isinstance(key, str) or (key.is_Symbol and key not in present) for key in mapping):
            return self
        return self._mapped(lambda e: e.subs(mapping))

    def _mapped(self, change: Callable[[sp.Expr], sp.Expr]) -> "Law":
        breaks = tuple(change(b) for b in self.breaks)
        steep = tuple(change(b) for b in self.steep)
        kept = None if self.memory is None else self.memory.mapped(change)
        parts = {"kinetic": change(self.kinetic), "stick": change(self.stick), "breaks": breaks, "steep": steep}
        asked = tuple(e._replace(value=change(e.value)) for e in self.requirements)
        return replace(self, **parts, memory=kept, requirements=asked)

    @alone(SYMBOLIC)
    def regularised(self, v_s: float | sp.Expr, shape: Shape = "linear") -> "Law":
        """Return a continuous law that replaces the jump at rest by a steep slope; a law with memory has no jump.

        Parameters
        ----------
        v_s : float or Expr
            Speed below which the contact counts as sticking, > 0, in the unit of the slip velocity.
        shape : {"linear", "arctan", "tanh"}
            "linear" rises to the static coefficient at v_s and continues with the kinetic law at ``v - v_s``;
            the others multiply the kinetic law by ``(2/pi) atan(v/v_s)`` or ``tanh(v/v_s)``.

        Returns
        -------
        Law
            Smooth at rest: the contact never sticks.

        Raises
        ------
        SceneError
            If v_s is not positive, or the shape does not exist.

        Notes
        -----
        The error of a motion is linear in v_s. Where the static coefficient differs from the kinetic one at rest,
        the linear shape falls from one to the other between v_s and 2 v_s. Here every law is moved as a whole, so that
        the minimum of the cubic law moves to v_m + v_s; Thomsen (6) keeps it at v_m and is another law,
        `sf.laws.thomsen_regularised`. The factor with the arctangent is the one proposed after (6).
        """
        if self.memory is not None:
            return self
        v_s = expression(v_s, "the speed v_s of a regularisation")
        if v_s.is_number and v_s <= 0:
            raise SceneError(f"the speed v_s of a regularisation is {v_s}; it must be positive")
        if not is_one_of(shape, SHAPES):
            raise SceneError(f"no regularisation of shape {shortened(shape)}; there are {', '.join(SHAPES)}")
        source = f"{self.source}, regularised: {_REGULARISATIONS[shape]}"
        zero, asked = sp.Integer(0), (*self.requirements, Requirement("v_s of a regularisation", v_s))
        if shape != "linear":
            step = sp.atan(SPEED / v_s) * 2 / sp.pi if shape == "arctan" else sp.tanh(SPEED / v_s)
            return Law(self.kinetic * step, zero, self.breaks, source, requirements=asked)
        rest = self.at_rest
        jump = sp.simplify(rest - self.stick) != 0
        edge = 2 * v_s if jump else v_s
        pieces = [(self.stick * SPEED / v_s, v_s > SPEED)]
        if jump:
            pieces.append((self.stick + (rest - self.stick) * (SPEED / v_s - 1), edge > SPEED))
        breaks = (v_s, *((edge,) if jump else ()), *(edge + b for b in self.breaks))
        shifted = self.kinetic.subs(SPEED, SPEED - edge)
        pieces += shifted.args if isinstance(shifted, sp.Piecewise) else [(shifted, True)]
        return Law(sp.Piecewise(*pieces), zero, breaks, source, requirements=asked)

    @alone(SYMBOLIC)
    def averaged(self, q: float | sp.Expr) -> "Law":
        """Return the effective law under fast vibration of intensity q.

        Parameters
        ----------
        q : float or Expr
            Amplitude of the fast velocity, >= 0, in the unit of the slip velocity.

        Returns
        -------
        Law

        Raises
        ------
        SceneError
            If q is negative, or if the law has memory or is such an integral itself.

        Notes
        -----
        ``mubar(v) = <mu(v - q cos theta)>``, the mean over theta, Thomsen (41). Closed form for laws that are
        polynomials of the speed, Thomsen (47); an integral over theta, split where the relative velocity changes its
        sign or the law its branch, for the others. The slope just below v = q is infinite, Thomsen (47).
        """
        q = self._intensity(q)
        if q.is_zero:
            return self
        kinetic, breaks = effective_coefficient(self.kinetic, self.breaks, q)
        source = f"{self.source}, under fast vibration: Thomsen (41), (47)"
        return Law(kinetic, sp.Integer(0), breaks, source, breaks, requirements=self.requirements)

    @alone(SYMBOLIC)
    def averaged_across(self, q: float | sp.Expr) -> "Law":
        r"""Return the effective law under fast vibration across the sliding direction, of intensity q.

        Parameters
        ----------
        q : float or Expr
            Amplitude of the fast velocity across, >= 0, in the unit of the slip velocity.

        Returns
        -------
        Law

        Raises
        ------
        SceneError
            If q is negative, if the law has memory or is a mean already, or is no polynomial of the speed and q or the
            breaks are no numbers.

        Notes
        -----
        ``mubar(v) = <mu(S) v/S>``, ``S = sqrt(v^2 + q^2 cos^2 theta)``. Of Coulomb friction it is ``v/M(v, sqrt(v^2 +
        q^2))`` with the arithmetic-geometric mean M, the form in which the solvers take the elliptic integral; closed
        for polynomials of the speed, with an integral over theta for the others; derivations/plane. The friction at
        rest vanishes, with a slope that rises like ``ln(4 q/v)``; below ``1e-9 q`` the law is a straight line.

        Examples
        --------
        >>> import symfric as sf
        >>> f"{sf.laws.coulomb(1.0).averaged_across(2.0)(1.0):.12f}"
        '0.642637681773'
        """
        q = self._intensity(q)
        if q.is_zero:
            return self
        kinetic, breaks = coefficient_across(self.kinetic, self.breaks, q)
        source = f"{self.source}, under fast vibration across: derivations/plane"
        return Law(kinetic, sp.Integer(0), breaks, source, requirements=self.requirements)

    def _intensity(self, q: float | sp.Expr) -> sp.Expr:
        """Return the intensity of a fast vibration as an expression, or raise if it or the law does not serve."""
        refuse_memory(self, "the effective law under fast vibration")
        q = expression(q, "the intensity q of the fast vibration")
        if q.is_number and finite(q, "the intensity q of the fast vibration") < 0:
            raise SceneError(f"the intensity q of the fast vibration is {q}; it must not be negative")
        if self.kinetic.has(sp.Integral) and not q.is_zero:
            raise SceneError(
                "the law is a mean over fast vibration already, without a closed form, and the mean of such a mean "
                "cannot be computed; average the law itself, once"
            )
        return q


def _at_low_speed(kinetic: sp.Expr) -> sp.Expr:
    """Return the branch of a law next to rest, with all of its steps in time."""
    if not isinstance(kinetic, sp.Piecewise):
        return kinetic
    if any(SPEED in condition.free_symbols for _, condition in kinetic.args):
        return kinetic.args[0].expr
    return sp.Piecewise(*((_at_low_speed(e), condition) for e, condition in kinetic.args))
