"""Quenching by fast vibration and its cost: Thomsen, figure 9 and section 5."""

from functools import cache

import numpy as np
import sympy as sp

from symfric.model import scenes
from symfric.model.numeric import numeric_function
from symfric.model.scene import Scene
from symfric.theory import belt
from symfric.theory.belt.scene import numbers
from symfric_evidence.sources.panels import FigureData, Panel, PanelCurve
from symfric_evidence.sources.registry import Finding

A = 0.01
DAMPINGS = (0.05, 0.1)  # the second one is chosen here; the source does not print it
FREQUENCIES = (5.0, 10.0, 20.0, 30.0, 33.0, 35.0, 40.0)
VERY_GOOD = 0.05  # relative deviation that the words are taken for, ours
FASTEST, SETTLE = 0.46, 300.0  # belt speed and time from which the forced orbit is sought
OMEGA, SPEED, INTENSITY = r"$\Omega$", r"$v_b$", r"$a\Omega$"


def scene_of(beta: float, Omega: float = 0.0) -> Scene:
    """Return the belt of figure 9."""
    return scenes.mass_on_belt(v_b=0.3, beta=beta, a=A if Omega else 0.0, Omega=Omega)


@cache
def bounds(beta: float) -> np.ndarray:
    """Return Omega and the lower and upper belt speed of self-excited vibration in the full model, shape (3, n)."""
    from symfric.orbits.continuation.branch import continue_cycle

    rows = []
    for Omega in FREQUENCIES:
        scene = scene_of(beta, Omega).where({"v_b": FASTEST}).until(SETTLE)
        special = continue_cycle(scene, "v_b", (0.995 * A * Omega, FASTEST)).special
        upper = [s.value for s in special if s.kind == "neimark-sacker"]
        if upper:
            rows.append((Omega, max(s.value for s in special if s.kind == "stick-onset"), *upper))
    return np.array(rows).T


def _averaged(beta: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return Omega and both bounds of (55)."""
    end = belt.quench_intensity(scene_of(beta)) / A
    Omega = end * np.sin(np.linspace(0.0, 0.5 * np.pi, 200))[:-1]
    return Omega, *_limits(beta, Omega)


def _limits(beta: float, Omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return both bounds of (55)."""
    low, high = belt.unstable_speeds(symbolic=True)
    return _over(low, belt.SYMBOLS.Omega, Omega, beta), _over(high, belt.SYMBOLS.Omega, Omega, beta)


def _over(
    formula: sp.Expr, letter: sp.Symbol, values: np.ndarray, beta: float = DAMPINGS[0], q: float | None = None
) -> np.ndarray:
    """Evaluate a closed form over the values of one letter, the others those of figure 9 or an intensity q."""
    given = dict(zip(belt.SYMBOLS, numbers(scene_of(beta)), strict=True))
    given |= {belt.SYMBOLS.a: A if q is None else q, belt.SYMBOLS.Omega: 1.0}
    known = {symbol: value for symbol, value in given.items() if symbol != letter}
    return np.asarray(numeric_function((letter,), formula.subs(known))(values) * np.ones_like(values))


def figure_9() -> FigureData:
    """Belt speeds of self-excited vibration against the frequency of the excitation."""
    curves, findings = [], []
    for k, (beta, dash) in enumerate(zip(DAMPINGS, ("solid", "dashed"), strict=True)):
        Omega, low, high = _averaged(beta)
        around = np.concatenate([low, high[::-1]])
        curves.append(
            PanelCurve(rf"(55), $\beta$ = {beta:g}", np.concatenate([Omega, Omega[::-1]]), around, k, dash=dash)
        )
        limits = bounds(beta)
        for row, marker in zip(limits[1:], ("s", "o"), strict=True):
            name = rf"full model, $\beta$ = {beta:g}"
            curves.append(PanelCurve(name, limits[0], row, k, dash="none", marker=marker))
        exact = np.array(_limits(beta, limits[0]))
        off = np.max(np.abs(exact / limits[1:] - 1))
        at = ", ".join(f"Omega = {w:g}: {a:.5f} to {b:.5f}" for w, a, b in limits.T if w in (20.0, 30.0))
        findings.append(
            Finding(
                f"agreement with simulation is very good (beta = {beta:g}), within {100 * VERY_GOOD:g} %",
                f"within {100 * off:.1f} %; {at}",
                bool(off < VERY_GOOD),
            )
        )
    last = max(bounds(DAMPINGS[0])[0])
    star = [belt.quench_intensity(scene_of(b)) / A for b in DAMPINGS]
    findings.append(
        Finding(
            "no self-excited vibration above a Omega*",
            f"(56): Omega* = {star[0]:.2f}; the full model has some at {last:g} and none at {_next(last):g}",
            last < star[0] < _next(last),
        )
    )
    findings.append(_narrowing(star))
    panel = Panel("", OMEGA, SPEED, tuple(curves), x_range=(0, 42), y_range=(0, 0.5))
    caption = (
        r"$a$ = 0.01, as figure 4 else; the second $\beta$ is ours. "
        "Squares: the motion grazes the belt's speed; circles: Neimark-Sacker point."
    )
    return FigureData("thomsen-9", caption, (panel,), 1, tuple(findings))


def _narrowing(star: list[float]) -> Finding:
    """Judge that damping narrows the range of belt speeds and lowers the frequency that quenches."""
    shared = sorted(set(bounds(DAMPINGS[0])[0]) & set(bounds(DAMPINGS[1])[0]))
    widths = [[high - low for w, low, high in bounds(b).T if w in shared] for b in DAMPINGS]
    shown = ", ".join(f"{a:.4f} to {b:.4f} at Omega = {w:g}" for w, a, b in zip(shared, *widths, strict=True))
    ends = [max(bounds(b)[0]) for b in DAMPINGS]
    return Finding(
        "damping narrows the range of belt speeds, and lowers the frequency that quenches",
        f"in the full model from beta = {DAMPINGS[0]:g} to {DAMPINGS[1]:g}: {shown}; Omega* falls from {star[0]:.2f} "
        f"to {star[1]:.2f}, and vibration is found up to {ends[0]:g} and {ends[1]:g}",
        bool(np.all(np.less(widths[1], widths[0]))) and star[1] < star[0] and ends[1] < ends[0],
    )


def _next(Omega: float) -> float:
    return min(w for w in FREQUENCIES if w > Omega)


def quench_speeds() -> FigureData:
    """Intensity that quenches at one belt speed, and at all up to it; (57) and (58)."""
    scene = scene_of(0.05)
    star, v_b1 = belt.quench_intensity(scene), belt.onset_speed(scene)
    speeds = np.union1d(np.linspace(0.002, 0.5, 250), [star, v_b1 - 1e-9, v_b1])
    v_hat = sp.Symbol("v_hat", positive=True)
    at, below = (
        _over(f(v=v_hat, symbolic=True), v_hat, speeds) for f in (belt.quench_intensity_at, belt.quench_intensity_below)
    )
    Omega, low, high = bounds(0.05)
    curves = (
        PanelCurve("(57): at this speed", speeds, at),
        PanelCurve("(58): at this speed and below", speeds, below, 1, dash="dashed"),
        PanelCurve("full model, grazing", low, A * Omega, 2, dash="none", marker="s"),
        PanelCurve("full model, Neimark-Sacker", high, A * Omega, 2, dash="none", marker="o"),
    )
    root = 3 * star**2 - 2 * speeds[speeds > star] ** 2
    v_m = numbers(scene).v_m
    small = belt.quench_intensity(scene.where({"beta": 1e-6})) / v_m
    findings = (
        Finding(
            "(57) holds for all speeds",
            f"its radicand is negative above v_b1 = {v_b1:.4f}, {root.min():.3f} at {speeds[-1]:g}; 0 is enough there",
            bool(np.all(root >= 0)),
        ),
        Finding(
            "a Omega* is about 0.8 v_m for small damping, (56)",
            f"{small:.4f} v_m for beta = 1e-6, {star / v_m:.4f} v_m here",
            round(small, 1) == 0.8,
        ),
    )
    marks = ((r"$a\Omega^*$", star), ("$v_{b1}$", v_b1))
    panel = Panel("", r"$\hat v_b$", INTENSITY, curves, x_range=(0, 0.5), y_range=(0, 0.5), marks=marks)
    return FigureData("thomsen-quench-speeds", r"$\beta$ = 0.05, as figure 4 else; $a$ = 0.01.", (panel,), 1, findings)


def _work(scene: Scene, q: float, Omega: float = 50.0) -> float:
    """Return the work of the excitation over one of its periods, in the full model after it has settled."""
    from symfric.model.outputs import Integral
    from symfric.model.symbols import TIME
    from symfric.solve.routes import simulate

    period, shaken = 2 * np.pi / Omega, scene.where({"a": q / Omega, "Omega": Omega})
    a, frequency = shaken.parameter("a"), shaken.parameter("Omega")
    power = a * frequency**2 * sp.sin(frequency * TIME) * scene.system.u[0]
    runs = [
        simulate(shaken.until(k * period, {"work": Integral(power)}), tolerance=1e-11).checked()["work"]
        for k in (1200, 1201)
    ]
    return float(runs[1] - runs[0])


def quench_energy() -> FigureData:
    """Kinetic energy and mean power of the fast motion that quenches, section 5.3."""
    scene, q = scene_of(0.05), belt.quench_intensity(scene_of(0.05))
    speeds = np.linspace(0.002, 0.5, 250)
    power = _over(belt.mean_power(symbolic=True), belt.SYMBOLS.v_b, speeds, q=q)
    phase = np.linspace(0.0, 2 * np.pi, 400)
    largest = belt.largest_pure_slip_amplitude(scene)
    waves = (
        PanelCurve("fast motion, (59)", phase, 0.5 * q**2 * np.cos(phase) ** 2),
        PanelCurve(r"largest pure slip, (60) with 2/5", phase, 0.5 * largest**2 * np.cos(phase) ** 2, 1),
        PanelCurve(
            "(60) as printed, 2/3", phase, 2 / 3 * 0.25 * (1 - 0.1 / 0.45) * np.cos(phase) ** 2, 1, dash="dotted"
        ),
    )
    ratio = (q / largest) ** 2
    share = 0.5 * largest**2 / (numbers(scene).v_m ** 2 * (1 - 2 * 0.05 / belt.friction_difference(scene)))
    spent = _work(scene.where({"v_b": 0.2}), q) / (2 * np.pi / 50.0)
    findings = (
        Finding(
            "(60): 2/3 v_m^2 (1 - 2 beta/eta)",
            f"the factor is {share:.6f}, 2/5: A0,max^2/2 with sqrt(4/5), and (61) needs it",
            abs(share - 2 / 3) < 1e-9,
        ),
        Finding("(61): ratio of the energies 5/6", f"{ratio:.6f}", abs(ratio - 5 / 6) < 1e-9),
        Finding(
            "(59) is the energy required",
            "it is the kinetic energy, which flows to and fro; what is spent is a mean power, "
            f"{spent:.4f} in the full model at v_b = 0.2 and Omega = 50, up to {power.max():.3f} on the slowest belt",
            abs(spent) < 1e-6,
        ),
    )
    panels = (
        Panel("kinetic energy", r"phase: $\Omega\tau$ or $\tau + \theta_0$", "energy", waves, y_range=(0, 0.18)),
        Panel(
            r"mean power of the excitation at $a\Omega^*$",
            SPEED,
            "power",
            (PanelCurve("", speeds, power),),
            y_range=(0, None),
            marks=((r"$a\Omega^*$", q),),
        ),
    )
    return FigureData("thomsen-quench-energy", r"$\beta$ = 0.05, $a\Omega$ = $a\Omega^*$.", panels, 2, findings)
