"""A stepper as self-contained C code: CasADi's graphs, and functions with a state around them."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import casadi as ca
import sympy as sp

from symfric.errors import SceneError
from symfric.export.stepper import Stepper, stepper
from symfric.files import write_together
from symfric.locks import SYMBOLIC, alone
from symfric.long_calls import logged
from symfric.model.arguments import path_of
from symfric.model.results import Result
from symfric.model.scene import Scene

_RESERVED = (
    "auto break case char const continue default do double else enum extern float for goto if inline int long main "
    "register return short signed sizeof static struct switch typedef union unsigned void volatile while"
)
_STEM = "zzstemzz"  # stands for the name, of which CasADi allows no two underscores in a row


@dataclass(frozen=True)
class Exported(Result):
    """Files that were written, and what they hold.

    Attributes
    ----------
    files : tuple of Path
    step : float
        Length of a step, in units of time.
    states, parameters, inputs, outputs, contacts : tuple of str
        Names, in the order of the arrays of the C code.
    compiled : bool
        Whether there is machine code beside the sources.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import symfric as sf
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = sf.export.write_c(sf.scenes.coulomb_oscillator(0.1), Path(folder) / "block.c", step=1e-3)
    >>> found
    Exported(block.c, block.h; step 0.001; states x, u; outputs floor.slip, floor.friction)
    >>> found.to_dict()["contacts"]
    ['floor']
    """

    files: tuple[Path, ...]
    step: float
    states: tuple[str, ...]
    parameters: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    contacts: tuple[str, ...]
    compiled: bool = False

    def __repr__(self) -> str:
        parts = [", ".join(f.name for f in self.files), f"step {self.step:g}", f"states {', '.join(self.states)}"]
        parts += [f"outputs {', '.join(self.outputs)}"] if self.outputs else []
        return f"Exported({'; '.join(parts)})"


@logged
def write_c(
    scene: Scene, path: Path | str, step: float, outputs: Mapping[str, sp.Expr] | None = None, events: int = 4
) -> Exported:
    """Write the step of a scene as C code, for hardware in the loop and other programs.

    Parameters
    ----------
    scene : Scene
    path : Path or str
        Of the file; ends in ``.c``, and a header of the same name is written beside it. Its name begins every name in
        the code.
    step, outputs, events
        See `stepper`.

    Returns
    -------
    Exported

    Raises
    ------
    SceneError
        If `stepper` refuses the scene, or the path is not that of a C file.

    Notes
    -----
    The code is C99 without libraries but the mathematical one, allocates no memory, and does a bounded amount of work
    in a step. It computes the bits of ``stepper(...).run()``, times included and after any number of steps, if the
    compiler keeps to the rules of the language (no ``-ffast-math``, ``-ffp-contract=off``). The functions are those of
    the header: ``NAME_reset``, ``NAME_step`` and ``NAME_look``; a step returns 0, 1 after more events than it resolves,
    2 if a normal load became negative, 3 if the state is not finite.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import symfric as sf
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     belt = sf.export.write_c(sf.scenes.mass_on_belt(v_b=0.2), Path(folder) / "belt.c", step=1e-3)
    ...     "int belt_step(" in belt.files[1].read_text()
    True
    """
    place = path_of(path)
    if place.suffix != ".c":
        raise SceneError(f"{path} is no name for C code; it ends in .c, such as {place.stem or 'scene'}.c")
    name = identifier(place.stem, "the file")
    made = stepper(scene, step, outputs, events)
    sources = c_sources(made, name)
    write_together({place.with_name(f): text for f, text in sources.items()})
    return exported(made, [place.with_name(f) for f in sources])


def exported(made: Stepper, written: Iterable[Path], compiled: bool = False) -> Exported:
    """Return what was written of a stepper."""
    names = made.states, made.parameters, made.inputs, tuple(made.outputs), made.contacts
    return Exported(tuple(written), made.step, *names, compiled)


def identifier(name: str, what: str) -> str:
    """Return a name if C allows it; raise else."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,60}", name) or name in _RESERVED.split():
        raise SceneError(f"{what} is called {name!r}, which is no name in C; use letters, digits and _, such as belt")
    return name


@alone(SYMBOLIC)
def c_sources(made: Stepper, name: str) -> dict[str, str]:
    """Return the C file and its header, by file name."""
    graphs = {kind: _named(getattr(made, kind), f"{_STEM}_graph_{kind}") for kind in ("start", "advance", "look")}
    generator = ca.CodeGenerator(f"{_STEM}_graph", {"with_header": False, "indent": 2})
    for graph in graphs.values():
        generator.add(graph)
    own = {"VALUES": _numbers(made.values), "INITIAL": _numbers(made.initial), "LAYOUT": _layout(made, name)}
    for kind, g in graphs.items():
        sizes = {"ARG": g.sz_arg(), "RES": g.sz_res(), "IW": g.sz_iw(), "W": g.sz_w()}
        own |= {f"{kind.upper()}_{k}": str(max(1, n)) for k, n in sizes.items()}
    header, code = (_filled(template, name, own) for template in ("step.h", "step.c"))
    return {f"{name}.c": _head(made, name) + generator.dump().replace(_STEM, name) + code, f"{name}.h": header}


def _head(made: Stepper, name: str) -> str:
    said = f"""{name}: {len(made.states)} states and {len(made.contacts)} contacts in steps of {made.step!r}.

Made by symfric. Runge and Kutta's classical formula between events; the time of an event inside a step is found to
rounding, and there contacts stick and slip by the set-valued law of friction. The error falls with the fourth power of
the step. Build with: cc -std=c99 -O2 -ffp-contract=off -c {name}.c, and link with -lm."""
    return "/* " + said.replace("\n", "\n   ").replace("\n   \n", "\n\n") + " */\n"


def _named(f: ca.Function, name: str) -> ca.Function:
    arguments = f.mx_in()
    return ca.Function(name, arguments, f.call(arguments, True, False), f.name_in(), f.name_out())


def _numbers(values: Iterable[float]) -> str:
    return ", ".join(repr(float(v)) for v in values) or "0"


def _layout(made: Stepper, name: str) -> str:
    """Return the macros and enumerations of a header."""
    own = name.upper()
    lines = [f"#define {own}_ARRAY(n) ((n) > 0 ? (n) : 1)", f"#define {own}_STEP {made.step!r}"]
    groups = {
        "X": ("STATES", made.states),
        "P": ("PARAMETERS", made.parameters),
        "V": ("INPUTS", made.inputs),
        "Y": ("OUTPUTS", tuple(made.outputs)),
        "C": ("CONTACTS", made.contacts),
    }
    for letter, (word, names) in groups.items():
        entries = [f"{own}_{letter}_{plain}" for plain in plain_names(names)]
        lines.append(f"enum {{ {', '.join([*entries, f'{own}_{word}'])} }};")
    lines.append(f"enum {{ {own}_MEMORY = {made.advance.nnz_in(1)} }};")
    return "\n".join(lines) + "\n"


def plain_names(names: Iterable[str]) -> list[str]:
    """Return names in the characters of C, each of its own."""
    chosen: list[str] = []
    for n in names:
        plain = re.sub(r"\W", "_", n, flags=re.ASCII)
        while plain in chosen:
            plain += "_"
        chosen.append(plain)
    return chosen


def _filled(template: str, name: str, values: Mapping[str, str]) -> str:
    text = with_name(source_text(template), name)
    return re.sub(r"@(\w+)@", lambda match: values[match[1]], text)


def source_text(template: str) -> str:
    """Return a file of the folder of C sources."""
    return (files("symfric.export") / "c" / template).read_text(encoding="utf-8")


def with_name(text: str, name: str) -> str:
    """Return C code of the folder of sources with the name of a scene in place of ``scene_`` and ``SCENE_``."""
    own = {"scene_": name, "SCENE_": name.upper()}
    return re.sub("scene_|SCENE_", lambda match: own[match[0]], text)
