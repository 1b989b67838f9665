"""Reproduction of the handbook's section 19.5: friction laws, the decay under Coulomb friction, gears, chatter."""

import numpy as np

from symfric.model import laws, scenes
from symfric.model.symbols import SPEED
from symfric.theory import falling_speeds, transient
from symfric.theory.stability import stability
from symfric_evidence.sources.panels import FigureData, Panel, PanelCurve, panels_entry
from symfric_evidence.sources.registry import Finding

DELTA = 0.08  # mu g/omega_n^2 over x0 of figure 19.17, ours: the source draws a sketch
VELOCITY, FORCE = "relative velocity $v$", "damping force $f$"
STIFF = (30.0, 0.35)  # rad/s and m, of the interface in 19.5.2, ours


def _combined(law: laws.Law, top: float, number: int = 600) -> tuple[np.ndarray, np.ndarray]:
    """Return speeds and forces from the vertical piece at rest on."""
    v = np.linspace(0.0, top, number)[1:]
    return np.concatenate([[0.0, 0.0], v]), np.concatenate([[0.0, float(law.stick)], law(v)])


def figure_15() -> FigureData:
    """Main characteristics of interface damping: stiction, Coulomb, Stribeck and viscous regions."""
    import sympy as sp
    from scipy.optimize import brentq

    law = laws.lorentz(0.8, 0.3, mu_s=1.0, b=0.35)
    ((rising, turn),) = falling_speeds(law)
    steepest = float(brentq(sp.lambdify(SPEED, law.kinetic.diff(SPEED, 2)), 0.01, 1.0))
    first = 0.5 * steepest
    marks = (("1 | 2", first), ("unstable | stable", turn))
    levels = (("$f_s$", 1.0), ("$f_d$", 0.8))
    panel = Panel(
        "", VELOCITY, FORCE, (PanelCurve("", *_combined(law, 2.0)),), y_range=(0, 1.15), marks=marks, levels=levels
    )
    slope = float(sp.limit(law.kinetic.diff(SPEED), SPEED, 0, "+"))
    dry = falling_speeds(laws.lorentz(0.8, 0.3, mu_s=1.0))
    unstable = {v: not _slides_steadily(law, v) for v in (0.5 * rising, 0.5 * (rising + turn), 1.5 * turn)}
    findings = (
        Finding(
            "the slope is negative in regions 1 and 2, which is the unstable region",
            f"{slope:+.2f} at v = 0+ and positive up to v = {rising:.5f}, negative from there to {turn:.5f}",
            rising == 0,
        ),
        Finding(
            "the same without the viscous part, b = 0",
            f"negative from v = {dry[0][0]:g} to {dry[0][1]:g}",
            dry == ((0.0, np.inf),),
        ),
        Finding(
            "steady sliding is unstable where the slope is negative, and only there",
            ", ".join(f"v = {v:.4f}: {'unstable' if grows else 'stable'}" for v, grows in unstable.items()),
            list(unstable.values()) == [False, True, False],
        ),
        Finding(
            "regions 1 and 2 are apart",
            "the models (19.106) to (19.108) fall from rest on; where Coulomb friction ends is a choice",
            None,
        ),
    )
    caption = (
        "(19.105) with (19.106): $f_s$ = 1, $f_d$ = 0.8, $v_c$ = 0.3, $b$ = 0.35, ours; the source draws a sketch."
    )
    return FigureData("handbook-19.15", caption, (panel,), 1, findings)


def _slides_steadily(law: laws.Law, speed: float) -> bool:
    """Return whether a mass on a spring slides steadily on a belt of some speed, without a damper."""
    return bool(stability(scenes.mass_on_belt(law, v_b=speed, beta=0.0)).stable)


def models() -> FigureData:
    """The three models of the Stribeck effect, (19.106) to (19.108), with viscous friction."""
    models_by_name = {
        "(19.106)": laws.lorentz(0.8, 0.3, mu_s=1.0, b=0.35),
        "(19.107)": laws.gauss(0.8, 0.3, mu_s=1.0, b=0.35),
        "(19.108)": laws.square_root(0.8, -0.9, mu_s=1.0, b=0.9),
    }
    curves = tuple(PanelCurve(name, *_combined(law, 1.5), k) for k, (name, law) in enumerate(models_by_name.items()))
    panel = Panel("", VELOCITY, FORCE, curves, y_range=(0, 1.15), levels=(("$f_s$", 1.0), ("$f_d$", 0.8)))
    dry = {"(19.106)": laws.lorentz(0.8, 0.3), "(19.107)": laws.gauss(0.8, 0.3)}
    ends = {name: (float(law.at_rest), float(law(1e3))) for name, law in dry.items()}
    signs = {alpha: falling_speeds(laws.square_root(0.8, alpha, b=0.9)) for alpha in (-0.9, 0.9)}
    findings = (
        Finding(
            "f_d represents dynamic Coulomb friction, at every speed",
            "f_d = 0.8; "
            + ", ".join(f"{n} is {low:g} at v = 0+ and {high:.1g} at v = 1000" for n, (low, high) in ends.items()),
            all(high == low for low, high in ends.values()),
        ),
        Finding(
            "(19.108) models the Stribeck effect for either sign of alpha",
            "; ".join(
                f"alpha = {a:g}: " + (f"falls up to v = {s[0][1]:g}" if s else "falls nowhere")
                for a, s in signs.items()
            )
            + "; it carries sgn(v) already",
            all(signs.values()),
        ),
    )
    caption = r"$f_s$ = 1, $f_d$ = 0.8, $v_c$ = 0.3, $b$ = 0.35; (19.108) with $\alpha$ = -0.9, $b$ = 0.9; ours."
    return FigureData("handbook-models", caption, (panel,), 1, findings)


def figure_17() -> FigureData:
    """Response of a mass on a spring under Coulomb friction, with the equilibria of both directions."""
    from symfric.solve.routes import simulate

    scene = scenes.coulomb_oscillator(DELTA)
    run = simulate(scene).checked()
    count = transient.half_cycles(DELTA)
    t = np.linspace(0.0, (count + 1) * np.pi, 2000)
    drawn = [PanelCurve("", t, run(t)[0])]
    turns = np.arange(count + 1) * np.pi
    envelope = np.abs(run(turns)[0])
    drawn.append(PanelCurve("turning points", turns, run(turns)[0], 1, dash="none", marker="o"))
    marks = ((r"$\pi/\omega_n$", np.pi), (r"$2\pi/\omega_n$", 2 * np.pi))
    panel = Panel(
        "", r"$\omega_n t$", "$x/x_0$", tuple(drawn), marks=marks, levels=((r"$\Delta$", DELTA), (r"$-\Delta$", -DELTA))
    )
    lost = np.diff(envelope[: count + 1])
    stop = transient.stop_position(DELTA)
    findings = (
        Finding(
            "each half cycle loses 2 Delta, (xiii), (xiv)",
            f"between {-lost.max():.6f} and {-lost.min():.6f}; 2 Delta = {2 * DELTA:g}",
            float(np.max(np.abs(lost + 2 * DELTA))) < 1e-6,
        ),
        Finding(
            "a half cycle needs x0 > (4i - 3) Delta or (4i - 1) Delta",
            f"{count} half cycles, rest at {stop:+.4f}: within Delta, where the static friction holds it",
            len(run.events) == count,
        ),
    )
    caption = rf"$\Delta = \mu g/\omega_n^2$ = {DELTA:g} $x_0$, ours; the source draws a sketch."
    return FigureData("handbook-19.17", caption, (panel,), 1, findings)


def gear() -> laws.Law:
    """Return friction with two straight sections, within the axes of figure 19.18."""
    return laws.piecewise_linear(0.05, [0.0, 2.0], [0.05, 0.014], last_slope=0.0012)


def figure_19() -> FigureData:
    """Friction model for rotatory devices: two straight lines."""
    v = np.linspace(0.0, 10.0, 501)
    curve = PanelCurve("", np.concatenate([[0.0], v]), np.concatenate([[0.0], gear()(np.maximum(v, 1e-12))]))
    panel = Panel("", "pitch line velocity [m/s]", "coefficient of friction", (curve,), y_range=(0, 0.055))
    finding = Finding("the measured curve of figure 19.18 is close to two straight lines", "no data is printed", None)
    caption = "Slopes and corner are ours, within the axes of figure 19.18, of which no data is printed."
    return FigureData("handbook-19.19", caption, (panel,), 1, (finding,))


def chatter() -> FigureData:
    """Instability by the falling section, 19.5.2: growth from steady sliding to a cycle."""
    panels, growth = [], {}
    for title, speed, start in (("falling section, $v_b$ = 1", 1.0, 0.02), ("rising section, $v_b$ = 3", 3.0, 0.5)):
        t, x, u, rest = _interface(speed, start)
        growth[speed] = np.ptp(x[t > 0.9 * t[-1]]) / np.ptp(x[t < 0.1 * t[-1]])
        panels.append(Panel(title, "$t$ [s]", "$x$ [m]", (PanelCurve("", t, x),), levels=(("", rest),)))
    t, x, u, _ = _interface(1.0, 0.02)
    cycle = _frequency(t, x)
    at_rest, x_rest, *_ = _interface(0.0, 5.0)
    still = float(np.ptp(x_rest[at_rest > 0.9 * at_rest[-1]]) / np.ptp(x_rest[at_rest < 0.1 * at_rest[-1]]))
    panels.append(
        Panel("phase plane, $v_b$ = 1", "$x$ [m]", r"$\dot x$ [m/s]", (PanelCurve("", x, u),), levels=(("$v_b$", 1.0),))
    )
    findings = (
        Finding(
            "a slight disturbance grows where the slope is negative",
            f"{growth[1.0]:.1f} times, up to a cycle",
            growth[1.0] > 1,
        ),
        Finding("it decays where the slope is positive", f"to {growth[3.0]:.2f} of its range", growth[3.0] < 1),
        Finding(
            "initially the velocity is x' = 0, there b is negative and (19.109) unstable",
            f"on a belt at rest the range falls to {still:.2f} of the start: friction only takes energy there",
            still > 1,
        ),
        Finding(
            "the frequency of the cycle primarily depends on inertia and stiffness",
            f"{cycle:.4f} rad/s, and sqrt(k/m) = {STIFF[0]:g}",
            abs(cycle / STIFF[0] - 1) < 0.2,
        ),
    )
    caption = "Two straight lines as figure 19.19, ten times as high, on a belt; ours."
    return FigureData("handbook-chatter", caption, tuple(panels), 3, findings)


def _frequency(t: np.ndarray, x: np.ndarray) -> float:
    """Return the angular frequency of a vibration from its upward passages through its mean, late in the record."""
    late = t > 0.7 * t[-1]
    t, x = t[late], x[late] - 0.5 * (x[late].max() + x[late].min())
    up = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    crossings = t[up] - x[up] * (t[up + 1] - t[up]) / (x[up + 1] - x[up])
    return float(2 * np.pi / np.mean(np.diff(crossings)))


def _interface(speed: float, start: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Return times, place, velocity and the place of steady sliding of a mass on a belt with two-slope friction."""
    import sympy as sp

    from symfric.model.scene import Scene
    from symfric.model.system import Contact, System
    from symfric.solve.routes import simulate
    from symfric.theory.equilibrium import equilibrium

    x, u, omega, v_b, x0 = sp.symbols("x u omega v_b x_0", real=True)
    law = laws.piecewise_linear(0.5, [0.0, 2.0], [0.5, 0.14], last_slope=0.012)
    scene = Scene(
        system=System(q=[x], u=[u], mass=[[1]], force=[-(omega**2) * x]),
        contacts=[Contact("interface", slip=u - v_b, normal=9.81, law=law)],
        values={omega: STIFF[0], v_b: speed, x0: 0.0},
        initial={x: x0, u: 0.0},
        horizon=12.0,
    )
    rest = float(equilibrium(scene.where({x0: 0.0})).x[0]) if speed else 0.0
    run = simulate(scene.where({x0: rest + start * STIFF[1] / 10}), tolerance=1e-10).checked()
    t = np.union1d(np.linspace(0.0, 12.0, 6000), run.t)
    place, velocity = run(t)
    return t, place, velocity, rest


FIGURES = {
    "handbook-19.15": panels_entry(figure_15),
    "handbook-19.17": panels_entry(figure_17),
    "handbook-19.19": panels_entry(figure_19),
    "handbook-models": panels_entry(models),
    "handbook-chatter": panels_entry(chatter),
}
