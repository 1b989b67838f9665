"""Run time against error: problems with known answers, the package's routes, and the peers that are installed."""

from symfric.bench.measure import measure
from symfric.bench.problems import problems
from symfric.bench.result import Benchmark, Curve, Point

__all__ = ["Benchmark", "Curve", "Point", "measure", "problems"]
