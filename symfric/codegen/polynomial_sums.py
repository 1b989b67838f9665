"""LLVM assembly of sums of Taylor polynomials, four terms side by side in a vector."""

from functools import lru_cache

from symfric.codegen.llvm_ir import Written

_LANES = 4
_TYPE = f"<{_LANES} x double>"
_FMA, _SIZE = f"@llvm.fma.v{_LANES}f64", f"@llvm.fabs.v{_LANES}f64"
_DECLARED = (f"declare {_TYPE} {_FMA}({_TYPE}, {_TYPE}, {_TYPE})", f"declare {_TYPE} {_SIZE}({_TYPE})")


@lru_cache(maxsize=64)
def polynomial_sums(name: str, plain: int, bounded: int, order: int) -> Written:
    """Return the function ``([h; far], coefficients) -> sums`` of the terms 1 to `order` of every row.

    Those of the first rows over h, and those of the magnitudes of the terms of the others over `far`. The bits are
    those of `symfric.solve.loop.stepping.series.reach`, whose four interleaved sums are the lanes here.

    Parameters
    ----------
    name : str
    plain, bounded : int
        Number of rows of each kind.
    order : int
        Highest order of the coefficients, which are given row by row from order zero on.
    """
    lines = []
    for k in (0, 1):
        lines += [
            f"%h{k}_at = getelementptr double, double* %s, i64 {k}",
            f"%h{k} = load double, double* %h{k}_at",
            f"%q{k} = fmul double %h{k}, %h{k}",
            f"%f{k} = fmul double %q{k}, %q{k}",
            f"%g{k} = insertelement {_TYPE} undef, double %f{k}, i64 0",
            f"%x{k} = shufflevector {_TYPE} %g{k}, {_TYPE} undef, <{_LANES} x i32> zeroinitializer",
        ]
    for r in range(plain + bounded):
        lines += _row(r, int(r >= plain), order)
    head = f"define void @{name}(double* noalias nocapture %s, double* noalias nocapture %c, double* noalias %out)"
    return Written(name, "\n".join([f"{head} nounwind {{", *lines, "ret void", "}"]), _DECLARED)


def _row(r: int, k: int, order: int) -> list[str]:
    """Return the instructions of row r, over the step with the index k; magnitudes over the second one."""
    lines: list[str] = []
    total = ""
    for first in reversed(range(1, order + 1, _LANES)):
        terms = f"%c{r}_{first}"
        lines += _terms(terms, r * (order + 1) + first, min(_LANES, order + 1 - first))
        if k:
            lines.append(f"%a{r}_{first} = call {_TYPE} {_SIZE}({_TYPE} {terms})")
            terms = f"%a{r}_{first}"
        if total:
            lines.append(f"%t{r}_{first} = call {_TYPE} {_FMA}({_TYPE} {total}, {_TYPE} %x{k}, {_TYPE} {terms})")
        total = f"%t{r}_{first}" if total else terms
    lines += [f"%e{r}_{j} = extractelement {_TYPE} {total}, i64 {j}" for j in range(_LANES)]
    fused = "call double @llvm.fma.f64"
    return [
        *lines,
        f"%u{r} = {fused}(double %h{k}, double %e{r}_1, double %e{r}_0)",
        f"%v{r} = {fused}(double %h{k}, double %e{r}_3, double %e{r}_2)",
        f"%w{r} = {fused}(double %q{k}, double %v{r}, double %u{r})",
        f"%z{r} = fmul double %h{k}, %w{r}",
        f"%o{r} = getelementptr double, double* %out, i64 {r}",
        f"store double %z{r}, double* %o{r}",
    ]


def _terms(name: str, place: int, count: int) -> list[str]:
    """Return the instructions that load so many coefficients into a vector, with zeros behind them."""
    if count == _LANES:
        return [
            f"{name}_at = getelementptr double, double* %c, i64 {place}",
            f"{name}_to = bitcast double* {name}_at to {_TYPE}*",
            f"{name} = load {_TYPE}, {_TYPE}* {name}_to, align 8",
        ]
    lines, before = [], "zeroinitializer"
    for j in range(count):
        after = name if j == count - 1 else f"{name}_{j}"
        lines += [
            f"{name}_at{j} = getelementptr double, double* %c, i64 {place + j}",
            f"{name}_is{j} = load double, double* {name}_at{j}",
            f"{after} = insertelement {_TYPE} {before}, double {name}_is{j}, i64 {j}",
        ]
        before = after
    return lines
