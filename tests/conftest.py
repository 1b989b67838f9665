"""What the processes of a test run share.

The event loops are compiled before the workers start: once, side by side, and not in every worker. Linear algebra gets
one thread: on a machine with as many workers as processors more of them wait for each other, for a hundred times as long
as a small matrix takes. SymPy keeps more of what it has worked out, and Python looks less often for cyclic garbage among its
many expressions. Bytecode is kept even where the environment says otherwise: every worker would rewrite the assertions of
all tests again, and every command under test compile the package. Machine code of scenes is compiled fast at first whatever
its length, since most programs of tests run once; `tests/solve/test_drafts.py` shows that it ends at the same bits as the
code compiled for speed, which takes its place in programs that run often. Interrupts reach the commands under test even where
the run itself was told to ignore them.

Of a family marked ``one_in(n)`` one member in n runs, drawn once and for all so that the members differ in as many of their
parameters as possible; the others run with the long tests.

Figures are closed after each test: pyplot warns where more than twenty are open in one process, and warnings are errors.
"""

import gc
import os
import signal
import subprocess
import sys
from collections import defaultdict
from random import Random

import pytest

from tests.longer import ALL, Case, drawn

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # read when NumPy is loaded, by the workers too
os.environ.setdefault("SYMPY_CACHE_SIZE", "20000")
gc.set_threshold(100_000, 50, 100)
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in a shell's background jobs, whose children ignore it too
    signal.signal(signal.SIGINT, signal.default_int_handler)

from symfric.codegen.functions import compile_fast  # noqa: E402  (what is set above is read when it is imported)

compile_fast()

BELT = "sf.simulate(sf.scenes.mass_on_belt(v_b=0.2))"
OTHERS = (
    "sf.simulate(sf.scenes.coulomb_oscillator(0.03)); "
    "sf.simulate(sf.scenes.rolling_isolator(C=1.0, m=1.0, motion=sf.Signal([0.0, 1.0], 0.1), profile=0.1))"
)


def pytest_xdist_setupnodes():
    """Run by the process that starts the workers."""
    loops = [subprocess.Popen([sys.executable, "-c", f"import symfric as sf; {work}"]) for work in (BELT, OTHERS)]
    for loop in loops:
        loop.wait()


@pytest.fixture(autouse=True)
def figures_closed():
    yield
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None:
        pyplot.close("all")


def parameters(item):
    """Return the numbers and words among the parameters of a case; other objects are no two the same."""
    given = item.callspec.params if hasattr(item, "callspec") else {}
    return {k: v for k, v in given.items() if isinstance(v, str | float | int | None)}


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    families = defaultdict(list)
    for item in items:
        if item.get_closest_marker("one_in") and not item.get_closest_marker("long"):
            families[item.nodeid.partition("[")[0]].append(item)
    for name, members in families.items():
        (n,) = members[0].get_closest_marker("one_in").args
        number = len(members) - len(members) * (n - 1) // n
        default = drawn([parameters(item) for item in members], number, Random(name))
        for k, item in enumerate(members):
            if k not in default:
                item.add_marker(pytest.mark.long)
    config.stash[ALL] = [described(item) for item in items]


def described(item):
    marks = list(item.iter_markers("long"))
    beside = next((mark.kwargs["beside"] for mark in marks if mark.kwargs), None)
    file, _, test = item.nodeid.partition("[")[0].partition("::")
    return Case(file, test, bool(marks), beside)
