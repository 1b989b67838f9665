"""The equations of a scene for reading, and as LaTeX for notebooks."""

from typing import TYPE_CHECKING

import sympy as sp

from symfric.model.contact_states import coefficient
from symfric.model.outputs import normal_force
from symfric.model.springs import spring_of, stop_rate
from symfric.model.symbols import SPEED, TIME
from symfric.model.written_instants import instants_of

if TYPE_CHECKING:
    from symfric.model.scene import Scene
    from symfric.model.system import Contact

_IN_A_LINE = 6  # values in a line below the equations


def equations_of(scene: "Scene") -> tuple[sp.Eq, ...]:
    """Return the equations of motion of a scene without matrices, friction as ``sign(slip) * normal * mu(|slip|)``.

    The normal forces of contacts that open are called ``N_<contact>``.
    """
    t, system = TIME, scene.system
    moving = {s: sp.Function(_shown(s), real=True)(t) for s in system.states}
    pull = sp.zeros(len(system.q), 1)
    for c in scene.contacts:
        if c.law.memory:
            force = -c.normal * c.profile * coefficient(c)
        elif c.stiffness is not None:
            force = -c.stiffness * spring_of(c.name)
        else:
            mu = c.law.kinetic.xreplace(
                {s: sp.Abs(c.slip) for s in c.law.kinetic.free_symbols if s.name == "v" and s.is_positive}
            )
            force = -sp.sign(c.slip) * c.normal * c.profile * mu
        if c.in_plane:
            speed = sp.sqrt(sp.Add(*(w**2 for w in c.slips)))
            mu = c.law.kinetic.xreplace({SPEED: speed})
            if c.ellipse is not None:
                speed = sp.sqrt(sp.Add(*((e * w) ** 2 for e, w in zip(c.ellipse, c.slips, strict=True))))
            factors = [e**2 for e in c.ellipse or (sp.S.One, sp.S.One)]
            forces = [-c.normal * c.profile * mu * e * w / speed for e, w in zip(factors, c.slips, strict=True)]
        else:
            forces = [force]
        for w, force in zip(c.slips, forces, strict=True):
            pull += sp.Matrix([w.diff(u) * force for u in system.u])
        if c.unilateral is not None:
            pull += sp.Matrix([c.unilateral.gap.diff(q) * c.normal for q in system.q])
    rates = sp.Matrix([moving[u].diff(t) for u in system.u])
    moving |= {normal_force(c.name): reaction(c) for c in scene.contacts_that_open}
    left = (system.mass * rates).subs(moving)
    right = (sp.Matrix(system.force) + pull).subs(moving)
    kinematic = [sp.Eq(moving[q].diff(t), moving[u]) for q, u in zip(system.q, system.u, strict=True)]
    dynamic = [sp.Eq(a, b, evaluate=False) for a, b in zip(left, right, strict=True)]
    springs = (c for c in scene.contacts if c.stiffness is not None)
    rates = dict(zip(system.z, system.z_rate, strict=True)) | dict(map(stop_rate, springs))
    rates = {z: e for z, e in rates.items() if z not in {s for h in scene.held for s in h.states}}
    first = [sp.Eq(moving[z].diff(t), e.subs(moving), evaluate=False) for z, e in rates.items()]
    return (*kinematic, *dynamic, *first, *instants_of(scene, _shown))


def reaction(contact: "Contact") -> sp.Symbol:
    """Return the symbol that stands for the normal force of a contact that opens in equations for reading."""
    return sp.Symbol(f"N_{contact.name}", nonnegative=True)


def latex_of(scene: "Scene") -> str:
    """Return the equations, the values, the start and the horizon."""
    rows = r" \\ ".join(sp.latex(e.lhs) + " &= " + sp.latex(e.rhs) for e in scene.equations())
    for c in scene.contacts_that_open:
        assert c.unilateral is not None
        rows += rf" \\ 0 &\le {sp.latex(c.unilateral.gap)} \;\perp\; {sp.latex(reaction(c))} \ge 0"
    queued = {s for h in scene.held for s in h.states[1:]}
    starts = [(_at_start(s), e) for s, e in scene.initial.items() if s not in queued]
    numbers: list[tuple[sp.Symbol, float | sp.Expr | None]] = [*scene.values.items(), *starts]
    given = [sp.latex(s) + " = " + ("?" if e is None else _shown_number(e)) for s, e in numbers]
    given.append(rf"0 \le t \le {_shown_number(scene.horizon)}")
    lines = [r",\quad ".join(given[k : k + _IN_A_LINE]) for k in range(0, len(given), _IN_A_LINE)]
    rows += "".join(r" \\ & " + line for line in lines)
    return r"$\displaystyle \begin{aligned} " + rows + r" \end{aligned}$"


def _at_start(state: sp.Symbol) -> sp.Symbol:
    """Return a symbol that is printed as a state at t = 0."""
    return sp.Symbol(sp.latex(sp.Symbol(_shown(state))) + "(0)")


def _shown_number(value: float | sp.Expr) -> str:
    if not isinstance(value, float):
        return str(sp.latex(value))
    return str(sp.latex(sp.Float(value, 6))) if value % 1 or abs(value) >= 1e6 else f"{value:.0f}"


def _shown(state: sp.Symbol) -> str:
    """Return the name of a state in equations, with the contact or controller to which it belongs as an index."""
    of, dot, own = state.name.rpartition(".")
    word = own.rstrip("0123456789")
    number = own[len(word) :]
    return f"{word}_{number + ',' if number else ''}{of}" if dot else state.name
