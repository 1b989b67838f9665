"""Every public name explains itself: arguments, results, exceptions, and an example that runs."""

import ast
import doctest
import importlib
import inspect
import re
from dataclasses import fields, is_dataclass
from pathlib import Path

import matplotlib
import pytest

import symfric as sf
from docs.public_names import public_methods, public_names

NAMES = {name: thing for name, thing in public_names().items() if callable(thing)}
FUNCTIONS = {name: thing for name, thing in NAMES.items() if not inspect.isclass(thing)}
CLASSES = {name: thing for name, thing in NAMES.items() if inspect.isclass(thing)}
METHODS = {f"{n}.{m}": (kind, m) for n, kind in CLASSES.items() for m in public_methods(kind)}


def sections(doc):
    """Return the text of each section of a docstring in numpydoc's manner."""
    parts = re.split(r"^(\S[^\n]*)\n-{3,}\n", f"{doc or ''}\n", flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def told(section):
    """Return the names before the colons of a section, ``a, b : float`` as both."""
    lines = [line for line in section.splitlines() if line and not line.startswith(" ")]
    return {name.strip(" *") for line in lines for name in line.split(" :")[0].split(",")}


def arguments(function):
    return [p for p in inspect.signature(function).parameters if p not in ("self", "cls") and not p.startswith("_")]


def raised(function):
    """Return the exceptions that the source of a function raises itself."""
    return set(
        re.findall(r"raise (SceneError|NotFound|NoRoute|RunFailed)\(", inspect.getsource(inspect.unwrap(function)))
    )


def missing(name, function, example=True):
    """Return what the docstring of a function does not tell."""
    said = sections(inspect.getdoc(function))
    found = [f"{name}: {p}" for p in arguments(function) if p not in told(said.get("Parameters", ""))]
    if inspect.signature(function).return_annotation not in (None, "None") and "Returns" not in said:
        found.append(f"{name}: Returns")
    found += [f"{name}: {error}" for error in raised(function) if error not in said.get("Raises", "")]
    return found + ([f"{name}: Examples"] if example and "Examples" not in said else [])


def test_the_audit_sees_what_is_missing():
    def bare(a, b):
        """Do.

        Parameters
        ----------
        a : float
        """
        if a:
            raise sf.SceneError("no")
        raise NotFound(b)

    NotFound = sf.NotFound
    assert missing("bare", bare) == ["bare: b", "bare: Returns", "bare: NotFound", "bare: Examples"]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_tell_everything(name):
    assert missing(name, FUNCTIONS[name]) == []


@pytest.mark.parametrize("name", CLASSES)
def test_classes_tell_everything(name):
    kind = CLASSES[name]
    said = sections(inspect.getdoc(kind))
    own = [f.name for f in fields(kind) if f.repr and not f.name.startswith("_")] if is_dataclass(kind) else []
    own += getattr(kind, "_fields", ())
    listed = told(said.get("Attributes", "") + "\n" + said.get("Parameters", ""))
    assert [f for f in own if f not in listed and f != "linear"] == []
    for attribute, value in vars(kind).items():
        if isinstance(value, property) and not attribute.startswith("_"):
            assert value.__doc__, f"{name}.{attribute} has no docstring"
    assert "Examples" in said


@pytest.mark.parametrize("name", METHODS)
def test_methods_tell_everything(name):
    kind, method = METHODS[name]
    shown = f".{method}(" in sections(inspect.getdoc(kind)).get("Examples", "")
    assert missing(name, getattr(kind, method), example=not shown) == []


ROOT = Path(sf.__file__).parents[1]
EXAMPLES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts): path
    for path in sorted((ROOT / "symfric").rglob("*.py"))
    if ">>>" in path.read_text(encoding="utf-8")
}


def examples(module):
    """Return the examples in the docstrings of a module."""
    parser, path = doctest.DocTestParser(), EXAMPLES[module]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        doc = isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Module) and ast.get_docstring(node)
        if doc and ">>>" in doc:
            known = {} if "import symfric" in doc else vars(importlib.import_module(module)).copy()
            yield parser.get_doctest(doc, known, getattr(node, "name", module), str(path), 0)


# other tests of the same functions run by default, and an example that is not named here does
COSTLY = {
    "symfric.design.absorber.classic": ["absorber"],
    "symfric.design.absorber.foundation": ["sprung_foundation"],
    "symfric.design.contact_damper.design": ["contact_damper"],
    "symfric.design.controller.design": ["controller"],
    "symfric.design.damper.design": ["damper"],
    "symfric.design.isolator.design": ["isolator"],
    "symfric.design.optimal_control.collocation": ["Profile", "collocation"],
    "symfric.design.positioning.design": ["positioning"],
    "symfric.design.quench.design": ["quench"],
    "symfric.design.result": ["Curve", "Design"],
    "symfric.ensemble.attractors": ["Attractor"],
    "symfric.ensemble.exceedance": ["plot_probability"],
    "symfric.errors": ["NotFound"],
    "symfric.export.fmu": ["write_fmu"],
    "symfric.export.stepper": ["Stepper"],
    "symfric.identification.comparison": ["Comparison", "compare_laws"],
    "symfric.identification.experiments": ["TestDesign", "test_design"],
    "symfric.identification.fit": ["Fit", "holding"],
    "symfric.identification.identify": ["identify"],
    "symfric.identification.profile": ["Profile"],
    "symfric.long_calls": ["keep_when_interrupted"],
    "symfric.model.control": ["pid", "discrete"],
    "symfric.model.laws.law": ["averaged_across"],
    "symfric.model.outputs.output": ["second_slopes"],
    "symfric.model.outputs.times": ["Period"],
    "symfric.model.results": ["plot"],
    "symfric.model.scene": ["Scene", "study"],
    "symfric.model.scenes.impacts": [
        "vibratory_conveyor",
        "impact_oscillator",
        "cam_follower",
        "brake_pad",
        "mass_with_stops",
    ],
    "symfric.model.scenes.isolator": ["rolling_isolator"],
    "symfric.model.scenes.plane": ["block_on_incline", "friction_pendulum"],
    "symfric.model.scenes.rocking": ["rocking_block"],
    "symfric.model.scenes.slides": ["drive_stop"],
    "symfric.motions.synthetic": ["synthetic"],
    "symfric.orbits.continuation.codim1": ["Curve"],
    "symfric.orbits.cycle.orbit": ["animate"],
    "symfric.orbits.frequency_response": ["frequency_response"],
    "symfric.orbits.lyapunov": ["Lyapunov"],
    "symfric.report.explorer.live": ["Exploration", "explore", "stop"],
    "symfric.solve.casadi_function": ["as_function"],
    "symfric.solve.run": ["animate"],
    "symfric.structures.flutter_map": ["FlutterMap", "flutter_map"],
    "symfric.structures.makers": ["beam"],
    "symfric.structures.onset": ["LiftOff", "Onset", "onset"],
    "symfric.theory.belt.excited": ["excited_amplitude"],
    "symfric.theory.drive.grazing": ["two_slides_onset"],
    "symfric.theory.hopf": ["HopfPoint"],
    "symfric.theory.plane.disc": ["DiscStop", "disc_expressions"],
    "symfric.theory.scaling": ["isolator_model"],
    "symfric.theory.waviness": ["sinusoidal_onset_speed"],
}
ALONE = [(module, name) for module, names in COSTLY.items() for name in names]


@pytest.fixture
def failed(tmp_path, monkeypatch):
    """Return a function that runs some examples and returns what they print wrongly."""
    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    monkeypatch.chdir(tmp_path)  # some write files

    def run(tests):
        runner, report = doctest.DocTestRunner(verbose=False), []
        for test in tests:
            runner.run(test, out=report.append)
            plt.close("all")
        return "".join(report) if runner.failures else ""

    return run


@pytest.mark.one_in(3)
@pytest.mark.parametrize("module", EXAMPLES)
def test_examples_run_and_print_what_they_say(module, failed):
    found = list(examples(module))
    assert any(test.examples for test in found)
    assert failed(test for test in found if test.name not in COSTLY.get(module, ())) == ""


@pytest.mark.one_in(20)
@pytest.mark.parametrize(("module", "name"), ALONE)
def test_costly_examples_run_and_print_what_they_say(module, name, failed):
    found = [test for test in examples(module) if test.name == name]
    assert any(test.examples for test in found), f"{module} has no example of {name}"
    assert failed(found) == ""
