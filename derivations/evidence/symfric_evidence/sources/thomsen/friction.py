"""Friction and effective friction of Thomsen, figures 2 and 7."""

import numpy as np

from symfric.model import laws, scenes
from symfric.theory import belt
from symfric_evidence.sources.panels import FigureData, Panel, PanelCurve
from symfric_evidence.sources.registry import Finding

MU_S, MU_M, V_M = 0.4, 0.25, 0.5
INTENSITIES = (0.1, 0.2, 0.3, 0.4, 0.5)  # for figure 7; chosen here, the source does not print them
REASONABLE = 0.1  # relative error that the word is taken for, ours
EXPANDED = (0.2, 0.5)  # of figure 7 (b)
SPEED, FRICTION = r"$v_r$", r"$\mu(v_r)$"
POINTS = 801


def odd(law: laws.Law, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return speeds and a law's values, both signs, with the vertical piece that sticking adds at rest."""
    stick = float(law.stick)
    speeds = speeds[speeds > 0]
    x = np.concatenate([-speeds[::-1], [0.0, 0.0], speeds])
    return x, np.concatenate([-law(speeds[::-1]), [-stick, stick], law(speeds)])


def figure_2() -> FigureData:
    """Friction laws: Coulomb, falling with speed, and regularised at rest."""
    v = np.linspace(0.0, 1.0, POINTS)[1:]
    falling = laws.cubic(MU_S, MU_M, V_M)
    drawn = {
        r"(a) $\mu_m = \mu_s$: Coulomb": laws.coulomb(MU_S),
        r"(b) $\mu_m = 0.25$": falling,
        r"(c) $\mu_m = 0.25$, $v_s = 0.02$": laws.thomsen_regularised(MU_S, MU_M, V_M, 0.02),
    }
    panels = tuple(
        Panel(name, SPEED, FRICTION, (PanelCurve("", *odd(law, v)),), y_range=(-0.5, 0.5))
        for name, law in drawn.items()
    )
    off = float(np.max(np.abs(laws.thomsen_regularised(MU_S, MU_M, V_M, 1e-4)(v) - falling(v))))
    words = f"(6) with v_s = 1e-4 differs from (5) by {off:.1e} at most while sliding; (6) is printed with u_s for mu_s"
    findings = (Finding("for small v_s (6) looks as (5)", words, off < 1e-3), _no_difference())
    return FigureData("thomsen-2", r"$\mu_s$ = 0.4, $v_m$ = 0.5.", panels, 3, findings)


def _no_difference() -> Finding:
    """Judge that results do not change from v_s = 1e-4 on downwards, by the largest displacement of the cycle."""
    from symfric.orbits.cycle import limit_cycle

    def reach(law: laws.Law) -> float:
        return float(limit_cycle(scenes.mass_on_belt(law, v_b=0.2), tolerance=1e-11).x_max[0])

    exact = reach(laws.cubic(MU_S, MU_M, V_M))
    off = {v_s: abs(reach(laws.thomsen_regularised(MU_S, MU_M, V_M, v_s)) - exact) for v_s in (1e-4, 1e-5)}
    shown = ", ".join(f"by {e:.1e} at v_s = {v_s:g}" for v_s, e in off.items())
    claim = "no difference in results for v_s <= 1e-4, to four digits"
    return Finding(
        claim, f"x_max of figure 3's cycle, {exact:.6f}, is off {shown}: linear in v_s", max(off.values()) < 5e-5
    )


def figure_7() -> FigureData:
    """Effective friction under fast vibration, and its expansion at rest."""
    v = np.linspace(0.0, 1.0, POINTS)[1:]
    falling = laws.cubic(MU_S, MU_M, V_M)
    whole = [PanelCurve(r"$a\Omega = 0$", *odd(falling, v))]
    for k, q in enumerate(INTENSITIES, 1):
        whole.append(PanelCurve(rf"$a\Omega = {q:g}$", *odd(falling.averaged(q), np.union1d(v, [q])), k))
    near = []
    for k, q in enumerate(EXPANDED):
        scene = scenes.mass_on_belt(v_b=0.2, a=q, Omega=1.0)
        w = np.linspace(0.0, q, POINTS)[1:]
        cubic = belt.effective_damping(scene) * w + belt.effective_cubic(scene) * w**3
        near.append(PanelCurve(rf"(47), $a\Omega = {q:g}$", w, falling.averaged(q)(w), k, dash="dashed"))
        near.append(PanelCurve(rf"(48), $a\Omega = {q:g}$", w, cubic, k))
    title = r"(b) $0 < v_r < a\Omega$: (47) and its expansion (48), (49)"
    panels = (
        Panel("(a) effective friction (47)", SPEED, r"$\bar\mu(v_r)$", tuple(whole)),
        Panel(title, SPEED, r"$\bar\mu(v_r)$", tuple(near), x_range=(0, max(EXPANDED)), y_range=(0, 0.45)),
    )
    caption = r"$\mu_s$ = 0.4, $\mu_m$ = 0.25, $v_m$ = 0.5; the intensities are ours."
    return FigureData("thomsen-7", caption, panels, 2, _of_figure_7(falling, v))


def _of_figure_7(falling: laws.Law, v: np.ndarray) -> tuple[Finding, ...]:
    import sympy as sp

    scene = scenes.mass_on_belt(v_b=0.2)
    q = np.linspace(0.1, 1.0, 3601)
    damping = 2 * MU_S / (np.pi * q) + belt.law_coefficients(scene)[1] + 1.5 * belt.law_coefficients(scene)[2] * q**2
    least, intensity = belt.least_damping_intensity(scene), float(q[np.argmin(damping)])
    printed = (4 / (3 * np.pi * (1 - MU_M / MU_S))) ** (1 / 3)
    larger = min(float(np.min(falling.averaged(e)(v[v > e]) - falling(v[v > e]))) for e in INTENSITIES)
    worst = max(float(np.max(np.abs(_expansion_error(falling, e)))) for e in EXPANDED)
    ratio = float(1 - sp.sqrt(6) / sp.pi)
    signs = {share: _rises(share) for share in (ratio - 0.005, ratio + 0.005, MU_M / MU_S)}
    good = {q: _good_up_to(falling, q, REASONABLE) for q in EXPANDED}
    return (
        Finding(
            "for |v_r| > a Omega the effective friction is the larger one", f"by {larger:.4f} at least", larger > 0
        ),
        Finding(
            f"the damping at rest is least at (a Omega)^3 = 4/(3 pi (1 - mu_m/mu_s)), a Omega = {printed:.4f}",
            f"least at {intensity:.4f}; v_m^3 is missing, with it {least:.4f}",
            abs(printed - intensity) < 1e-3,
        ),
        Finding(
            "the slope for |v_r| < a Omega is positive if mu_m/mu_s > 1 - sqrt(6)/pi = 0.22",
            f"{ratio:.4f}; " + ", ".join(f"{s:.3f}: {'rises' if up else 'falls somewhere'}" for s, up in signs.items()),
            list(signs.values()) == [False, True, True],
        ),
        Finding(
            "(48) approximates (47) reasonably for |v_r| < a Omega",
            f"off by up to {worst:.3f}, most at v_r = a Omega, where the slope of (47) is infinite; within "
            f"{100 * REASONABLE:g} % up to "
            + ", ".join(f"v_r = {s:.2f} a Omega at a Omega = {q:g}" for q, s in good.items()),
            None,
        ),
    )


def _rises(share: float) -> bool:
    """Return whether (47) rises for all |v_r| < a Omega and every a Omega up to 2 v_m, by mu_m/mu_s."""
    q, s = np.meshgrid(np.linspace(0.02, 2 * V_M, 400), np.linspace(0.0, 0.999, 400))
    fall = MU_S * (1 - share)
    slope = 2 * MU_S / (np.pi * q * np.sqrt(1 - s**2)) - 1.5 * fall / V_M
    slope += 0.75 * fall * q**2 / V_M**3 + 1.5 * fall * (s * q) ** 2 / V_M**3
    return bool(np.all(slope > 0))


def _good_up_to(falling: laws.Law, q: float, limit: float) -> float:
    """Return the share of a Omega up to which the expansion (48) stays within a relative error."""
    w = np.linspace(0.0, q, POINTS)[1:]
    good = np.abs(_expansion_error(falling, q)) <= limit * falling.averaged(q)(w)
    return float(1.0 if np.all(good) else w[np.argmin(good)] / q)


def _expansion_error(falling: laws.Law, q: float) -> np.ndarray:
    scene = scenes.mass_on_belt(v_b=0.2, a=q, Omega=1.0)
    w = np.linspace(0.0, q, POINTS)[1:]
    return np.asarray(belt.effective_damping(scene) * w + belt.effective_cubic(scene) * w**3 - falling.averaged(q)(w))
