"""Run time against error: problems with known answers, the package's routes, and the peers that are installed."""

from symfric.bench.problems import problems
from symfric.bench.result import Benchmark, Curve, Point
from symfric.bench.timing import measure

__all__ = ["Benchmark", "Curve", "Point", "measure", "problems"]
