"""Benchmark of run time against error: problems with known solutions, the package's routes, and installed peers."""

from symfric.bench.problems import problems
from symfric.bench.result import Benchmark, ErrorCurve, ErrorPoint
from symfric.bench.timing import measure

__all__ = ["Benchmark", "ErrorCurve", "ErrorPoint", "measure", "problems"]
