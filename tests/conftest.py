"""The event loops are compiled before the workers start: once, side by side, and not in every worker."""

import subprocess
import sys

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
