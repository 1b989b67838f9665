"""A forced mass with a dry joint (Jenkins element): its scene, and its steady motion in many digits."""

from collections.abc import Callable
from dataclasses import dataclass

import mpmath as mp
import sympy as sp

from symfric.model import laws
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric.model.system import Contact, System

_DIGITS = 40


@dataclass(frozen=True)
class JointProblem:
    r""":math:`x'' + c x' + x + f = \cos\Omega t`, f the force of a spring in series with a slider.

    Attributes
    ----------
    damping : float
        c.
    stiffness, limit : float
        Of the spring, and the largest |f|.
    """

    damping: float = 0.1
    stiffness: float = 0.5
    limit: float = 0.3

    def scene(self) -> Scene:
        """Return the scene; its value Omega is the frequency."""
        x, u = sp.symbols("x u", real=True)
        frequency = sp.Symbol("Omega", positive=True)
        system = System(q=[x], u=[u], mass=[[1]], force=[-x - self.damping * u + sp.cos(frequency * TIME)])
        joint = Contact("joint", u, 1, laws.coulomb(self.limit), stiffness=self.stiffness)
        return Scene(system, [joint], {frequency: 1.0}, {x: 0.0, u: 0.0}, 60.0)

    def amplitude(self, frequency: str, guess: tuple[float, float, float]) -> mp.mpf:
        """Return the largest |x| of the symmetric motion that slips once in each half cycle, in 40 digits.

        Parameters
        ----------
        frequency : str
            As a decimal number.
        guess : (float, float, float)
            Amplitude, phase of the force at the turn, and time from there to the slip.

        Notes
        -----
        From a turn at X the spring unloads from f = limit until f = -limit at ``x = X - 2 limit/stiffness``; then the
        slider moves until the mass turns at -X, half a period after the first turn. Both parts are linear; position
        at the slip, position and velocity at the end are three equations in the three unknowns.
        """
        with mp.workdps(_DIGITS):
            w = mp.mpf(frequency)
            c, k, most = (mp.mpf(str(e)) for e in (self.damping, self.stiffness, self.limit))

            def part(
                K: mp.mpf, load: mp.mpf, x: mp.mpf, u: mp.mpf, phase: mp.mpf, begin: mp.mpf
            ) -> Callable[[mp.mpf], tuple[mp.mpf, mp.mpf]]:
                """Return position and velocity of ``x'' + c x' + K x = load + cos(w t + phase)``."""
                force = mp.e ** (1j * phase) / (K - w * w + 1j * c * w)

                def steady(t: mp.mpf) -> mp.mpc:
                    return force * mp.e ** (1j * w * t)

                rate, own = mp.sqrt(K - c * c / 4), -c / 2
                a = x - steady(begin).real - load / K
                b = (u - (1j * w * steady(begin)).real - own * a) / rate

                def at(t: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
                    s, e = t - begin, mp.e ** (own * (t - begin))
                    cos, sin = mp.cos(rate * s), mp.sin(rate * s)
                    place = e * (a * cos + b * sin) + steady(t).real + load / K
                    speed = e * (own * (a * cos + b * sin) + rate * (b * cos - a * sin)) + (1j * w * steady(t)).real
                    return place, speed

                return at

            def left(X: mp.mpf, phase: mp.mpf, slips: mp.mpf) -> list[mp.mpf]:
                there, speed = part(1 + k, k * X - most, X, mp.mpf(0), phase, mp.mpf(0))(slips)
                place, end = part(mp.mpf(1), most, there, speed, phase, slips)(mp.pi / w)
                return [there - X + 2 * most / k, place + X, end]

            return mp.findroot(left, guess)[0]
