"""What the processes of a test run share.

The event loops are compiled before the workers start: once, side by side, and not in every worker. Linear algebra gets
one thread: on a machine with as many workers as processors more of them wait for each other, for a hundred times as long
as a small matrix takes.
"""

import os
import subprocess
import sys

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # read when NumPy is loaded, by the workers too

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
