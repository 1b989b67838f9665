"""Benchmark of run time against error: problems with known solutions, the package's routes, and installed peers."""

from symfric_evidence.bench.problems import problems
from symfric_evidence.bench.result import Benchmark, ErrorCurve, ErrorPoint
from symfric_evidence.bench.timing import measure

__all__ = ["Benchmark", "ErrorCurve", "ErrorPoint", "measure", "problems"]
