"""The benchmark's problems with their solutions and the origin of these."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cache
from importlib.resources import files

import numpy as np

from symfric.model import laws, scenes
from symfric.model.outputs import End
from symfric.model.scene import Scene
from symfric.theory.plane import incline_stop
from symfric_evidence.bench import larger
from symfric_evidence.bench.forced import JointProblem
from symfric_evidence.bench.friction_table import table_scene
from symfric_evidence.bench.published import scene_of
from symfric_evidence.bench.stick_slip_branch import BranchProblem


@dataclass(frozen=True)
class OscillatorProblem:
    r"""The equation that heyoka's loop written by hand solves, in plain numbers.

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
    """One problem with its reference solution.

    Attributes
    ----------
    name, title : str
    scene : Scene
        For the package's own routes.
    reference : tuple of str
        Final state, or the half range of x at each speed, as many digits as were verified.
    events : int or None
        Changes between stick, forward and backward slip; None where the law is continuous.
    source : str
        How the reference was found.
    oscillator : OscillatorProblem, optional
        The same for `symfric_evidence.bench.peers.heyoka_by_hand`; `written_out` beside it writes out any.
    speeds : tuple of float
        Belt speeds of a sweep; none otherwise.
    window : (float, float)
        Times between which a sweep's half ranges are taken.
    frequencies : tuple of float
        Of the excitation, at each of which the largest displacement of the periodic motion is the answer; none
        otherwise.
    forced : JointProblem, optional
        The same for `symfric_evidence.bench.peers.pyharm_peer`.
    branch : BranchProblem, optional
        Of limit cycles, whose periods at its speeds are the answer.
    """

    name: str
    title: str
    scene: Scene
    reference: tuple[str, ...]
    events: int | None
    source: str
    oscillator: OscillatorProblem | None = None
    speeds: tuple[float, ...] = ()
    window: tuple[float, float] = (0.0, 0.0)
    frequencies: tuple[float, ...] = ()
    forced: JointProblem | None = None
    branch: BranchProblem | None = None

    @property
    def joint(self) -> JointProblem:
        """The joint of a problem that has one."""
        if self.forced is None:
            raise NotImplementedError(f"{self.name} is no forced mass with a joint")
        return self.forced

    @property
    def branched(self) -> BranchProblem:
        """The branch of a problem that has one."""
        if self.branch is None:
            raise NotImplementedError(f"{self.name} is no branch of limit cycles")
        return self.branch

    @property
    def by_hand(self) -> OscillatorProblem:
        """The oscillator of a problem that has one."""
        if self.oscillator is None:
            raise NotImplementedError(f"{self.name} is no oscillator that a loop was written for by hand")
        return self.oscillator


_MANY_DIGITS = "extrapolated midpoint rule in multiple precision, see symfric_evidence.bench.many_digits"


def _settling() -> Problem:
    delta, x0 = Fraction(0.03), 1
    stops = math.ceil((x0 / delta - 1) / 2)
    rest = (-1) ** stops * (x0 - 2 * stops * delta)
    scene = scenes.coulomb_oscillator(0.03, x0=1.0).wanting({"end": End()})
    return Problem(
        name="P1",
        title="Coulomb oscillator until it rests",
        scene=scene,
        oscillator=OscillatorProblem(mu_s=0.03, x0=1.0, horizon=scene.horizon, settles=True),
        reference=(str(Decimal(rest.numerator) / rest.denominator), "0"),
        events=stops,
        source="closed form: every half cycle shortens the amplitude by 2 delta, handbook example 19.5",
    )


def _belt(
    name: str,
    title: str,
    reference: tuple[str, ...],
    events: int | None,
    *,
    horizon: float = 100.0,
    a: float = 0.0,
    Omega: float = 0.0,
    v_s: float = 0.0,
) -> Problem:
    law = laws.cubic(0.4, 0.25, 0.5)
    if v_s:
        law = law.regularised(v_s)
    return Problem(
        name=name,
        title=title,
        scene=scenes.mass_on_belt(law, v_b=0.2, a=a, Omega=Omega, horizon=horizon).wanting({"end": End()}),
        oscillator=OscillatorProblem(
            mu_s=0.4, c1=-0.45, c3=0.6, beta=0.05, v_b=0.2, a=a, Omega=Omega, v_s=v_s, horizon=horizon
        ),
        reference=reference,
        events=events,
        source=_MANY_DIGITS,
    )


def _sweep() -> Problem:
    belt = _belt("P2", "", (), None)
    lines = files("symfric_evidence.bench").joinpath("half_ranges.txt").read_text(encoding="utf-8").split()
    return Problem(
        name="P5",
        title="half range over 1000 belt speeds",
        scene=belt.scene,
        reference=tuple(lines),
        events=None,
        source="heyoka's loop in 80-bit arithmetic with tolerance 1e-18; 1.3e-15 from this package at 1e-14",
        oscillator=belt.oscillator,
        speeds=tuple(np.linspace(0.02, 0.45, 1000).tolist()),
        window=(150.0, 200.0),
    )


def _joint() -> Problem:
    joint = JointProblem()
    return Problem(
        name="P10",
        title="steady response of a forced mass with a dry joint, two frequencies",
        scene=joint.scene(),
        reference=("6.431349859025481421557623", "3.983838961606469618886954"),
        events=None,
        source="closed form of the half cycle, three equations solved in 40 digits, see symfric_evidence.bench.forced",
        frequencies=(1.0, 1.1),
        forced=joint,
    )


def _branch_of_cycles() -> Problem:
    branch = BranchProblem()
    return Problem(
        name="P16",
        title="branch of stick-slip cycles of two masses, ten belt speeds",
        scene=branch.scene(),
        reference=_PERIODS,
        events=None,
        source="shooting in multiple precision, see symfric_evidence.bench.stick_slip_branch",
        branch=branch,
    )


_PERIODS = (
    "3.9018800585440343745",
    "3.8918565679165963698",
    "3.8793547869019654764",
    "3.8646459280926187939",
    "3.8480432635432354910",
    "3.8298934605606204192",
    "3.8105681327348806052",
    "3.7904562500339134892",
    "3.7699580341886985569",
    "3.7494809723932711521",
)
_CHAIN = (
    "0.1510402503952090495988",
    "0.2068097064217626417606",
    "0.3193467196180088065259",
    "0.4071351886583382242407",
    "0.47899367188351769527",
    "0.5467763334538130103093",
    "0.6560330615843211797943",
    "0.7730559800792881968899",
    "0.8980436013442953222424",
    "0.9938014457817561359281",
    "-0.06167558857281547522118",
    "0.03057649554640057945582",
    "0.07347380348627039752127",
    "0.01204201903299841853792",
    "-0.02841920987232150415201",
    "-0.09685819505254834085249",
    "-0.03024490434079498887287",
    "-0.1581048931791144217411",
    "-0.0695919786384636849462",
    "-0.4186003624648928955319",
)
_BRISTLES = ("0.4890983498542057403111", "0.1603759919846569179061", "-0.0003794248093012747671449")
_ISOLATOR = ("-0.007226565694623155550861", "0")
_SLIDES = (
    "-2.206217499431361550322",
    "13.53834768329674498117",
    "-0.305559204200032386513",
    "-1.388534067051788996194",
)


def _larger(name: str, title: str, scene: Scene, reference: tuple[str, ...], events: int | None) -> Problem:
    return Problem(name, title, scene, reference, events, _MANY_DIGITS)


_CLUTCH_AND_BRAKE = (
    "54.55040699963789007551924",
    "54.35441503378256831456503",
    "101.5651910638544417522368",
    "0",
    "2.289871471109621919068794",
    "2.289871471109621919068794",
)
_CLUTCHES = (
    "7.486119099114310218531826",
    "4.107137416329477623289851",
    "2.710464436231380629755214",
    "1.173743877600517535729779",
    "3.247058272418795275756992",
    "2.463187166649595355772884",
    "2.463187166649595355772884",
    "2.463187166649595355772884",
)
_TABLE = ("1.74729990830251717419588", "6.842712712106396638692532")


def _on_table() -> Problem:
    source = "closed form between the points of the table, see symfric_evidence.bench.friction_table"
    return Problem(
        "P13", "mass on a friction table of 50 points", table_scene().wanting({"end": End()}), _TABLE, 3, source
    )


def _in_plane() -> Problem:
    slope, mu, speed = math.radians(20), 1.5 * math.tan(math.radians(20)), 1.0
    stop = incline_stop(slope, mu, speed)
    scene = scenes.block_on_incline(slope=slope, mu=mu, speed=speed, direction=math.pi / 2, horizon=1.0)
    rest = tuple(repr(e) for e in (stop.cross, stop.downslope, 0.0, 0.0))
    source = "closed form, see symfric.theory.plane.incline_stop"
    return Problem(
        "P14", "block pushed across an incline, until it rests", scene.wanting({"end": End()}), rest, 1, source
    )


def _with_impacts() -> Problem:
    scene = scenes.impact_oscillator(e=0.7, zeta=0.05, Omega=2.2, horizon=171.0)
    known = ("-1.63555337642023994823197", "-0.381555987536058679888404")
    source = "closed form between impacts, see symfric_evidence.bench.impact_motion"
    return Problem("P15", "forced oscillator that strikes a stop", scene.wanting({"end": End()}), known, 60, source)


_MAKERS: dict[str, Callable[[], Problem]] = {
    "P1": _settling,
    "P2": lambda: _belt(
        "P2", "mass on a belt, stick and slip", ("0.3974014783316615041315", "-0.2601063980927507846517"), 30
    ),
    "P3": lambda: _belt(
        "P3",
        "mass on a belt under fast vibration",
        ("0.07098087048587611835981", "-0.3836174961534176535359"),
        796,
        horizon=50.0,
        a=0.01,
        Omega=50.0,
    ),
    "P4": lambda: _belt(
        "P4",
        "P2 with the regularised law, v_s = 1e-4",
        ("0.3977916881325502575629", "-0.2598203851484145335246"),
        None,
        v_s=1e-4,
    ),
    "P5": _sweep,
    "P6": lambda: _larger("P6", "ten masses with ten contacts", larger.chain(), _CHAIN, 56),
    "P7": lambda: _larger("P7", "rolling isolator under an earthquake", larger.isolator(), _ISOLATOR, 141),
    "P8": lambda: _larger("P8", "two slides in friction", larger.slides(), _SLIDES, 11),
    "P9": lambda: _larger("P9", "mass on a belt with bristles (LuGre)", larger.bristles(), _BRISTLES, None),
    "P10": _joint,
    "P11": lambda: _larger(
        "P11",
        "drive train with clutch and brake",
        scene_of("clutch_and_brake").wanting({"end": End()}),
        _CLUTCH_AND_BRAKE,
        6,
    ),
    "P12": lambda: _larger(
        "P12", "three coupled clutches", scene_of("coupled_clutches").wanting({"end": End()}), _CLUTCHES, 7
    ),
    "P13": _on_table,
    "P14": _in_plane,
    "P15": _with_impacts,
    "P16": _branch_of_cycles,
}
NAMES = tuple(_MAKERS)


@cache
def named(name: str) -> Problem:
    """Return one problem, created at its first use.

    Notes
    -----
    P1 and P2 have many sticks, P3 crosses without sticking, P4 is P2 made continuous: stiff, and 4e-4 away from it. P5
    is P2 at many speeds, some of which only graze. P6 to P9 are in `symfric_evidence.bench.larger`, P10 in
    `symfric_evidence.bench.forced`; P11 to P13 are friction examples of Modelica, see
    `symfric_evidence.bench.published`. P14 slides in the plane, P15 strikes a stop, P16 is a branch of limit cycles.
    """
    return _MAKERS[name]()


def problems() -> dict[str, Problem]:
    """Return all problems by name."""
    return {name: named(name) for name in NAMES}
