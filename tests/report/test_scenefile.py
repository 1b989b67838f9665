"""Scene files: what they mean, and that bad or hostile ones end in one clear line with nothing executed."""

import os
import time
import tracemalloc
from pathlib import Path

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import symfric as sf
from symfric.scenefile import SceneFile, belt_speeds, friction_laws, read_scene_file, read_scene_text, ready_scenes
from symfric.scenefile.expressions import FUNCTIONS, parse_expression

EXAMPLES = Path(__file__).parents[2] / "examples"

BELT = """
[scene]
model = "mass_on_belt"
horizon = 50
[values]
v_b = 0.2
"""

OWN = """
[scene]
coordinates = "x"
velocities = "u"
mass = "m"
force = "{force}"
initial = {{ x = 0.0, u = 0.0 }}
horizon = 10
[values]
m = 1.0
k = 2.0
v_b = 0.3
[friction]
name = "belt"
slip = "u - v_b"
normal = 1
law = "coulomb"
mu_s = 0.4
[outputs]
y = "{output}"
"""


def own(force="-k*x", output="max(k*x)"):
    return OWN.format(force=force, output=output)


def message_of(text: str) -> str:
    """The one line a bad file ends in."""
    with pytest.raises(sf.SceneError) as caught:
        read_scene_text(text, "bad.toml")
    line = str(caught.value)
    assert line.startswith("bad.toml: ")
    assert "\n" not in line
    assert len(line) <= 420
    return line


# --- what a good file means


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda p: p.stem)
def test_examples_are_read(path):
    found = read_scene_file(path)
    assert found.title
    assert found.description
    assert found.sweep is None or found.sweep.parameter in {s.name for s in found.scene.parameters}


def test_ready_model_is_the_librarys_scene():
    found = read_scene_file(EXAMPLES / "belt.toml")
    direct = sf.scenes.mass_on_belt(sf.laws.cubic(0.4, 0.25, 0.5), v_b=0.2, beta=0.05, gamma2=1.0)
    assert found.scene.system == direct.system
    assert found.scene.contacts == direct.contacts
    assert found.scene.values == direct.values
    assert found.laws[0].contact == "belt"


def test_own_equations_are_what_they_say():
    x, u, k, v_b, m = sp.symbols("x u k v_b m", real=True)
    scene = read_scene_text(own("-k*x + sin(2*t)/3", "integral(k*x*u)")).scene
    assert scene.system.force == (-k * x + sp.sin(2 * sf.TIME) / 3,)
    assert scene.system.mass == sp.ImmutableMatrix([[m]])
    assert scene.contacts == (sf.Contact("belt", slip=u - v_b, normal=sp.Integer(1), law=sf.laws.coulomb(0.4)),)
    assert scene.outputs == {"y": sf.Integral(k * x * u)}


def test_mass_may_be_the_diagonal_or_all_rows():
    diagonal = read_scene_file(EXAMPLES / "two_masses.toml")
    text = (EXAMPLES / "two_masses.toml").read_text().replace('["m1", "m2"]   ', '[["m1", 0], [0, "m2"]]')
    assert read_scene_text(text).scene.system == diagonal.scene.system


def test_contacts_may_be_written_as_an_array():
    text = own().replace("[friction]", "[[contact]]")
    assert read_scene_text(text).scene.contacts == read_scene_text(own()).scene.contacts


def test_law_coefficients_may_be_names():
    text = BELT + 'mu_0 = 0.5\n[friction]\nlaw = "coulomb"\nmu_s = "mu_0"\n'
    scene = read_scene_text(text).scene
    assert {s.name for s in scene.contacts[0].law.free_symbols} == {"mu_0"}
    assert scene.numbers()[sp.Symbol("mu_0", real=True)] == 0.5


def test_custom_law_in_terms_of_the_speed():
    text = BELT + '[friction]\nlaw = "custom"\nkinetic = "0.2 + 0.1*exp(-v/0.3)"\nmu_s = 0.3\n'
    assert read_scene_text(text).scene.contacts[0].law(0.0 + 0.3) == pytest.approx(0.2 + 0.1 / 2.718281828459045)


def test_piecewise_linear_law_takes_lists():
    text = BELT + '[friction]\nlaw = "piecewise_linear"\nmu_s = 0.4\nspeeds = [0, 0.5, 1]\nvalues = [0.4, 0.2, 0.3]\n'
    assert read_scene_text(text).scene.contacts[0].law(0.75) == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("text", "output"),
    [
        ("end", sf.End()),
        ("stop_time", sf.StopTime()),
        ("events()", sf.Events()),
        ("trajectory", sf.Trajectory()),
        ("min(x)", sf.Min(sp.Symbol("x", real=True))),
        ("half_range(x)", sf.HalfRange(sp.Symbol("x", real=True))),
        ("max(slip('belt'))", sf.Max(sf.slip("belt"))),
        ("integral(friction_force('belt'))", sf.Integral(sf.friction_force("belt"))),
    ],
)
def test_outputs(text, output):
    assert read_scene_text(own(output=text)).scene.outputs == {"y": output}


def test_new_scenes_and_laws_are_found_by_their_signatures():
    assert {"mass_on_belt", "coulomb_oscillator"} <= set(ready_scenes())
    assert {"coulomb", "cubic", "stribeck", "custom"} <= set(friction_laws())
    scene = read_scene_text('[scene]\nmodel = "coulomb_oscillator"\nx0 = 2.0\n[values]\ndelta = 0.1\n').scene
    assert scene.numbers()[scene.system.q[0]] == 2.0


SLIDES = '[scene]\nmodel = "two_slides"\n{}\n[values]\nr = 0.5\nzeta = 2\ns1 = 0.2\ns2 = 0.3\nfc1 = 1\nfs1 = 7.8\n'


def test_an_option_of_a_scene_may_be_a_word():
    for line, damping in (("", "omega1"), ('damping = "omega1"', "omega1"), ('damping = "omega2"', "omega2")):
        pair = {"r": 0.5, "zeta": 2, "s1": 0.2, "s2": 0.3, "fc1": 1, "fs1": 7.8}
        assert read_scene_text(SLIDES.format(line)).scene.system == sf.scenes.two_slides(**pair, damping=damping).system
    assert "'omega1' (d2 = s2) or 'omega2'" in message_of(SLIDES.format('damping = "omega"'))
    assert "scene.damping is 2.0, not text; write it in quotes" in message_of(SLIDES.format("damping = 2"))


def test_belt_speeds_are_what_drives_a_slip():
    assert [s.name for s in belt_speeds(read_scene_file(EXAMPLES / "two_masses.toml").scene)] == ["v_b"]
    assert belt_speeds(sf.scenes.coulomb_oscillator(0.1)) == ()


def test_sweep_over_the_belt_speed_is_the_default():
    assert read_scene_text(BELT + "[sweep]\nfrom = 0.1\nto = 0.3\n").sweep.parameter == "v_b"


# --- expressions

x, y = sp.symbols("x y", real=True)
NAMES = {"x": x, "y": y, "t": sf.TIME}


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("x + 2*y - 3", x + 2 * y - 3),
        ("-x**2", -(x**2)),
        ("x**-1", 1 / x),
        ("x/y/2", x / y / 2),
        ("1/3*x", x / 3),
        ("x**2.0", x**2),
        ("x**0.5", sp.sqrt(x)),
        ("2 - 3 - 4 + x", x - 5),
        ("atan(x)*pi", sp.atan(x) * sp.pi),
        ("max(x, y, 0)", sp.Max(x, y, 0)),
        ("piecewise((x, x < 1), (y, x >= 2), 0)", sp.Piecewise((x, x < 1), (y, x >= 2), (0, True))),
        ("piecewise((x, 0 < x < 1 and y > 2), 0)", sp.Piecewise((x, (x > 0) & (x < 1) & (y > 2)), (0, True))),
        ("sin(2*t)\n  + 1", sp.sin(2 * sf.TIME) + 1),
    ],
)
def test_expression_means_what_it_says(text, meaning):
    assert sp.simplify(parse_expression(text, NAMES, "here") - meaning) == 0


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_functions_agree_with_their_values_on_numbers(name):
    symbolic, numeric = FUNCTIONS[name]
    assert float(parse_expression(f"{name}(0.4)", {}, "here")) == pytest.approx(numeric(0.4), rel=1e-14)
    assert symbolic(sp.Float(0.4)) == pytest.approx(numeric(0.4), rel=1e-14)


def test_a_long_sum_is_no_deep_one():
    assert parse_expression("+".join(["x"] * 400), NAMES, "here") == 400 * x


BAD_EXPRESSIONS = [
    ("__import__('os').system('touch canary')", "known functions"),
    ("().__class__.__bases__[0].__subclasses__()", "known functions"),
    ("x.__class__", "dot"),
    ("x[0]", "square brackets"),
    ("(lambda: 1)()", "known functions"),
    ("lambda: 1", "lambda"),
    ("[x for x in (1, 2)]", "comprehension"),
    ("sum(i for i in (1, 2))", "unknown function"),
    ("f'{x}'", "string"),
    ("(y := 3)", "assignment"),
    ("x = 3", "'='"),
    ("open('canary', 'w')", "unknown function open"),
    ("exec('1')", "unknown function exec"),
    ("x if x < 1 else y", "piecewise"),
    ("x < 1", "piecewise"),
    ("not x", "not allowed"),
    ("x and y", "not allowed"),
    ("'x'", "string"),
    ("b'x'", "string"),
    ("True", "not a real number"),
    ("None", "not a real number"),
    ("...", "not a real number"),
    ("3j", "not a real number"),
    ("*x", "cannot read"),
    ("x, y", "comma"),
    ("{x}", "not allowed"),
    ("x^2", "write **"),
    ("x % 2", "not allowed"),
    ("x // 2", "not allowed"),
    ("x @ y", "not allowed"),
    ("2x", "write * between"),
    ("2(x)", "known functions"),
    ("x +", "cannot read"),
    ("sin x", "cannot read"),
    ("sin", "write sin(...)"),
    ("sin(x, y)", "one argument"),
    ("sin(a=x)", "plain arguments"),
    ("sin(*x)", "plain arguments"),
    ("max(x)", "at least two"),
    ("sinus(x)", "did you mean sin?"),
    ("xx", "did you mean x?"),
    ("9**9**9", "exponent"),
    ("9**9**9**9**9", "exponent"),
    ("((9**60)**60)**60", "larger"),
    ("10**400", "exponent"),
    ("1e999", "larger"),
    ("1e200*1e200", "larger"),
    ("9" * 5000, ""),
    ("exp(exp(exp(9)))", "larger"),
    ("cosh(800)", "larger"),
    ("1/0", "division by zero"),
    ("x/(1 - 1)", "division by zero"),
    ("x/(y - y)", "division by zero"),
    ("log(0)", "no real value"),
    ("sqrt(-2)", "no real value"),
    ("asin(2)", "no real value"),
    ("(-8)**0.3", "not real"),
    ("0**-1", "division by zero"),
    ("slip('belt')", "[outputs] only"),
    ("piecewise(x)", "piecewise((a, x < 1), b)"),
    ("piecewise((x, y), 1)", "comparison"),
    ("piecewise((x, x == 1), 1)", "comparison"),
    ("piecewise((x, x < 1))", "last value"),
    ("piecewise((x, tanh(x) < 1), 1)", "tanh is not allowed in a comparison"),
    ("piecewise((x, x**3.7 < 1), 1)", "exponents 1 to 4"),
    ("x**64", "larger than 16"),
    ("max(acos(max(x, 0) + 3), 1)", "real"),
    ("tan(sinh(sinh(piecewise((2, 1 >= 3), 64))))", "larger"),
    ("piecewise(x, x < 1, y)", "pairs"),
    ("", "empty"),
    ("  \n ", "empty"),
    ("x\0y", "cannot read"),
    ("(" * 1000 + "x" + ")" * 1000, "nested brackets"),
    ("(" * 51 + "x" + ")" * 51, "nested brackets"),
    ("-" * 9000 + "x", "nested"),
    ("x" + "**x" * 3000, "nested"),
    ("x" + "*x" * 4000, "nested"),
    ("x" + ".a" * 4000, "nested"),
    ("+".join(["x"] * 20_000), "at most 10000"),
    ("+".join(["abs(x)"] * 40), "split"),
    ("max(" + ",".join(f"x+{i}" for i in range(40)) + ")", "split"),
]


@pytest.mark.one_in(6)
@pytest.mark.parametrize(("text", "part"), BAD_EXPRESSIONS, ids=lambda v: v[:30] if isinstance(v, str) else v)
def test_bad_expression_is_refused_quickly(text, part, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    start = time.process_time()
    with pytest.raises(sf.SceneError) as caught:
        parse_expression(text, NAMES, "scene.force[0]")
    line = str(caught.value)
    assert line.startswith("scene.force[0]: ")
    assert part in line
    assert "\n" not in line
    assert time.process_time() - start < 2.0  # CPU time; the point is that it ends
    assert not os.listdir(tmp_path)


HOSTILE = ["__import__('os').system('touch canary')", "open('canary','w')", "x.__class__.__init__", "exec('1')"]


@pytest.mark.parametrize("hostile", HOSTILE)
@pytest.mark.parametrize("place", ["force", "output", "slip", "normal", "mu_s", "initial", "mass"])
def test_hostile_text_is_executed_nowhere(hostile, place, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = {
        "force": own(force=hostile),
        "output": own(output=f"max({hostile})"),
        "slip": own().replace("u - v_b", hostile),
        "normal": own().replace("normal = 1", f'normal = "{hostile}"'),
        "mu_s": own().replace("mu_s = 0.4", f'mu_s = "{hostile}"'),
        "initial": own().replace("x = 0.0", f'x = "{hostile}"'),
        "mass": own().replace('"m"', f'"{hostile}"'),
    }[place]
    assert place.replace("output", "outputs") in message_of(text)
    assert not os.listdir(tmp_path)


# --- bad files

BAD_FILES = [
    ("", "is empty"),
    ("   \n\n", "is empty"),
    ("[scene", "end of document"),
    ('[scene]\nmodel = "mass_on_belt\n', "line 2, column"),
    ("[scene]\nmodel = mass_on_belt\n", "quotes"),
    ("a = " + "[" * 1000 + "]" * 1000, "nested"),
    ("a = " + "{a=" * 1000 + "1" + "}" * 1000, "nested"),
    (".".join("a" * 9000) + " = 1", "parts"),
    ("a = " + "9" * 5000, "not TOML"),
    (BELT.replace("v_b = 0.2", "v_b = {" + ".".join("a" * 400_000) + " = 1}"), "parts (at line 6)"),
    (BELT + "[sweep]\nnumber = {" + " . ".join(["'a'"] * 100_000) + " = 1}", "parts (at line 8)"),
    (BELT + "[sweep]\nfrom = 0\nto = 1\nnumber = {a = {a = {a = 1}}}", "sweep.number"),
    (BELT + "\n".join(f"k{i} = 1" for i in range(5000)), "at most 200"),
    ("title = 'x'\n", "no [scene]"),
    ("[scenes]\nmodel = 'mass_on_belt'\n", "did you mean scene?"),
    ("scene = 3\n", "write a section [scene]"),
    ("[[scene]]\nmodel = 'mass_on_belt'\n", "write a section [scene]"),
    (BELT.replace("mass_on_belt", "mas_on_belt"), "did you mean mass_on_belt?"),
    (BELT.replace('"mass_on_belt"', "3"), "scene.model is a number, not text"),
    (BELT.replace("v_b = 0.2", ""), "[values] needs v_b"),
    (BELT.replace("v_b = 0.2", 'v_b = "0.2"'), "values.v_b is the string '0.2', not a number"),
    (BELT.replace("v_b = 0.2", 'v_b = "0.2 m/s"'), "without quotes or unit"),
    (BELT.replace("v_b = 0.2", "v_b = true"), "values.v_b is true or false, not a number"),
    (BELT.replace("v_b = 0.2", "v_b = [0.2]"), "values.v_b is a list"),
    (BELT.replace("v_b = 0.2", "v_b = 2020-01-01"), "values.v_b is a date"),
    (BELT.replace("v_b = 0.2", "v_b = nan"), "must be finite"),
    (BELT.replace("v_b = 0.2", "v_b = -inf"), "must be finite"),
    (BELT.replace("v_b = 0.2", "v_b = 1" + "0" * 400), "must be finite"),
    (BELT + "v_c = 1\n", "values.v_c: mass_on_belt has no argument v_c; did you mean v_b?"),
    (BELT.replace("horizon = 50", "horizn = 50"), "did you mean horizon?"),
    (BELT.replace("horizon = 50", 'horizon = "50"'), "scene.horizon is '50', not a number"),
    (BELT.replace("horizon = 50", "horizon = -50"), "must be positive"),
    (BELT.replace("horizon = 50", 'force = "x"'), "remove force"),
    (BELT.replace("horizon = 50", "v_b = 0.1"), "keep one"),
    (BELT.replace("horizon = 50", 'law = "cubic"'), "own section"),
    (BELT.replace("horizon = 50", "initial = {y = 1.0}"), "y in scene.initial is no state"),
    (BELT + "[frictoin]\nlaw = 'cubic'\n", "did you mean friction?"),
    (BELT + "[friction]\nmu_s = 0.4\n", "friction.law is missing"),
    (BELT + "[friction]\nlaw = 'qubic'\n", "did you mean cubic?"),
    (BELT + "[friction]\nlaw = 'coulomb'\n", "needs mu_s"),
    (BELT + "[friction]\nlaw = 'coulomb'\nmu_d = 0.4\n", "no argument 'mu_d'; did you mean mu_s?"),
    (BELT + "[friction]\nlaw = 'coulomb'\nmu_s = '0.4'\n", "without quotes"),
    (BELT + "[friction]\nlaw = 'coulomb'\nmu_s = [1, 2]\n", "friction"),
    (BELT + "[friction]\nlaw = 'coulomb'\nmu_s = {a = 1}\n", "friction.mu_s is a table"),
    (BELT + "[friction]\nlaw = 'coulomb'\nmu_s = -0.4\n", "must not be negative"),
    (BELT + "[friction]\nlaw = 'coulomb'\nmu_s = 0.4\nslip = 'u'\n", "remove slip"),
    (BELT + "[friction]\nlaw = 'coulomb'\nmu_s = 0.4\n[[contact]]\nlaw = 'coulomb'\n", "keep one"),
    (BELT + "[outputs]\ny = 'maximum(x)'\n", "did you mean"),
    (BELT + "[outputs]\ny = 'max'\n", "max needs an expression"),
    (BELT + "[outputs]\ny = 'max(w)'\n", "outputs.y: unknown name w"),
    (BELT + "[outputs]\ny = 3\n", "outputs.y is a number, not text"),
    (BELT + "[outputs]\ny = 'max(slip(\"belts\"))'\n", "did you mean belt?"),
    (BELT + "[sweep]\nfrom = 0.1\n", "sweep.to is missing"),
    (BELT + "[sweep]\nfrom = 0.1\nto = 0.05\n", "must be smaller"),
    (BELT + "[sweep]\nfrm = 0.1\nto = 0.05\n", "sweep"),
    (BELT + "[sweep]\nfrom = 0.1\nto = 0.5\nnumbr = 3\n", "[sweep] has no key 'numbr'; did you mean number?"),
    (BELT + "[sweep]\nfrom = 0.1\nto = 0.5\nnumber = 1e9\n", "sweep.number"),
    (BELT + "[sweep]\nfrom = 0.1\nto = 0.5\nnumber = 1\n", "sweep.number"),
    (BELT + "[sweep]\nfrom = 0.1\nto = 0.5\nparameter = 'vb'\n", "did you mean v_b?"),
    (BELT + "[sweep]\nfrom = 0.1\nto = 0.5\ncoordinate = 'y'\n", "no state 'y'"),
    (BELT + "[sweep]\nparameter = 'gamma2'\nfrom = -0.1\nto = 0.5\n", "sweep.from: with gamma2 = -0.1"),
    (BELT + "[design]\nspeeds = [0.1, 0.2]\n", "[design] has no key 'speeds'"),
    (BELT + "[design.quench]\nspeeds = [0.1, 0.2]\na = [0, 1]\n", "design.quench.Omega is missing"),
    (BELT + "[design.quench]\nspeeds = 0.1\na = [0, 1]\nOmega = [1, 2]\n", "design.quench.speeds"),
    (BELT + "[design.quench]\nspeeds = [0.3, 0.1]\na = [0, 1]\nOmega = [1, 2]\n", "smallest, largest"),
    (BELT + "[design.quench]\nspeeds = [0.1, 0.2]\na=[0, 1]\nOmega=[1, 2]\nminimise='cost'\n", "minimise is 'cost'"),
    (BELT + "[units]\nw = 'm'\n", "no such state or value"),
    (BELT + '"a\\nb" = 1\n', "is not a name"),
    (own(force="-k*y"), "scene.force[0]: unknown name y"),
    (own(force="-2*x", output="end"), "value k is used by no expression"),
    (own(force="-k*x + exp(exp(1e9*k))"), "no finite real value at the start"),
    (own(force="-k*x + sqrt(x - 1)"), "no finite real value at the start"),
    (own(force="-k*x + 1/x"), "no finite real value at the start"),
    (own().replace("x = 0.0", 'x = "log(-k)"'), "no finite real value at the start"),
    (own().replace("mu_s = 0.4", 'mu_s = "exp(exp(1e5*k))"'), "no finite real value at the start"),
    (own().replace('"m"', '["m", "m"]'), "shape (2, 2)"),
    (own().replace('"m"', '[["m", 0], [1]]'), "rows differ"),
    (own().replace('"m"', '[["m"], 0]'), "mixes rows"),
    (own().replace('"m"', "-1").replace("m = 1.0", ""), "positive definite"),
    (own().replace('"u"', '["u", "w"]'), "1 coordinates in q and 2 velocities"),
    (own().replace('coordinates = "x"', 'coordinates = "x y"'), "is not a name"),
    (own().replace('coordinates = "x"', 'coordinates = "lambda"'), "Python reserves"),
    (own().replace('coordinates = "x"', 'coordinates = "t"'), "taken (time)"),
    (own().replace('coordinates = "x"', "coordinates = 3"), "scene.coordinates[0] is a number, not text"),
    (own().replace('slip = "u - v_b"', ""), "friction.slip is missing"),
    (own().replace("u - v_b", "u**2 - v_b"), "not linear"),
    (own().replace("normal = 1", "normal = -1"), "not negative"),
    (own().replace("x = 0.0, ", ""), "no initial value for x"),
    (own().replace("horizon = 10", ""), "scene.horizon is missing"),
    (own().replace("horizon", "horizont"), "scene"),
]


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("text", "part"), BAD_FILES, ids=[f"{i}-{p[1][:24]}" for i, p in enumerate(BAD_FILES)])
def test_bad_file_ends_in_one_clear_line(text, part, monkeypatch):
    monkeypatch.setattr("symfric.codegen.functions._made", None)  # before anything is compiled
    assert part in message_of(text)


def failing(path) -> str:
    with pytest.raises(sf.SceneError) as caught:
        read_scene_file(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_files_that_are_no_scene_files(tmp_path):
    (tmp_path / "belt.toml").write_text(BELT)
    (tmp_path / "binary.toml").write_bytes(bytes(range(256)))
    (tmp_path / "latin.toml").write_bytes(b"[scene]\n# gr\xfc\xdfe\n")
    (tmp_path / "zeros.toml").write_bytes(b"\0" * 100)
    (tmp_path / "empty.toml").touch()
    assert "folder" in failing(tmp_path)
    assert "did you mean belt.toml?" in failing(tmp_path / "bell.toml")
    assert "no such file" in failing(tmp_path / "nowhere" / "belt.toml")
    assert "not text" in failing(tmp_path / "binary.toml")
    assert "0xfc in line 2" in failing(tmp_path / "latin.toml")
    assert "line 1, column 1" in failing(tmp_path / "zeros.toml")
    assert "is empty" in failing(tmp_path / "empty.toml")
    assert "\0" not in failing("a\0b.toml")
    if os.path.exists("/dev/zero"):
        assert "not a regular file" in failing("/dev/zero")


def test_a_large_file_is_not_read_whole(tmp_path):
    path = tmp_path / "large.toml"
    with path.open("wb") as stream:
        stream.truncate(50_000_000)
    tracemalloc.start()
    assert "larger than 1000 kB" in failing(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 5_000_000


def test_windows_line_ends_and_byte_order_mark_are_fine(tmp_path):
    path = tmp_path / "belt.toml"
    path.write_bytes(b"\xef\xbb\xbf" + BELT.replace("\n", "\r\n").encode())
    assert read_scene_file(path).scene.horizon == 50


# --- anything at all

WORDS = st.one_of(
    st.sampled_from(
        ["x", "y", "t", "v", "pi", "1", "2.5", "1e9", "9**9", "'belt'", '"', "f'{x}'", "#", "\\", "\n", ";"]
    ),
    st.sampled_from(["sin(", "max(", "piecewise(", "slip(", "(", ")", "[", "]", "{", "}", ",", ".", "__class__"]),
    st.sampled_from(["+", "-", "*", "/", "**", "<", " and ", " or ", " not ", "lambda:", ":=", "="]),
    st.sampled_from(["__import__('os').system('touch canary')", "open('canary','w')"]),
)
LINES = st.one_of(
    st.sampled_from([*BELT.strip().splitlines(), *own().strip().splitlines()]),
    st.sampled_from(["[sweep]", "[design.quench]", "[units]", "[[contact]]", "from = 0", "to = 1", "x = [[]]"]),
    st.sampled_from(["a.b.c = 1", "v_b = '''", "mu_s = nan", "profile = 'abs(x)'", 'title = ""']),
)


def or_refusal(read, *arguments):
    """What `read` returns, or the message of its SceneError; any other exception passes."""
    try:
        return read(*arguments)
    except sf.SceneError as error:
        return str(error)


@pytest.fixture(scope="module")
def empty_folder(tmp_path_factory):
    folder, before = tmp_path_factory.mktemp("canary"), Path.cwd()
    os.chdir(folder)
    yield folder
    os.chdir(before)


@pytest.mark.long(beside="test_any_file_is_read_or_refused")
@settings(max_examples=100, deadline=None)
@given(st.one_of(st.text(max_size=200), st.lists(WORDS, max_size=30).map("".join)))
def test_any_expression_is_read_or_refused(empty_folder, text):
    result = or_refusal(parse_expression, text, NAMES, "here", ["belt"])
    assert isinstance(result, sp.Expr) or (result.startswith("here: ") and "\n" not in result)
    assert not os.listdir(empty_folder)


@settings(max_examples=100, deadline=None)
@given(st.one_of(st.text(max_size=300), st.lists(LINES, max_size=25).map("\n".join)))
def test_any_file_is_read_or_refused(empty_folder, text):
    result = or_refusal(read_scene_text, text)
    assert isinstance(result, SceneFile) or "\n" not in result
    assert not os.listdir(empty_folder)


@settings(max_examples=60, deadline=None)
@given(st.binary(max_size=300))
def test_any_bytes_are_read_or_refused(empty_folder, tmp_path_factory, data):
    path = tmp_path_factory.mktemp("bytes") / "any.toml"
    path.write_bytes(data)
    with pytest.raises(sf.SceneError):
        read_scene_file(path)


@settings(max_examples=80, deadline=None)
@given(st.integers(0, len(own()) - 1), st.characters(codec="utf-8"))
def test_one_changed_character_never_ends_in_another_error(position, character):
    text = own()
    result = or_refusal(read_scene_text, text[:position] + character + text[position + 1 :])
    assert isinstance(result, SceneFile) or "\n" not in result
