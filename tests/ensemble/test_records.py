"""Records: every file and every variant is read, and what is no record of accelerations is refused by name."""

import random
import re
from pathlib import Path

import numpy as np
import pytest

import symfric as sf
from symfric.motions.fortran_numbers import parse_numbers

FOLDER = next(
    (p / "shared" / "ground_motions" for p in Path(__file__).resolve().parents if (p / "shared").is_dir()), None
)
TITLE = "PEER NGA STRONG MOTION DATABASE RECORD\nSomewhere, 1/2/1990, Town Hall, 0\n"
HEAD = TITLE + "ACCELERATION TIME SERIES IN UNITS OF G\n"
BODY = "  -.6403182E-02  -.6028715E-02   .5304162E-03   .7743260E-02   .6890377E-02\n   .6876502E-02   .6705057E-02\n"
VALUES = [-0.6403182e-2, -0.6028715e-2, 0.5304162e-3, 0.774326e-2, 0.6890377e-2, 0.6876502e-2, 0.6705057e-2]


def listed():
    """Rows of the table of sources: file, npts, dt, PGA in g and its index."""
    if FOLDER is None or not FOLDER.is_dir():
        return []
    rows = (re.split(r"\s*\|\s*", line) for line in (FOLDER / "SOURCES.md").read_text().splitlines())
    return [
        (r[1], int(r[5]), float(r[7]), float(r[8]), int(r[9])) for r in rows if r[1:] and r[1].lower().endswith("at2")
    ]


@pytest.mark.skipif(not listed(), reason="the folder shared/ground_motions is not beside this clone")
def test_every_listed_file_is_read():
    assert len(listed()) == 20
    for file, npts, dt, pga, index in listed():
        motion = sf.motions.read_at2(FOLDER / file)
        assert motion.samples.shape == (npts,)
        assert motion.dt == dt
        assert motion.pga_g == pytest.approx(pga, rel=4e-6)
        assert int(np.argmax(np.abs(motion.samples))) == index
        assert (motion.unit, motion.name) == ("m/s^2", Path(file).stem)
        assert abs(motion.final_velocity) < 5e-4


@pytest.mark.skipif(not listed(), reason="the folder shared/ground_motions is not beside this clone")
def test_line_ends_do_not_change_a_record():
    one, other = (sf.motions.read_at2(FOLDER / f"Northridge1994_ARL360{e}.at2") for e in ("", "_CRCRLF"))
    np.testing.assert_array_equal(one.samples, other.samples)


def write(folder, text, name="a.AT2"):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode("latin-1"))
    return path


@pytest.mark.parametrize(
    "line",
    [
        "NPTS=  7, DT= .01000 SEC",
        "NPTS=   7, DT=   .0100 SEC,",
        "NPTS=  7, dt=  .01000",
        "npts = 7 dt = 1.0E-2 sec",
        "7    0.0100    NPTS, DT",
        "   7   .0100   NPTS, DT",
        "NPTS=      7, DT=   0.010 SEC                                              ",
    ],
)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r\r\n", "\r"], ids=["LF", "CRLF", "CRCRLF", "CR"])
def test_variants_of_the_header(line, end, tmp_path):
    text = (HEAD + line + "\n" + BODY).replace("\n", end)
    motion = sf.motions.read_at2(write(tmp_path, text))
    np.testing.assert_allclose(motion.samples, np.array(VALUES) * 9.81, rtol=1e-15)
    assert motion.dt == 0.01
    assert motion.note == "Somewhere, 1/2/1990, Town Hall, 0"


@pytest.mark.parametrize(
    "title", ["PEER STRONG MOTION DATABASE", "PACIFIC ENGINEERING AND ANALYSIS", "Wörter in Latin-1"]
)
def test_titles_and_more_lines(title, tmp_path):
    text = f"{title}\nline\nFormat 8F10.5, 7 points of 0.02 sec\nThe units are (g)\n*** Begin ***\n\nNPTS= 7, DT= .02\n{BODY}"
    assert sf.motions.read_at2(write(tmp_path, text)).dt == 0.02
    ended = sf.motions.read_at2(write(tmp_path, text + "*** End Data ***\n"))
    assert ended.samples.size == 7


@pytest.mark.parametrize(
    ("body", "values"),
    [
        ("  -0.00128-0.00368   0.00864\n", [-0.00128, -0.00368, 0.00864]),
        ("   0.12345-123.4567812345.12345\n", None),
        ("   0.00630   0.00364\n1234.567891234.56789\n", [0.0063, 0.00364, 1234.56789, 1234.56789]),
        (
            "  .1234567E-02  .1234567E-02\n.7654321E-01.1234567E+01-.5E0\n",
            [0.001234567, 0.001234567, 0.07654321, 1.234567],
        ),
        ("  1.D-3 2d-3\n", [1e-3, 2e-3]),
        ("  1,2, 3\n", [1, 2, 3]),
        ("  .1E-02 -.2E-02\n", [0.001, -0.002]),
    ],
)
def test_fields_that_touch(body, values, tmp_path):
    count = len(values) if values else 3
    path = write(tmp_path, HEAD + f"NPTS= {count}, DT= .01 SEC\n" + body)
    if values is None or "-.5E0" in body:
        with pytest.raises(sf.SceneError, match=r"a.AT2, line [56]: "):
            sf.motions.read_at2(path)
    else:
        np.testing.assert_allclose(sf.motions.read_at2(path).samples, 9.81 * np.array(values), rtol=1e-15)


@pytest.mark.parametrize(
    ("unit", "factor"),
    [("CM/SEC/SEC", 0.01), ("cm/s2", 0.01), ("GAL", 0.01), ("M/S**2", 1.0), ("(g)", 9.81), ("IN/SEC2", 0.0254)],
)
def test_units_of_the_header(unit, factor, tmp_path):
    text = TITLE + f"ACCELERATION TIME SERIES IN UNITS OF {unit}\nNPTS= 7, DT= .01 SEC\n" + BODY
    np.testing.assert_allclose(
        sf.motions.read_at2(write(tmp_path, text)).samples, factor * np.array(VALUES), rtol=1e-15
    )


@pytest.mark.parametrize(
    ("words", "factor"),
    [
        ("Acceleration in g", 9.81),
        ("ACCELERATION IN G, rotated by 30 degrees", 9.81),
        ("Acceleration (cm/s^2)", 0.01),
        ("acceleration [m/s2]", 1.0),
        ("Acceleration, g", 9.81),
        ("Accel. in cm/sec/sec.", 0.01),
    ],
)
def test_units_beside_the_quantity(words, factor, tmp_path):
    text = TITLE + f"{words}\nNPTS= 7, DT= .01 SEC\n" + BODY
    plain = sf.motions.read_at2(write(tmp_path, HEAD + "NPTS= 7, DT= .01 SEC\n" + BODY))
    assert sf.motions.read_at2(write(tmp_path, text)).pga == pytest.approx(plain.pga * factor / 9.81)


@pytest.mark.parametrize("words", ["Acceleration in the direction of north", "Acceleration in m of nothing", "Rotated"])
def test_words_that_are_no_unit_of_acceleration(words, tmp_path):
    with pytest.raises(sf.SceneError, match="names no unit"):
        sf.motions.read_at2(write(tmp_path, TITLE + f"{words}\nNPTS= 7, DT= .01 SEC\n" + BODY))


def test_unit_and_step_from_the_caller(tmp_path):
    bare = write(tmp_path, TITLE + "7 .00244 NPTS, DT\n" + BODY)
    assert sf.motions.read_at2(bare, unit="g", dt=1 / 409.6).dt == 1 / 409.6
    assert sf.motions.read_at2(bare, unit="g", dt=1 / 410).dt == 1 / 410
    for arguments, message in (({}, "names no unit"), ({"unit": "g", "dt": 0.0025}, "does not round")):
        with pytest.raises(sf.SceneError, match=message):
            sf.motions.read_at2(bare, **arguments)
    with pytest.raises(sf.SceneError, match="line 3: the unit is G, and unit='gal'"):
        sf.motions.read_at2(write(tmp_path, HEAD + "NPTS= 7, DT= .01\n" + BODY), unit="gal")


LINE = "NPTS= 7, DT= .01 SEC\n"
REFUSED = {
    "truncated": (HEAD + LINE + BODY[:60], "line 5: ends after .* NPTS = 7; it is truncated: get the file anew"),
    "too many": (HEAD + LINE + BODY + " .1 .2\n", "line 7: ends after 9 numbers"),
    "cut in a number": (HEAD + LINE + BODY[:-12], "ends after 6 numbers|is no row"),
    "no header line": (HEAD + BODY, "no line with NPTS and DT .* read_text"),
    "NPTS alone": (HEAD + "NPTS= 7\n" + BODY, "line 4: NPTS and DT cannot be read"),
    "NPTS is one": (HEAD + "NPTS= 1, DT= .01\n .1\n", "line 4: NPTS is 1"),
    "DT is zero": (HEAD + "NPTS= 7, DT= .000\n" + BODY, "line 4: DT is .000"),
    "DT is negative": (HEAD + "NPTS= 7, DT= -.01\n" + BODY, "line 4: DT is -.01"),
    "DT is NaN": (HEAD + "NPTS= 7, DT= NaN\n" + BODY, "line 4: DT is NaN"),
    "NaN": (HEAD + LINE + BODY.replace(".5304162E-03", "NaN"), "line 5: holds 'NaN', not a finite number"),
    "infinity": (HEAD + LINE + BODY.replace(".5304162E-03", "-Infinity"), "line 5: holds '-Infinity'"),
    "overflow": (HEAD + LINE + BODY.replace("E-03", "E+999"), "line 5: .* too large"),
    "asterisks": (HEAD + LINE + BODY.replace(".5304162E-03", "************"), "line 5: .* did not fit"),
    "words": (HEAD + LINE + BODY + "see below\n", "line 7, column 1: is no row of numbers"),
    "velocity": (TITLE + "VELOCITY TIME SERIES IN UNITS OF CM/S\n" + LINE + BODY, "line 3: a velocity"),
    "cm/s": (TITLE + "TIME SERIES IN UNITS OF CM/S\n" + LINE + BODY, "line 3: the unit is CM/S, a velocity"),
    "cm/sec": (TITLE + "ACCELERATION, UNITS: cm/sec\n" + LINE + BODY, "line 3: the unit is cm/sec, a velocity"),
    "displacement": (TITLE + "DISPLACEMENT TIME HISTORY IN UNITS OF CM\n" + LINE + BODY, "line 3: a displacement"),
    "old length": (TITLE + "UNITS OF FURLONG\n" + LINE + BODY, "line 3: the unit is FURLONG, a displacement"),
    "unknown unit": (TITLE + "UNITS OF NOTHING\n" + LINE + BODY, "line 3: the unit is no unit of acceleration known"),
    "empty": (" \n\n", "is empty"),
    "binary": (bytes(range(256)), "line 1: is binary"),
    "compressed": (b"\x1f\x8b\x08\x00" + bytes(range(255)), "is binary"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_record_is_refused_by_name(case, tmp_path):
    content, message = REFUSED[case]
    path = write(tmp_path, content)
    with pytest.raises(sf.SceneError, match=message) as caught:
        sf.motions.read_at2(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("read", [sf.motions.read_at2, lambda p: sf.motions.read_text(p, dt=0.1, unit="g")])
def test_paths_that_are_no_files(read, tmp_path, monkeypatch):
    path = write(tmp_path, HEAD + LINE + BODY, "record.AT2")
    for where, message in (
        (tmp_path, "is a folder"),
        (tmp_path / "recrd.AT2", "did you mean record.AT2"),
        ("a\0b", "cannot be read|no such file"),
    ):
        with pytest.raises(sf.SceneError, match=message):
            read(where)
    monkeypatch.setattr("symfric.motions.record_files.MAX_BYTES", 100)
    with pytest.raises(sf.SceneError, match="is larger than"):
        read(path)


# --- plain columns


def test_one_column(tmp_path):
    path = write(tmp_path, "# a comment\nacceleration (g)\n\n 0.1\n-.2E0\n3d-1\n", "a.txt")
    motion = sf.motions.read_text(path, dt=0.02, unit="g")
    np.testing.assert_allclose(motion.samples, 9.81 * np.array([0.1, -0.2, 0.3]), rtol=1e-15)
    assert (motion.dt, motion.name) == (0.02, "a")


@pytest.mark.parametrize("between", [" ", "\t", ",", ";", " , "])
def test_two_columns(between, tmp_path):
    rows = "\r\n".join(f"{5 + 0.005 * k:.3f}{between}{(-1) ** k * k}" for k in range(9))
    motion = sf.motions.read_text(write(tmp_path, "t,acc\r\n" + rows, "a.csv"), unit="cm/s^2")
    assert motion.dt == pytest.approx(0.005, rel=1e-12)
    np.testing.assert_allclose(motion.samples, [0.01 * (-1) ** k * k for k in range(9)], rtol=1e-15)


@pytest.mark.parametrize("between", [" ", "\t", ",", ";"])
@pytest.mark.parametrize("head", ["", "t{0}east{0}north\n", "# t{0}east{0}north\n", "A quake\n%t{0}east{0}north\n"])
def test_one_column_of_several(head, between, tmp_path):
    rows = "".join(f"{0.01 * k:.2f}{between}{k % 5}{between}{-k % 7}\n" for k in range(30))
    path = write(tmp_path, head.format(between) + rows, "a.csv")
    both = np.array([[k % 5, -k % 7] for k in range(30)]).T
    for place, name in enumerate(("east", "north")):
        for column in (place + 2, name) if head else (place + 2,):
            motion = sf.motions.read_text(path, unit="m/s^2", column=column)
            assert motion.dt == pytest.approx(0.01)
            np.testing.assert_array_equal(motion.samples, both[place])
    first = sf.motions.read_text(path, unit="m/s^2", column=1, dt=0.5)  # no times are looked for
    assert (first.dt, first.samples[-1]) == (0.5, 0.29)


def test_rounded_times_take_the_given_step(tmp_path):
    rows = "\n".join(f"{k / 409.6:.4f} {k}" for k in range(50))
    path = write(tmp_path, rows)
    assert sf.motions.read_text(path, unit="gal", dt=1 / 409.6).dt == 1 / 409.6
    with pytest.raises(sf.SceneError, match="drop dt"):
        sf.motions.read_text(path, unit="gal", dt=1 / 300)


@pytest.mark.parametrize(
    ("text", "arguments", "message"),
    [
        ("1\n2\n", {"dt": 0.1}, "no unit"),
        ("1\n2\n", {"unit": "g"}, "no dt"),
        ("1\n2\n", {"dt": 0.1, "unit": "cm/s"}, "unit is cm/s, a velocity"),
        ("1\n2\n", {"dt": 0.1, "unit": "m"}, "a displacement"),
        ("1\n2\n", {"dt": -0.1, "unit": "g"}, "must be positive"),
        ("velocity (cm/s)\n1\n2\n", {"dt": 0.1, "unit": "g"}, "line 1: says 'velocity'"),
        ("# v [cm/s]\n1\n2\n", {"dt": 0.1, "unit": "g"}, "line 1: says"),
        ("0 1\n.1 2\n.3 3\n.4 1\n", {"unit": "g"}, "line 3: the time steps from 0.1 to 0.2"),
        ("0 1\n.1 2\n.05 3\n", {"unit": "g"}, "line 3: the time does not increase"),
        ("0 1 2\n.1 2 3\n", {"unit": "g"}, "line 1: 3 columns; .*column=2"),
        ("0 1 2\n.1 2 3\n", {"unit": "g", "column": 4}, "column is 4; it has 3"),
        ("0 1 2\n.1 2 3\n", {"unit": "g", "column": 1.5}, "column is 1.5; it has 3"),
        ("0 1 2\n.1 2 3\n", {"unit": "g", "column": 1}, "the first, which has the times"),
        ("0 1 2\n.1 2 3\n", {"unit": "g", "column": "x"}, "no column 'x'; its first line has no names"),
        ("t,x,y\n0 1 2\n.1 2 3\n", {"unit": "g", "column": "z"}, "no column 'z'; known: t, x, y"),
        ("t,x,y\n0 1 2\n.1 2\n", {"unit": "g", "column": "x"}, "line 3: 2 columns, and 3 before"),
        ("0 1\n.1 2\n.2\n", {"unit": "g"}, "line 3: 1 columns, and 2 before; .* truncated"),
        ("0 1\n.1 nan\n", {"unit": "g"}, "line 2: holds 'nan'"),
        ("nan\n1\n", {"unit": "g", "dt": 1}, "line 1: holds 'nan'"),
        ("1\n****\n", {"unit": "g", "dt": 1}, "line 2: holds"),
        ("1\nend\n", {"unit": "g", "dt": 1}, "line 2, column 1: is no row"),
        ("1\n", {"unit": "g", "dt": 1}, "has 1 rows"),
        ("# nothing\n", {"unit": "g", "dt": 1}, "has 0 rows"),
    ],
)
def test_columns_that_are_refused(text, arguments, message, tmp_path):
    path = write(tmp_path, text, "a.txt")
    with pytest.raises(sf.SceneError, match=message) as caught:
        sf.motions.read_text(path, **arguments)
    assert "a" in str(caught.value)


# --- a scene file from elsewhere may name any file of its reader's: what it holds is not repeated

SECRET = "hunter2xyzzy"
PRIVATE = {
    "passwords": f"root:{SECRET}:19000:0:99999:7:::\ndaemon:*:19000:0:99999:7:::\n",
    "key": f"-----BEGIN OPENSSH PRIVATE KEY-----\n{SECRET}AAAAB3Nza\n-----END OPENSSH PRIVATE KEY-----\n",
    "settings": f"# production\nPASSWORD={SECRET}\nPORT=8080\n",
    "JSON": f'{{"token": "{SECRET}", "n": [1, 2, 3]}}\n',
    "table": f"time,acc\n0.0,0.1\n0.1,0.2\n0.2,{SECRET}\n0.3,0.1\n",
    "end of a number": f"0.0 0.1\n0.1 0.2{SECRET}\n",
    "beside asterisks": f"0.0 0.1\n0.1 **{SECRET}**\n",
    "beside nan": f"0.0 0.1\n0.1 nan {SECRET}\n",
    "touching": f"0.0 0.1\n0.1 .2.3.4 {SECRET}\n",
    "nan word": f"0.0 0.1\n0.1 nan_{SECRET}\n",
    "unit": TITLE + f"IN UNITS OF {SECRET}\n{LINE}{BODY}",
    "step": HEAD + f"NPTS= 7, DT= inf{SECRET}\n" + BODY,
    "step in words": HEAD + f"NPTS= {SECRET}, DT= {SECRET}\n" + BODY,
    "velocity": TITLE + f"VELOCITY TIME SERIES {SECRET}\n{LINE}{BODY}",
    "after the numbers": HEAD + LINE + BODY + f"{SECRET}\n",
    "second line": f"velocity {SECRET}\n1 2\n",
    "brackets": f"{SECRET} [cm/s]\n1 2\n",
    "control": f"{SECRET}\x00\n1 2\n",
    "no line end": SECRET,
    "latin-1": f"{SECRET} \xe9\xff 1 2\n1 2 x\n",
}
STUDIED = """
[scene]
model = "rolling_isolator"
C = 1.0
m = 1.0
profile = 0.1
motion = {file = "%s"%s}
"""


@pytest.mark.parametrize("case", PRIVATE)
@pytest.mark.parametrize(
    ("name", "given"), [("r.at2", ""), ("r.csv", ', unit = "g"'), ("r.csv", ', unit = "g", dt = 0.1')]
)
def test_what_a_file_holds_is_not_repeated(case, name, given, tmp_path):
    from symfric.scenefile import read_scene_file

    (tmp_path / name).write_text(PRIVATE[case], encoding="latin-1")
    (tmp_path / "scene.toml").write_text(STUDIED % (name, given))
    message = refusal(lambda: read_scene_file(tmp_path / "scene.toml"))
    assert SECRET[:6] not in message
    assert "\n" not in message
    assert name in message
    assert re.search(r"line \d+|no line with NPTS|rows of numbers|ends after|no dt", message), message


def refusal(read) -> str:
    """Return why something is refused; empty if it is not."""
    try:
        read()
    except sf.SceneError as error:
        return str(error)
    return ""


@pytest.mark.one_in(3)
@pytest.mark.parametrize("seed", range(200))
def test_words_of_any_file_are_not_repeated(seed, tmp_path):
    """Lines of numbers, words and signs at random, in the places that the readers look at."""
    chance = random.Random(seed)
    parts = [
        SECRET,
        "1.5",
        "-2",
        "nan",
        "**",
        "NPTS=",
        "DT=",
        "units",
        "velocity",
        "series",
        ",",
        ";",
        "[",
        "#",
        "(cm/s)",
    ]
    rows = [" ".join(chance.choices(parts, k=chance.randint(1, 6))) for _ in range(chance.randint(1, 8))]
    path = write(tmp_path, "\n".join(rows), "r.txt")
    for read in (
        lambda: sf.motions.read_at2(path),
        lambda: sf.motions.read_at2(path, unit="g", dt=0.1),
        lambda: sf.motions.read_text(path, unit="g"),
        lambda: sf.motions.read_text(path, unit="g", dt=0.1),
    ):
        assert SECRET[:6] not in refusal(read)


@pytest.mark.parametrize("lines", [1, 2, 5])
@pytest.mark.parametrize("blank", [0, 1, 2])
@pytest.mark.parametrize("skip", [0, 3])
@pytest.mark.parametrize("between", [" ", ""], ids=["apart", "touching"])
def test_the_last_line_with_numbers_is_named(lines, blank, skip, between):
    rows = ["head"] * skip + [f"1.5E+00{between}-2.5E+00"] * lines + ["", "  "][:blank]
    values, last = parse_numbers("record", rows, skip, first=7)
    assert values.tolist() == [1.5, -2.5] * lines
    assert last == 7 + skip + lines - 1
