"""Build a `Scene` from a checked scene file: ready models and laws by their signatures, own equations by the parser."""

import difflib
import inspect
import keyword
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import sympy as sp

from symfric.errors import SceneError
from symfric.model import outputs as kinds
from symfric.model import scenes
from symfric.model.laws import Law
from symfric.model.outputs import normal_force
from symfric.model.scene import Scene
from symfric.model.symbols import TIME, nearest, shorten
from symfric.model.system import Contact, System
from symfric.model.unilateral import Unilateral
from symfric.motions.motion import Motion
from symfric.scenefile.arguments import (
    as_expr,
    call,
    call_at,
    check_arguments,
    finite_value,
    functions_returning,
    real_symbols,
)
from symfric.scenefile.contact_tables import FrictionTable, OwnFriction
from symfric.scenefile.expressions import RESERVED, parse_expression
from symfric.scenefile.held import held_symbols, held_variables, resets
from symfric.scenefile.laws import LawSpec, contact_name, contact_place, law_of, spec_of
from symfric.scenefile.schema import Document, OwnScene, ReadyScene
from symfric.scenefile.structure import StructurePlan, build_structure
from symfric.scenefile.structure_tables import StructureScene

OF_EXPRESSION = kinds.words(kinds.OutputOfExpression)
PLAIN = {word: kind for word, kind in kinds.words().items() if word not in OF_EXPRESSION}


def ready_scenes() -> dict[str, Callable[..., Scene]]:
    """Return the ready scenes by name."""
    return functions_returning(scenes, Scene)


@dataclass(frozen=True, eq=False)
class Built:
    """A scene, its laws for display, and of a structure what its page needs."""

    scene: Scene
    laws: tuple[LawSpec, ...]
    structure: StructurePlan | None = None


def build_scene(
    document: Document, motion: Motion | None = None, folder: Path | None = None, motions: Sequence[Motion] = ()
) -> Built:
    """Return the scene of a document.

    Parameters
    ----------
    document : Document
    motion : Motion, optional
        The ground motion.
    folder : Path, optional
        Of the scene file, relative to which matrices are found.
    motions : sequence of Motion
        The ground motions along x and y.
    """
    _check_names(document)
    plan = None
    if not isinstance(document.scene, OwnScene) and (document.held or document.reset):
        key = "[held]" if document.held else "[[reset]]"
        raise SceneError(f"{key} belongs to own equations; write these in [scene] in place of a model or a structure")
    if isinstance(document.scene, StructureScene):
        scene, specs, plan = build_structure(document, document.scene, folder)
    elif document.flutter is not None:
        raise SceneError("[flutter] is about structures; give scene.structure, or remove it")
    elif isinstance(document.scene, ReadyScene):
        scene, specs = _from_library(document, document.scene, motion, motions)
    else:
        scene, specs = _from_equations(document, document.scene)
    if document.outputs:
        scene = scene.wanting(_outputs(document, scene))
    return Built(scene, specs, plan)


def observables(scene: Scene) -> dict[str, sp.Symbol]:
    """Return coordinates and velocities, and the named rows of a structure, by name."""
    rows = (s for s in scene.system.rows if s.name.isidentifier())
    return {s.name: s for s in (*scene.system.q, *scene.system.u, *rows)}


def _check_names(document: Document) -> None:
    """Raise on names that are not valid in expressions or are already used."""
    given = [("values", name) for name in document.values]
    given += [("held", name) for name in document.held]
    if isinstance(document.scene, OwnScene):
        given += [(f"scene.{k}", n) for k in ("coordinates", "velocities", "z") for n in getattr(document.scene, k)]
    taken = {name: place for place, name in given if place != "held"}
    twice = next((name for name in document.held if name in taken), None)
    if twice is not None:
        raise SceneError(f"held.{shorten(twice, 40)} is also one of {taken[twice]}; rename one")
    for place, name in given:
        if not re.fullmatch(r"[A-Za-z_][A-Za-z_0-9]*", name):
            raise SceneError(f"{place}: {shorten(name, 40)!r} is not a name; use letters, digits and _")
        if keyword.iskeyword(name):
            raise SceneError(f"{place}: {name} is a word Python reserves; rename it, for example {name}_")
        if name in RESERVED or name == TIME.name:
            raise SceneError(f"{place}: {name} is taken ({'time' if name == TIME.name else 'a function'}); rename it")


def _from_library(
    document: Document, section: ReadyScene, motion: Motion | None, motions: Sequence[Motion]
) -> tuple[Scene, tuple[LawSpec, ...]]:
    """Return a ready scene; `[values]` holds its numbers, `[scene]` its options, `[friction]` its law."""
    known = ready_scenes()
    if section.model not in known:
        raise SceneError(f"scene.model: no ready scene {shorten(section.model, 40)!r}{nearest(section.model, known)}")
    function = known[section.model]
    parameters = inspect.signature(function).parameters
    own = [k for k in section.__pydantic_extra__ if k in OwnScene.model_fields and k not in parameters]
    if own:
        raise SceneError(f"scene.{own[0]}: a ready scene brings its own equations; remove {own[0]}, or model")
    arguments = dict(section.__pydantic_extra__)
    _check_options(function, arguments)
    if motion is not None:
        arguments["motion"] = motion
    elif "motion" in parameters:
        raise SceneError("scene.motion is missing; give a record's path, or a table: {kind = 'synthetic', seed = 1}")
    if motions:
        arguments["motions"] = tuple(motions)
    elif "motions" in parameters:
        raise SceneError("scene.motions is missing; give two, along x and y: paths of records, or tables with kind")
    law_values: dict[str, float] = {}
    for name, value in document.values.items():
        if name in arguments:
            raise SceneError(f"values.{name} is also given in [scene]; keep one")
        (arguments if name in parameters else law_values)[name] = value
    specs: tuple[LawSpec, ...] = ()
    if document.friction:
        arguments["law"], specs = _only_law(document, function, law_values)
    unknown = set(law_values) - {s.name for s in arguments["law"].free_symbols} if document.friction else law_values
    for name in law_values:
        if name in unknown:
            hint = nearest(name, [p for p in parameters if p != "law"])
            raise SceneError(f"values.{name}: {section.model} has no argument {name}{hint}")
    check_arguments("[scene]", function, arguments, "[values]")
    scene = call("[scene]", function, arguments)
    unset = {s.name: law_values.get(s.name, document.values.get(s.name)) for s, v in scene.values.items() if v is None}
    scene = scene.where({n: v for n, v in unset.items() if v is not None})
    specs = tuple(replace(spec, contact=scene.contacts[0].name) for spec in specs)
    return (scene.starting(section.initial) if section.initial else scene), specs


def _check_options(function: Callable[..., Scene], options: Mapping[str, Any]) -> None:
    """Raise if an option is text instead of a number or the reverse, judged by the function's default."""
    for name, value in options.items():
        if name == "law":
            raise SceneError("scene.law: the friction law has its own section; write [friction] with law = ...")
        parameter = inspect.signature(function).parameters.get(name)
        default = None if parameter is None else parameter.default
        number = isinstance(default, float | int) and not isinstance(default, bool)
        if number and isinstance(value, str | bool | list):
            raise SceneError(f"scene.{name} is {shorten(repr(value), 30)}, not a number; write a plain number")
        if isinstance(default, str) and not isinstance(value, str):
            raise SceneError(f"scene.{name} is {shorten(value, 30)}, not text; write it in quotes, as {default!r}")


def _only_law(
    document: Document, function: Callable[..., Scene], values: Mapping[str, Any]
) -> tuple[Law, tuple[LawSpec, ...]]:
    """Return the law of a ready scene with one contact, whose place the model defines."""
    if "law" not in inspect.signature(function).parameters:
        raise SceneError(f"[friction]: {function.__name__} has its own friction; remove the section")
    if len(document.friction) > 1:
        raise SceneError(f"[friction]: {function.__name__} has one contact, the file gives {len(document.friction)}")
    friction = document.friction[0]
    for key in ("slip", "normal", "profile"):
        if getattr(friction, key) is not None:
            raise SceneError(f"friction.{key}: {function.__name__} defines where its contact acts; remove {key}")
    law = law_of(friction, "friction", real_symbols([*values, *document.values]), document.values)
    return law, (spec_of(friction, friction.name or ""),)


def _from_equations(document: Document, section: OwnScene) -> tuple[Scene, tuple[LawSpec, ...]]:
    """Return a scene from the equations in the file."""
    states = real_symbols([*section.coordinates, *section.velocities, *section.z])
    parameters = real_symbols(document.values)
    names = {**states, **held_symbols(document.held), **parameters, TIME.name: TIME}
    held = held_variables(document.held, names)

    pressing = [contact_name(document, i) for i, f in enumerate(document.friction) if _opens(f)]

    def moved(given: float | str, place: str) -> sp.Expr:
        """Return an expression in which normal forces of contacts that open may stand."""
        return as_expr(given, place, names, pressing, (normal_force.__name__,))

    def slipping(given: float | str | list[float | str], place: str) -> sp.Expr | tuple[sp.Expr, ...]:
        """Return a slip, or the pair of a contact in the plane."""
        if isinstance(given, list):
            return tuple(moved(e, f"{place}[{k}]") for k, e in enumerate(given))
        return moved(given, place)

    rows = [[as_expr(e, f"scene.mass[{i}][{j}]", names) for j, e in enumerate(r)] for i, r in enumerate(section.mass)]
    if len({len(row) for row in rows}) > 1:
        raise SceneError("scene.mass: the rows differ in length; write a square matrix")
    system = System(
        q=[states[n] for n in section.coordinates],
        u=[states[n] for n in section.velocities],
        mass=rows,
        force=[moved(e, f"scene.force[{i}]") for i, e in enumerate(section.force)],
        z=[states[n] for n in section.z],
        z_rate=[moved(e, f"scene.z_rate[{i}]") for i, e in enumerate(section.z_rate)],
    )
    contacts, specs = [], []
    for i, friction in enumerate(document.friction):
        assert isinstance(friction, OwnFriction)
        place, name = contact_place(document, i), contact_name(document, i)
        _check_parts(friction, place)
        parts = {
            key: moved(getattr(friction, key), f"{place}.{key}")
            for key in ("normal", "profile", "gap", "restitution")
            if getattr(friction, key) is not None
        }
        if friction.slip is not None:
            parts["slip"] = slipping(friction.slip, f"{place}.slip")
        if friction.ellipse is not None:
            parts["ellipse"] = [moved(e, f"{place}.ellipse[{k}]") for k, e in enumerate(friction.ellipse)]
        if _opens(friction):
            parts["normal"] = Unilateral(parts.pop("gap"), parts.pop("restitution", sp.S.Zero))
            parts.setdefault("slip", None)
        if parts["slip"] is not None:
            parts["law"] = law_of(friction, place, parameters, document.values)
            specs.append(spec_of(friction, name))
        contacts.append(call_at(f"[{place}]", Contact, {"name": name, **parts}))
    initial = {n: as_expr(v, f"scene.initial.{shorten(n, 40)}", parameters) for n, v in section.initial.items()}
    numbers = {s: document.values[n] for n, s in parameters.items()}
    starts = {n: sp.sympify(e) for h in held for n, e in h.starts.items()}
    _check_start(system, contacts, starts | initial, numbers)
    scene = call(
        "[scene]",
        Scene,
        {
            "system": system,
            "contacts": contacts,
            "values": numbers,
            "initial": initial,
            "horizon": section.horizon,
            "held": held,
            "resets": resets(document.reset, names),
        },
    )
    return scene, tuple(specs)


def _opens(friction: FrictionTable) -> bool:
    return isinstance(friction, OwnFriction) and friction.gap is not None


def _check_parts(friction: OwnFriction, place: str) -> None:
    """Raise on keys of a contact that are missing, or do not go together."""
    given = {key for key in ("slip", "normal", "profile", "gap", "restitution") if getattr(friction, key) is not None}
    if "gap" not in given:
        for key in ("slip", "normal"):
            if key not in given:
                near = difflib.get_close_matches(key, friction.model_extra or {}, n=1, cutoff=0.6)
                cure = f"is {near[0]} meant?" if near else "own equations say where the contact acts"
                raise SceneError(f"{place}.{key} is missing; {cure}")
        if "restitution" in given:
            raise SceneError(f"{place}.restitution is for contacts that open; add gap, or remove it")
        return
    if "normal" in given:
        raise SceneError(f"{place}.normal: the normal force of a contact with a gap is unknown; remove normal, or gap")
    if "slip" not in given:
        rubbing = next((k for k in ("law", "profile") if getattr(friction, k) is not None), None)
        rubbing = rubbing or next(iter(friction.model_extra or {}), None)
        if rubbing:
            raise SceneError(f"{place}.{rubbing} needs a slip; add slip, or remove it for a stop without friction")


def _check_start(
    system: System, contacts: list[Contact], initial: Mapping[str, Any], numbers: Mapping[str, Any]
) -> None:
    """Raise on expressions that are not finite at the start.

    Evaluated in floats, because exact arithmetic does not terminate for expressions such as cosh(exp(1e9*x)).
    """
    for name, e in initial.items():
        numbers = {**numbers, sp.Symbol(name, real=True): finite_value(e, numbers, f"scene.initial.{name}")}
    numbers = {**numbers, TIME: 0.0}
    parts = {f"scene.force[{i}]": e for i, e in enumerate(system.force)}
    parts |= {f"scene.z_rate[{i}]": e for i, e in enumerate(system.z_rate)}
    parts |= {f"scene.mass[{i}]": e for i, e in enumerate(system.mass)}
    for c in contacts:
        parts |= {f"{key} of contact {c.name!r}": getattr(c, key) for key in ("normal", "profile")}
        parts |= {f"slip of contact {c.name!r}" + f", component {k}" * c.in_plane: e for k, e in enumerate(c.slips)}
        if c.unilateral is not None:
            parts |= {f"{key} of contact {c.name!r}": getattr(c.unilateral, key) for key in ("gap", "restitution")}
        parts |= {f"coefficient of contact {c.name!r}": e for e in (c.law.stick, *c.law.breaks)}
    for place, e in parts.items():
        if e.free_symbols <= set(numbers):
            finite_value(e, numbers, place)


def _outputs(document: Document, scene: Scene) -> dict[str, kinds.Output]:
    """Return the outputs, written as ``max(x)``, ``integral(k*x*u)``, ``end``, ..."""
    names = {s.name: s for s in (*scene.system.states, *scene.parameters)} | observables(scene) | {TIME.name: TIME}
    contacts = [c.name for c in scene.contacts]
    result = {}
    for name, text in document.outputs.items():
        place = f"outputs.{shorten(name, 40)}"
        match = re.fullmatch(r"\s*([A-Za-z_]+)\s*(?:\((.*)\))?\s*", text, re.DOTALL)
        word, inside = match.groups() if match else (shorten(text, 40), None)
        if word in PLAIN and not (inside or "").strip():
            result[name] = PLAIN[word]()
        elif word in OF_EXPRESSION:
            if inside is None:
                raise SceneError(f"{place}: {word} needs an expression; write {word}({scene.system.q[0].name})")
            result[name] = _of_expression(word, inside, names, place, contacts)
        else:
            known = [*PLAIN, *OF_EXPRESSION]
            raise SceneError(f"{place}: no output {shorten(word, 40)!r}{nearest(word, known)}")
    return result


def _of_expression(
    word: str, inside: str, names: Mapping[str, sp.Expr], place: str, contacts: Sequence[str]
) -> kinds.Output:
    """Read an output of an expression, with times after commas if it takes any."""
    expression, *times = _at_commas(inside)
    given = [parse_expression(expression, names, place, contacts)]
    kind = OF_EXPRESSION[word]
    if issubclass(kind, kinds.OutputAfter):
        return _after(kind, given[0], times, place)
    if len(fields(OF_EXPRESSION[word])) == 1:
        if times:
            raise SceneError(f"{place}: {word} takes one expression, and {shorten(inside, 40)!r} has commas")
        return OF_EXPRESSION[word](*given)
    try:
        numbers = [float(t) for t in times]
    except ValueError:
        raise SceneError(f"{place}: the times of {word} are numbers after commas: {word}(x, 0.5, 1)") from None
    try:
        if word == "at":
            return kinds.At(given[0], *numbers)
        return kinds.Samples(given[0], tuple(numbers))
    except TypeError:
        raise SceneError(f"{place}: {word} takes one time; write samples({shorten(expression, 30)}, ...)") from None
    except SceneError as error:
        raise SceneError(f"{place}: {error}") from None


def _after(kind: type[kinds.OutputAfter], given: sp.Expr, rest: list[str], place: str) -> kinds.Output:
    """Read an output that may leave out the begin of the run."""
    if not rest:
        return kind(given)
    name, _, number = rest[0].partition("=")
    try:
        after = float(number) if len(rest) == 1 and name.strip() == "after" else None
    except ValueError:
        after = None
    if after is None:
        said = shorten(",".join(rest), 40).strip()
        raise SceneError(f"{place}: {kind.word} takes one expression, and after=NUMBER behind a comma, not {said!r}")
    try:
        return kind(given, after=after)
    except SceneError as error:
        raise SceneError(f"{place}: {error}") from None


def _at_commas(text: str) -> list[str]:
    """Split a text at its commas outside parentheses."""
    parts, depth, begin = [], 0, 0
    for k, letter in enumerate(text):
        depth += (letter in "([") - (letter in ")]")
        if letter == "," and depth == 0:
            parts.append(text[begin:k])
            begin = k + 1
    return [*parts, text[begin:]]
