"""The benchmark's problems: what is solved, the answer, and where the answer comes from."""

from dataclasses import dataclass

from symfric.model import laws, library
from symfric.model.outputs import End
from symfric.model.scene import Scene


@dataclass(frozen=True)
class Oscillator:
    r"""The equation all peers solve, in plain numbers.

    :math:`x'' + 2\beta x' + x + \mathrm{sgn}(w)\,\mu(|w|) = a\Omega^2\sin\Omega t`, w = x' - v_b, from (x0, 0), with
    :math:`\mu(v) = \mu_s + c_1 v + c_3 v^3`, Thomsen (1) and (5).

    Attributes
    ----------
    mu_s, c1, c3 : float
        Static coefficient, which is the kinetic one at rest too, and the coefficients of the falling law.
    beta, v_b, a, Omega, x0 : float
    v_s : float
        For v_s > 0 the law is regularised: ``mu_s v/v_s`` below v_s, and above it the cubic law at ``v - v_s``.
    horizon : float
        Length of the run.
    settles : bool
        The run is over when the mass rests for good.
    """

    mu_s: float
    c1: float = 0.0
    c3: float = 0.0
    beta: float = 0.0
    v_b: float = 0.0
    a: float = 0.0
    Omega: float = 0.0
    x0: float = 0.0
    v_s: float = 0.0
    horizon: float = 100.0
    settles: bool = False

    @property
    def drive(self) -> float:
        """Amplitude of the exciting force."""
        return self.a * self.Omega**2

    @property
    def held(self) -> float:
        """Force on the mass at x = 0 when it moves with the belt."""
        return -2 * self.beta * self.v_b

    @property
    def start(self) -> int:
        """Direction of the slip the run starts with."""
        if self.v_b:
            return -1 if self.v_b > 0 else 1
        return -1 if self.x0 > 0 else 1


@dataclass(frozen=True)
class Problem:
    """One problem with its answer.

    Attributes
    ----------
    name, title : str
    scene : Scene
        For the package's own routes.
    oscillator : Oscillator
        The same for the peers.
    reference : tuple of str
        Final x and x', as many digits as were verified.
    events : int or None
        Changes between stick, forward and backward slip; None where the law is continuous.
    source : str
        How the reference was found.
    """

    name: str
    title: str
    scene: Scene
    oscillator: Oscillator
    reference: tuple[str, ...]
    events: int | None
    source: str


_SERIES = "symfric.bench.reference: Taylor series in 40-digit arithmetic, events by Newton's method on the series"


def _settling() -> Problem:
    scene = library.coulomb_oscillator(0.03, x0=1.0).wanting({"end": End()})
    return Problem(
        name="P1",
        title="Coulomb oscillator until it rests",
        scene=scene,
        oscillator=Oscillator(mu_s=0.03, x0=1.0, horizon=scene.horizon, settles=True),
        reference=("0.02", "0"),
        events=17,
        source="closed form: every half cycle shortens the amplitude by 2 delta, handbook example 19.5",
    )


def _belt(name, title, reference, events, *, horizon=100.0, a=0.0, Omega=0.0, v_s=0.0) -> Problem:
    law = laws.cubic(0.4, 0.25, 0.5)
    if v_s:
        law = law.regularised(v_s)
    return Problem(
        name=name,
        title=title,
        scene=library.mass_on_belt(law, v_b=0.2, a=a, Omega=Omega, horizon=horizon).wanting({"end": End()}),
        oscillator=Oscillator(
            mu_s=0.4, c1=-0.45, c3=0.6, beta=0.05, v_b=0.2, a=a, Omega=Omega, v_s=v_s, horizon=horizon
        ),
        reference=reference,
        events=events,
        source=_SERIES,
    )


def problems() -> dict[str, Problem]:
    """Return the problems by name.

    Notes
    -----
    P1 and P2 have many sticks, P3 crosses without sticking, P4 is P2 made continuous: stiff, and 4e-4 away from it.
    """
    every = [
        _settling(),
        _belt("P2", "mass on a belt, stick and slip", ("0.39740147833166119783993", "-0.26010639809275089498628"), 30),
        _belt(
            "P3",
            "mass on a belt under fast vibration",
            ("0.07098087048587611432815", "-0.38361749615341764547828"),
            796,
            horizon=50.0,
            a=0.01,
            Omega=50.0,
        ),
        _belt(
            "P4",
            "P2 with the regularised law, v_s = 1e-4",
            ("0.39779168813254991603566", "-0.25982038514841465279738"),
            None,
            v_s=1e-4,
        ),
    ]
    return {p.name: p for p in every}
