"""Reference pages of the public names, grouped by the layer that defines them."""

import inspect
import re
import sys
from pathlib import Path

from sphinx.pycode import ModuleAnalyzer

from docs.files import put
from docs.public_names import public_names

GROUPS = {  # the part of a name or of its module: title, and a sentence on it
    "laws": ("Friction laws", "Each returns a `sf.Law`; parameters may be numbers or symbols."),
    "control": ("Digital controllers", "Held variables of PID, state feedback, discrete systems; see `sf.Held`."),
    "mechanics": ("Lagrange's equations", "A `sf.System` from energies."),
    "scenes": ("Ready scenes", "Each returns a `sf.Scene` whose symbols carry the names of the arguments."),
    "model": ("State a problem", "Systems, contacts, scenes and what is computed of a run."),
    "solve": ("Run", "From a scene to numbers."),
    "orbits": ("Limit cycles and branches", "Periodic motions, how they change, and exponents."),
    "ensemble": ("Many cases", "Sweeps, maps and basins."),
    "theory": ("Equilibrium, stability, averaging", "What the equations say without running them."),
    "theory.belt": ("Closed forms: mass on a belt", "Each takes the ready scene `sf.scenes.mass_on_belt`."),
    "theory.drive": ("Closed forms: drawn slides", "One driven slide, and two slides in contact."),
    "theory.transient": ("Closed forms: decays", "Oscillators that friction brings to rest."),
    "theory.decay_record": ("Closed forms: decay records", "Friction and damping from the decay of a rod."),
    "theory.absorber": ("Closed forms: absorber", "The tuned mass damper without friction."),
    "theory.foundation": ("Closed forms: sprung foundation", "A foundation mass under one that excites itself."),
    "theory.presliding": ("Closed forms: presliding", "Bristles below the static friction."),
    "theory.waviness": ("Closed forms: wavy belt", "Each takes the ready scene `sf.scenes.wavy_belt`."),
    "theory.scaling": ("Closed forms: scaling", "Scaled models with rolling friction."),
    "design": ("Design", "Each returns a `sf.design.Design`, verified on the event-driven model."),
    "structures": ("Large structures", "Matrices of finite elements, modes, flutter, reduction."),
    "identify": ("From records", "Friction laws from measured motion."),
    "export": ("Other programs", "Steps of fixed length: Python, C code, units for co-simulation."),
    "motions": ("Ground motions", "Records, synthetic earthquakes, spectra."),
    "errors": ("Errors", "What wrong input and failed searches raise."),
}
SPACES = "laws", "control", "mechanics", "scenes", "design", "structures", "export", "motions", "identify"  # public so


def group_of(name: str, thing) -> str:
    """Return the key in `GROUPS` of a public name such as ``laws.coulomb``."""
    parts = name.split(".")
    if parts[0] == "theory" and len(parts) > 2:
        return ".".join(parts[:2])
    if parts[0] in SPACES and len(parts) > 1:
        return parts[0]
    module = getattr(inspect.unwrap(thing) if callable(thing) else thing, "__module__", "") or ""
    layer = module.split(".")[1] if module.startswith("symfric.") else "model"
    return {"scenefile": "model", "identification": "identify"}.get(layer, layer)


def explain_data(_app, what: str, _name: str, thing, _options, lines: list[str]) -> None:
    """Replace the docstring of a constant's class by the comment ``#:`` above the constant."""
    if what == "data":
        lines[:] = data_comment(thing)


def escape_bars(_app, _what: str, _name: str, _thing, _options, lines: list[str]) -> None:
    """Escape the bars of absolute values, which mean substitutions in reStructuredText, outside literals and code."""
    code = False
    for k, line in enumerate(lines):
        code = line.strip().startswith((">>>", "...")) or (code and bool(line.strip()))
        if not code and "|" in line:
            parts = re.split(r"(`[^`]*`)", line)
            lines[k] = "".join(p if p.startswith("`") else p.replace("|", "\\|") for p in parts)


def data_comment(thing) -> list[str]:
    """Return the comment ``#:`` above the definition of a constant."""
    for module in [m for n, m in sys.modules.items() if n.startswith("symfric.")]:
        names = [n for n, t in vars(module).items() if t is thing]
        found = ModuleAnalyzer.for_module(module.__name__).find_attr_docs() if names else {}
        if comment := next((found["", n] for n in names if ("", n) in found), None):
            return comment
    return []


def write(folder: Path) -> None:
    """Write one page for each group, and the list of them."""
    groups: dict[str, list[tuple[str, object]]] = {}
    for name, thing in public_names().items():
        groups.setdefault(group_of(name, thing), []).append((name, thing))
    order = [g for g in GROUPS if g in groups] + sorted(set(groups) - set(GROUPS))
    files = []
    for group in order:
        title, words = GROUPS.get(group, (group.capitalize(), ""))
        files.append(f"names-{group.replace('.', '-')}")
        put(folder / f"{files[-1]}.rst", _page(title, words, groups[group]))
    for old in folder.glob("names-*.rst"):
        if old.stem not in files:
            old.unlink()
    entries = "\n".join(f"   {file}" for file in files)
    put(folder / "names.rst", f"Names\n=====\n\nEvery public name, as ``import symfric as sf`` gives it.\n\n"
        f".. toctree::\n   :maxdepth: 1\n\n{entries}\n")  # fmt: skip


def _page(title: str, words: str, members: list[tuple[str, object]]) -> str:
    lines = [title, "=" * len(title), "", words.replace("`", "``"), "", ".. currentmodule:: symfric", ""]
    lines += [".. list-table::", "   :widths: auto", ""]
    for name, thing in members:
        role = "class" if inspect.isclass(thing) else "func" if callable(thing) else "data"
        lines += [f"   * - :py:{role}:`sf.{name} <symfric.{name}>`", f"     - {_first_line(thing)}"]
    for name, thing in members:
        kind = "class" if inspect.isclass(thing) else "function" if callable(thing) else "data"
        lines += ["", f".. auto{kind}:: symfric.{name}"]
        if kind == "class":
            lines += ["   :members:"]
        if kind == "data":
            lines += ["   :no-value:"]
    return "\n".join(lines) + "\n"


def _first_line(thing) -> str:
    if not (inspect.isclass(thing) or callable(thing)):
        return " ".join(data_comment(thing))
    lines = [" ".join((inspect.getdoc(thing) or "").split("\n\n")[0].split())]
    escape_bars(None, "", "", thing, None, lines)
    return lines[0] or "\\"
