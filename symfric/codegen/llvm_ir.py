"""Translate straight-line CasADi SX functions to LLVM assembly; long ones are split into parts."""

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import llvmlite.binding as llvm

from symfric.errors import SceneError

# The time to compile a function grows faster than its length. One of more than WHOLE instructions is cut into functions
# of PART instructions, which pass values in memory. By measurement, 9000 instructions run up to a fifth slower in parts
# and are compiled in nine tenths of the time; 16 000 in parts, in two thirds.
WHOLE, PART = 10_000, 500
TESTS = 500  # so is one of more comparisons and logical operations than these, which cost the most
ARITHMETIC = {ca.OP_ADD: "fadd", ca.OP_SUB: "fsub", ca.OP_MUL: "fmul", ca.OP_DIV: "fdiv"}
COMPARISONS = {ca.OP_LT: "olt", ca.OP_LE: "ole", ca.OP_EQ: "oeq", ca.OP_NE: "une"}
_LOGIC = {ca.OP_NOT, ca.OP_AND, ca.OP_OR}
CALLS = {
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
INTRINSICS = {ca.OP_SQRT: "sqrt", ca.OP_FABS: "fabs", ca.OP_FMIN: "minnum", ca.OP_FMAX: "maxnum"}


@dataclass(frozen=True)
class Written:
    """A function given as LLVM assembly, with the methods of a CasADi function that the compiler uses.

    Attributes
    ----------
    label : str
        Its name.
    text : str
    declared : tuple of str
        What else it calls.
    shared : tuple of Shared
        What of that is compiled once for all that call it.
    """

    label: str
    text: str
    declared: tuple[str, ...] = ()
    shared: tuple["Shared", ...] = ()

    def name(self) -> str:
        """Return the name of the function."""
        return self.label

    def serialize(self) -> str:
        """Return the assembly, which identifies the function."""
        return self.text


@dataclass(frozen=True)
class Drafted:
    """A function that is written only if its code is not in the cache.

    Attributes
    ----------
    label : str
        Its name.
    key : str
        Of all that it is written from.
    write : callable
    instructions : int
        About how many it has.
    """

    label: str
    key: str
    write: Callable[[], Written]
    instructions: int = 0

    def name(self) -> str:
        """Return the name of the function."""
        return self.label

    def serialize(self) -> str:
        """Return the key."""
        return self.key


@dataclass(frozen=True)
class Shared:
    """Functions that the code of many scenes calls; they are compiled once and stay for the life of the process.

    Attributes
    ----------
    names : tuple of str
        Of the functions, different from all others of the process.
    key : str
        Of all that they are written from.
    write : callable
    """

    names: tuple[str, ...]
    key: str
    write: Callable[[], list[Written]]


def assembly(functions: Sequence[ca.Function | Written]) -> str:
    """Return LLVM assembly for the functions, one instruction for each of CasADi's.

    Raises
    ------
    SceneError
        If an operation has no machine-code translation; named.
    """
    names = sorted(set(CALLS.values()))
    header = [f'target triple = "{llvm.get_default_triple()}"']
    header += [f"declare double @{n}(double{', double' if n in _BINARY_CALLS else ''})" for n in names]
    header += [f"declare double @llvm.{n}.f64(double)" for n in ("sqrt", "fabs")]
    header += [f"declare double @llvm.{n}.f64(double, double)" for n in ("minnum", "maxnum")]
    header += ["declare double @llvm.fma.f64(double, double, double)"]
    header += sorted({line for f in functions if isinstance(f, Written) for line in f.declared})
    return "\n".join([*header, *(f.text if isinstance(f, Written) else _Function(f).text() for f in functions)])


@dataclass(frozen=True)
class Instructions:
    """The instructions of a CasADi SX function; a value is named by the index of its instruction.

    A product that only one sum needs becomes one instruction with it, with one rounding: which of two, is said here and
    not left to the compiler, so that code for one case and code for vectors of cases end at the same bits. Sums are
    never reordered.

    Attributes
    ----------
    ops : tuple of int
    sources : tuple of tuple of int
        Operands.
    part : int
        Number of instructions of a part of the function.
    fused : dict of int to int
        For sums and differences, the operand (0 or 1) that is a product and becomes one instruction with them.
    """

    ops: tuple[int, ...]
    sources: tuple[tuple[int, ...], ...]
    part: int
    fused: dict[int, int]

    @classmethod
    def of(cls, f: ca.Function, cut: bool = True) -> "Instructions":
        """Read a function."""
        ops = tuple(f.instruction_id(k) for k in range(f.n_instructions()))
        tests = sum(op in COMPARISONS or op in _LOGIC for op in ops)
        part = PART if cut and (len(ops) > WHOLE or tests > TESTS) else max(len(ops), 1)
        held: dict[int, int] = {}  # instruction whose value is in a work register
        sources: list[tuple[int, ...]] = []
        for k, op in enumerate(ops):
            sources.append(() if op in (ca.OP_INPUT, ca.OP_CONST) else tuple(held[a] for a in f.instruction_input(k)))
            if op != ca.OP_OUTPUT:
                held[f.instruction_output(k)[0]] = sources[k][0] if op in (ca.OP_ASSIGN, ca.OP_LIFT) else k
        uses = [0] * len(ops)
        for op, of in zip(ops, sources, strict=True):
            for s in of if op not in (ca.OP_ASSIGN, ca.OP_LIFT) else ():
                uses[s] += 1
        fused = {}
        for k, op in enumerate(ops):
            if op in (ca.OP_ADD, ca.OP_SUB):
                for j in (0, 1):
                    s = sources[k][j]
                    if ops[s] in (ca.OP_MUL, ca.OP_SQ) and uses[s] == 1 and s // part == k // part:
                        fused[k] = j
                        break
        return cls(ops, tuple(sources), part, fused)

    def factors(self, k: int) -> tuple[int, int]:
        """Return the factors of a product."""
        return self.sources[k][0], self.sources[k][-1]


def body(f: ca.Function) -> list[str]:
    """Return the instructions of a short function, between pointers named %i0, %i1, ... and %o0, %o1, ..."""
    return _Function(f, cut=False).lines(0)


def definition(f: ca.Function, name: str) -> str:
    """Return the definition of a function under another name, for the functions beside it."""
    return _Function(f, name=name).text()


class _Function:
    """Writer of one function; the value of an instruction is named by its index."""

    def __init__(self, f: ca.Function, cut: bool = True, name: str = ""):
        self._f, self._given, self._name = f, Instructions.of(f, cut), name or f.name()
        self._ops, self._sources, self._part = self._given.ops, self._given.sources, self._given.part
        self._within = {
            self._sources[k][j] for k, j in self._given.fused.items()
        }  # products without a value of their own
        self._slots, self._room = self._place()
        self._numbers = self._needed_numbers()

    def _place(self) -> tuple[dict[int, int], int]:
        """Return the memory slots of values that later parts need, and the number of slots, which are reused."""
        last: dict[int, int] = {}
        for k, sources in enumerate(self._sources):
            part = k // self._part
            last |= {s: part for s in sources if part > s // self._part and self._is_computed(s)}
        places: dict[int, int] = {}
        free: list[int] = []
        ends: dict[int, list[int]] = {}
        part, room = 0, 0
        for k in sorted(last):
            while part < k // self._part:
                free += ends.pop(part, [])
                part += 1
            if not free:
                free.append(room)
                room += 1
            places[k] = free.pop()
            ends.setdefault(last[k], []).append(places[k])
        return places, room

    def _needed_numbers(self) -> set[int]:
        """Return the tests whose values are needed as the numbers 0 and 1, not only by others in the same part."""
        needed = set(self._slots)
        for k, sources in enumerate(self._sources):
            for j, s in enumerate(sources):
                if self._is_test(s) and not (self._decides(k, j) and s // self._part == k // self._part):
                    needed.add(s)
        return needed

    def _is_test(self, k: int) -> bool:
        return self._ops[k] in COMPARISONS or self._ops[k] in _LOGIC

    def _decides(self, k: int, j: int) -> bool:
        """Whether instruction k asks only whether its operand j is zero."""
        return self._ops[k] in _LOGIC or (self._ops[k] == ca.OP_IF_ELSE_ZERO and j == 0)

    def _is_computed(self, k: int) -> bool:
        return self._ops[k] not in (ca.OP_INPUT, ca.OP_CONST)

    def text(self) -> str:
        """Return the definition of the function, after those of its parts."""
        f = self._f
        names = [f"%i{k}" for k in range(f.n_in())] + [f"%o{k}" for k in range(f.n_out())]
        declared = ", ".join(f"double* noalias nocapture {n}" for n in names)
        parts = range((len(self._ops) - 1) // self._part + 1)
        if len(parts) == 1:
            return _define(f"@{self._name}({declared})", self.lines(0))
        given = ", ".join(f"double* {n}" for n in [*names, "%slots"])
        kept = f"[{self._room} x double]"
        body = [f"%kept = alloca {kept}", f"%slots = getelementptr {kept}, {kept}* %kept, i64 0, i64 0"]
        body += [f"call void @{self._name}.{part}({given})" for part in parts]
        slots = declared + ", double* noalias nocapture %slots"
        texts = [_define(f"internal @{self._name}.{part}({slots})", self.lines(part)) for part in parts]
        return "\n".join([*texts, _define(f"@{self._name}({declared})", body)])

    def lines(self, part: int) -> list[str]:
        """Return the instructions of one part."""
        lines: list[str] = []
        known: dict[int, str] = {}
        for k in range(part * self._part, min((part + 1) * self._part, len(self._ops))):
            op = self._ops[k]
            if op in (ca.OP_INPUT, ca.OP_CONST, ca.OP_ASSIGN, ca.OP_LIFT) or k in self._within:
                continue
            if k in self._given.fused:
                known[k] = self._fused(lines, known, k)
                self._keep(lines, known, k)
                continue
            if self._is_test(k) or op == ca.OP_IF_ELSE_ZERO:
                known[k] = self._branch(lines, known, k)
                self._keep(lines, known, k)
                continue
            values = [self._value(lines, known, s) for s in self._sources[k]]
            if op == ca.OP_OUTPUT:
                output, element = self._f.instruction_output(k)
                _store(lines, f"%a{k}", values[0], f"%o{output}", element)
                continue
            known[k] = _operation(lines, k, op, values)
            self._keep(lines, known, k)
        return lines

    def _keep(self, lines: list[str], known: dict[int, str], k: int) -> None:
        """Store a value that later parts need."""
        if k in self._slots:
            _store(lines, f"%s{k}", known[k], "%slots", self._slots[k])

    def _fused(self, lines: list[str], known: dict[int, str], k: int) -> str:
        """Append a sum or difference with one of its products; return its name."""
        j = self._given.fused[k]
        a, b = (self._value(lines, known, s) for s in self._given.factors(self._sources[k][j]))
        c = self._value(lines, known, self._sources[k][1 - j])
        if self._ops[k] == ca.OP_SUB:
            turned = b if j == 1 else c
            lines.append(f"%n{k} = fneg double {turned}")
            b, c = (f"%n{k}", c) if j == 1 else (b, f"%n{k}")
        lines.append(f"%r{k} = call double @llvm.fma.f64(double {a}, double {b}, double {c})")
        return f"%r{k}"

    def _branch(self, lines: list[str], known: dict[int, str], k: int) -> str:
        """Append a comparison, a logical operation or a choice; return the name of its result."""
        op, sources = self._ops[k], self._sources[k]
        if op in COMPARISONS:
            a, b = (self._value(lines, known, s) for s in sources)
            lines.append(f"%c{k} = fcmp {COMPARISONS[op]} double {a}, {b}")
        elif op == ca.OP_NOT:
            lines.append(f"%c{k} = xor i1 {self._condition(lines, known, k, 0)}, true")
        elif op in _LOGIC:
            a, b = (self._condition(lines, known, k, j) for j in (0, 1))
            lines.append(f"%c{k} = {'and' if op == ca.OP_AND else 'or'} i1 {a}, {b}")
        else:
            a, b = self._condition(lines, known, k, 0), self._value(lines, known, sources[1])
            lines.append(f"%r{k} = select i1 {a}, double {b}, double {literal(0.0)}")
            return f"%r{k}"
        if k in self._numbers:  # half as long to compile as a conversion
            lines.append(f"%r{k} = select i1 %c{k}, double {literal(1.0)}, double {literal(0.0)}")
        return f"%r{k}"

    def _condition(self, lines: list[str], known: dict[int, str], k: int, j: int) -> str:
        """Return the name of the bit that says whether operand j of instruction k is not zero."""
        s = self._sources[k][j]
        if self._is_test(s) and s // self._part == k // self._part:
            return f"%c{s}"
        lines.append(f"%b{k}_{j} = fcmp une double {self._value(lines, known, s)}, {literal(0.0)}")
        return f"%b{k}_{j}"

    def _value(self, lines: list[str], known: dict[int, str], k: int) -> str:
        """Return the name of a value, loaded from its slot at its first use in this part."""
        if k in known:
            return known[k]
        if self._ops[k] == ca.OP_CONST:
            known[k] = literal(self._f.instruction_constant(k))
            return known[k]
        array, element = "%slots", self._slots.get(k)
        if self._ops[k] == ca.OP_INPUT:
            argument, element = self._f.instruction_input(k)
            array = f"%i{argument}"
        lines.append(f"%a{k} = getelementptr double, double* {array}, i64 {element}")
        lines.append(f"%r{k} = load double, double* %a{k}")
        known[k] = f"%r{k}"
        return known[k]


def _define(signature: str, body: list[str]) -> str:
    linkage, _, name = signature.rpartition("@")
    return "\n".join([f"define {linkage}void @{name} nounwind {{", *body, "ret void", "}"])


def _store(lines: list[str], address: str, value: str, array: str, element: int) -> None:
    lines.append(f"{address} = getelementptr double, double* {array}, i64 {element}")
    lines.append(f"store double {value}, double* {address}")


def _operation(lines: list[str], k: int, op: int, v: list[str]) -> str:
    """Append the code of one operation and return the name of its result."""
    r = f"%r{k}"
    if op in ARITHMETIC:
        lines.append(f"{r} = {ARITHMETIC[op]} double {v[0]}, {v[1]}")
    elif op == ca.OP_SQ:
        lines.append(f"{r} = fmul double {v[0]}, {v[0]}")
    elif op == ca.OP_TWICE:
        lines.append(f"{r} = fadd double {v[0]}, {v[0]}")
    elif op == ca.OP_NEG:
        lines.append(f"{r} = fneg double {v[0]}")
    elif op == ca.OP_INV:
        lines.append(f"{r} = fdiv double {literal(1.0)}, {v[0]}")
    elif op in INTRINSICS:
        lines.append(f"{r} = call double @llvm.{INTRINSICS[op]}.f64({', '.join('double ' + x for x in v)})")
    elif op in CALLS:
        lines.append(f"{r} = call double @{CALLS[op]}({', '.join('double ' + x for x in v)})")
    else:
        raise SceneError(f"CasADi operation number {op} has no machine-code translation; use route='integrators'")
    return r


def literal(x: float) -> str:
    """Return a number as LLVM reads it, with all its bits."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', x))[0]:016X}"
