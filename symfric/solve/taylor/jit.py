"""Straight-line CasADi SX functions as machine code, through LLVM and without a C compiler.

A function with one or more dense inputs becomes ``void f(double* in_0, ..., double* out_0, ...)``. Objects are kept on
disk under a hash of their instructions and of the processor, so that a second process only loads them.
"""

import hashlib
import struct
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import llvmlite.binding as llvm

from symfric.errors import SceneError
from symfric.solve.machine import link, load, store, target_key, target_machine

_FORMAT = 4  # of the generated code; part of the cache key
LONG = 50_000  # instructions; optimising longer functions takes minutes and makes them twice as fast
# `contract` lets a product and a sum become one fused instruction: fewer roundings and shorter chains, at the price of
# last bits that differ between processors; sums are never reordered
_ARITHMETIC = {
    ca.OP_ADD: "fadd contract",
    ca.OP_SUB: "fsub contract",
    ca.OP_MUL: "fmul contract",
    ca.OP_DIV: "fdiv",
}
_COMPARISONS = {ca.OP_LT: "olt", ca.OP_LE: "ole", ca.OP_EQ: "oeq", ca.OP_NE: "une"}
_CALLS = {
    ca.OP_EXP: "exp",
    ca.OP_LOG: "log",
    ca.OP_POW: "pow",
    ca.OP_CONSTPOW: "pow",
    ca.OP_SIN: "sin",
    ca.OP_COS: "cos",
    ca.OP_TAN: "tan",
    ca.OP_ASIN: "asin",
    ca.OP_ACOS: "acos",
    ca.OP_ATAN: "atan",
    ca.OP_SINH: "sinh",
    ca.OP_COSH: "cosh",
    ca.OP_TANH: "tanh",
    ca.OP_ASINH: "asinh",
    ca.OP_ACOSH: "acosh",
    ca.OP_ATANH: "atanh",
    ca.OP_ATAN2: "atan2",
    ca.OP_EXPM1: "expm1",
    ca.OP_LOG1P: "log1p",
    ca.OP_HYPOT: "hypot",
    ca.OP_ERF: "erf",
    ca.OP_FLOOR: "floor",
    ca.OP_CEIL: "ceil",
}
_BINARY_CALLS = {"pow", "atan2", "hypot"}
_INTRINSICS = {ca.OP_SQRT: "sqrt", ca.OP_FABS: "fabs", ca.OP_FMIN: "minnum", ca.OP_FMAX: "maxnum"}


@dataclass(frozen=True)
class MachineCode:
    """Compiled functions; their addresses are valid as long as this object lives.

    Attributes
    ----------
    addresses : dict of str to int
        By function name.
    cached : bool
        Whether the code came from the disk.
    """

    addresses: dict[str, int]
    cached: bool
    _engine: object


def compile_functions(functions: Sequence[ca.Function]) -> MachineCode:
    """Compile SX functions into one object, or load it from the cache.

    Raises
    ------
    SceneError
        If an operation has no machine-code translation; named.
    """
    place = f"{_key(functions)}.o"
    code = load(place)
    cached = code is not None
    if code is None:
        machine = target_machine(opt=2 if sum(f.n_instructions() for f in functions) < LONG else 0)
        code = machine.emit_object(llvm.parse_assembly(assembly(functions)))
        store(place, code)
    engine = link(code)
    return MachineCode({f.name(): engine.get_function_address(f.name()) for f in functions}, cached, engine)


def assembly(functions: Sequence[ca.Function]) -> str:
    """Return LLVM assembly for the functions, one instruction for each of CasADi's."""
    names = sorted(set(_CALLS.values()))
    header = [f'target triple = "{llvm.get_default_triple()}"']
    header += [f"declare double @{n}(double{', double' if n in _BINARY_CALLS else ''})" for n in names]
    header += [f"declare double @llvm.{n}.f64(double)" for n in ("sqrt", "fabs")]
    header += [f"declare double @llvm.{n}.f64(double, double)" for n in ("minnum", "maxnum")]
    return "\n".join([*header, *(_function(f) for f in functions)])


def _function(f: ca.Function) -> str:
    arguments = [f"double* noalias nocapture %i{k}" for k in range(f.n_in())]
    arguments += [f"double* noalias nocapture %o{k}" for k in range(f.n_out())]
    lines = [f"define void @{f.name()}({', '.join(arguments)}) nounwind {{"]
    value: dict[int, str] = {}
    for k in range(f.n_instructions()):
        op, out, args = f.instruction_id(k), f.instruction_output(k), f.instruction_input(k)
        if op == ca.OP_CONST:
            value[out[0]] = _literal(f.instruction_constant(k))
        elif op == ca.OP_INPUT:
            lines.append(f"%a{k} = getelementptr double, double* %i{args[0]}, i64 {args[1]}")
            lines.append(f"%r{k} = load double, double* %a{k}")
            value[out[0]] = f"%r{k}"
        elif op == ca.OP_OUTPUT:
            lines.append(f"%a{k} = getelementptr double, double* %o{out[0]}, i64 {out[1]}")
            lines.append(f"store double {value[args[0]]}, double* %a{k}")
        else:
            value[out[0]] = _operation(lines, k, op, [value[a] for a in args])
    return "\n".join([*lines, "ret void", "}"])


def _operation(lines: list[str], k: int, op: int, v: list[str]) -> str:
    """Append the code of one operation and return the name of its result."""
    r = f"%r{k}"
    if op in _ARITHMETIC:
        lines.append(f"{r} = {_ARITHMETIC[op]} double {v[0]}, {v[1]}")
    elif op == ca.OP_SQ:
        lines.append(f"{r} = fmul contract double {v[0]}, {v[0]}")
    elif op == ca.OP_TWICE:
        lines.append(f"{r} = fadd double {v[0]}, {v[0]}")
    elif op == ca.OP_NEG:
        lines.append(f"{r} = fneg double {v[0]}")
    elif op == ca.OP_INV:
        lines.append(f"{r} = fdiv double {_literal(1.0)}, {v[0]}")
    elif op in _INTRINSICS:
        lines.append(f"{r} = call double @llvm.{_INTRINSICS[op]}.f64({', '.join('double ' + x for x in v)})")
    elif op in _COMPARISONS:
        lines.append(f"%c{k} = fcmp {_COMPARISONS[op]} double {v[0]}, {v[1]}")
        lines.append(f"{r} = uitofp i1 %c{k} to double")
    elif op in (ca.OP_NOT, ca.OP_AND, ca.OP_OR):
        _logic(lines, k, op, v)
    elif op == ca.OP_IF_ELSE_ZERO:
        lines.append(f"%c{k} = fcmp une double {v[0]}, {_literal(0.0)}")
        lines.append(f"{r} = select i1 %c{k}, double {v[1]}, double {_literal(0.0)}")
    elif op in _CALLS:
        lines.append(f"{r} = call double @{_CALLS[op]}({', '.join('double ' + x for x in v)})")
    elif op in (ca.OP_ASSIGN, ca.OP_LIFT):
        return v[0]
    else:
        raise SceneError(f"CasADi operation number {op} has no machine-code translation; use route='integrators'")
    return r


def _logic(lines: list[str], k: int, op: int, v: list[str]) -> None:
    for j, x in enumerate(v):
        lines.append(f"%b{k}_{j} = fcmp une double {x}, {_literal(0.0)}")
    if op == ca.OP_NOT:
        lines.append(f"%c{k} = xor i1 %b{k}_0, true")
    else:
        lines.append(f"%c{k} = {'and' if op == ca.OP_AND else 'or'} i1 %b{k}_0, %b{k}_1")
    lines.append(f"%r{k} = uitofp i1 %c{k} to double")


def _literal(x: float) -> str:
    return f"0x{struct.unpack('<Q', struct.pack('<d', x))[0]:016X}"


def _key(functions: Sequence[ca.Function]) -> str:
    parts = [str(_FORMAT), target_key(), *(f.serialize() for f in functions)]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()
