"""Two tied masses on a belt that stick in turn: their scene, and the periods of their cycles in many digits."""

from collections.abc import Sequence
from dataclasses import dataclass

import mpmath as mp
import numpy as np
import sympy as sp

from symfric.model import laws
from symfric.model.scene import Scene
from symfric.model.system import Contact, System
from symfric.orbits.cycle import limit_cycle
from symfric_evidence.bench.many_digits import many_digits

_TURNS = 12  # most iterations
_SMALL = 1e-6  # change of a start whose effect stands for a derivative


@dataclass(frozen=True)
class BranchProblem:
    r"""Two masses on one belt, each on a spring, with a third spring between them, and the cubic law of friction.

    :math:`x_i'' + 2\beta x_i' + 2 x_i - x_{1-i} + N_i\,\mathrm{sgn}(w_i)\,(\mu_s + c_1 |w_i| + c_3 |w_i|^3) = 0`,
    :math:`w_i = x_i' - v_b`, Thomsen (5).

    Attributes
    ----------
    mu_s, mu_m, v_m : float
        Of the law.
    beta : float
    loads : (float, float)
        N.
    speeds : tuple of float
        Values of v_b.
    """

    mu_s: float = 0.4
    mu_m: float = 0.25
    v_m: float = 0.5
    beta: float = 0.05
    loads: tuple[float, float] = (1.0, 1.2)
    speeds: tuple[float, ...] = (0.06, 0.08, 0.1, 0.12, 0.14, 0.16, 0.18, 0.2, 0.22, 0.24)

    @property
    def c1(self) -> float:
        """Slope of the law at rest."""
        return -1.5 * (self.mu_s - self.mu_m) / self.v_m

    @property
    def c3(self) -> float:
        """Coefficient of the cube of the speed."""
        return 0.5 * (self.mu_s - self.mu_m) / self.v_m**3

    def scene(self) -> Scene:
        """Return the scene at the first speed."""
        x, u = sp.symbols("x0:2", real=True), sp.symbols("u0:2", real=True)
        speed = sp.Symbol("v_b", real=True)
        law = laws.cubic(self.mu_s, self.mu_m, self.v_m)
        force = [-2 * x[i] + x[1 - i] - 2 * self.beta * u[i] for i in range(2)]
        contacts = [Contact(f"c{i}", u[i] - speed, self.loads[i], law) for i in range(2)]
        system = System(q=x, u=u, mass=sp.eye(2), force=force)
        return Scene(system, contacts, {speed: self.speeds[0]}, dict.fromkeys([*x, *u], 0.0), 200.0)

    def period(self, speed: float, digits: int = 26) -> mp.mpf:
        """Return the period of the stable cycle at a speed, by shooting in multiple precision.

        Notes
        -----
        Newton's method on state and period, with the first position held, from the cycle of `limit_cycle`; residuals
        by `many_digits`, their derivatives by differences of it. The matrix is kept, and the error falls by its
        relative error, some 1e-6, in each iteration.
        """
        scene = self.scene().where({"v_b": speed})
        orbit = limit_cycle(scene, tolerance=1e-12)
        with mp.workdps(digits + 4):
            z = [*map(mp.mpf, orbit.start[1:].tolist()), mp.mpf(orbit.period)]

            def missed(z: Sequence[mp.mpf], digits: int) -> list[mp.mpf]:
                start = [mp.mpf(float(orbit.start[0])), *z[:-1]]
                final = many_digits(scene, digits, start, z[-1]).final
                return [a - b for a, b in zip(final, start, strict=True)]

            rough, columns = missed(z, 18), []
            for k in range(len(z)):
                moved = [e + _SMALL * (k == i) for i, e in enumerate(z)]
                columns.append([float(a - b) / _SMALL for a, b in zip(missed(moved, 18), rough, strict=True)])
            inverse = np.linalg.inv(np.array(columns).T)
            for _ in range(_TURNS):
                off = missed(z, digits)
                step = [mp.fsum(mp.mpf(c) * o for c, o in zip(row, off, strict=True)) for row in inverse.tolist()]
                z = [a - b for a, b in zip(z, step, strict=True)]
                if max(map(abs, step)) < mp.mpf(10) ** (8 - digits):
                    break
            return z[-1]
