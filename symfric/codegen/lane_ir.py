"""LLVM assembly of functions that do the same to several cases side by side, one in each lane of vectors.

Python expressions of `Lanes` write the code: arithmetic for all lanes at once, and masks for what only some of them do.
A lane's bits never depend on its neighbours: a branch or a loop runs if any lane is in its mask, and what the others
compute there is thrown away.
"""

import struct
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import casadi as ca

from symfric.codegen.lane_values import FLAG, REAL, WHOLE, Lanes, Value, are_whole, is_number, kind_of, moves, real
from symfric.codegen.llvm_ir import ARITHMETIC, CALLS, COMPARISONS, INTRINSICS, Instructions, Written
from symfric.errors import SceneError


class LaneCode:
    """One function ``void name(double* S, double* N, i64* F)`` of blocks of `width` lanes: fields, notes, masks."""

    def __init__(self, name: str, width: int):
        self._name, self._width = name, width
        self._lines: list[str] = []
        self._n, self._block = 0, "entry"
        self._contract = True  # whether a product and a sum may become one instruction, as in the loop for one case
        self._type = {REAL: f"<{width} x double>", FLAG: f"<{width} x i1>", WHOLE: f"<{width} x i64>"}

    def written(self) -> Written:
        """Return the function."""
        d, w = self._type[REAL], self._width
        calls = "\n".join(line for line in self._lines if "@" in line)
        unary = "fabs", "sqrt", "arithmetic.fence"
        of_vectors = {f"declare {d} @llvm.{n}.v{w}f64({d})": f"llvm.{n}.v" for n in unary}
        of_vectors |= {f"declare {d} @llvm.{n}.v{w}f64({d}, {d})": f"llvm.{n}.v" for n in ("minnum", "maxnum")}
        of_vectors |= {f"declare {d} @llvm.fma.v{w}f64({d}, {d}, {d})": "llvm.fma.v"}
        head = f"define void @{self._name}({d}* noalias nocapture %S, {d}* noalias %N, i64* noalias %F) nounwind {{"
        used = tuple(text for text, what in of_vectors.items() if what in calls)
        return Written(self._name, "\n".join([head, "entry:", *self._lines, "ret void", "}"]), used)

    def _new(self, kind: str, text: str) -> Lanes:
        self._n += 1
        self._lines.append(f"%v{self._n} = {text}")
        return Lanes(self, f"%v{self._n}", kind)

    def _plain(self, text: str) -> str:
        return self._new("", text).name

    def _ref(self, a: Value) -> str:
        if isinstance(a, Lanes):
            return a.name
        if isinstance(a, bool):
            entry = f"i1 {str(a).lower()}"
        elif isinstance(a, int):
            entry = f"i64 {a}"
        else:
            entry = f"double 0x{struct.unpack('<Q', struct.pack('<d', a))[0]:016X}"
        return "<" + ", ".join([entry] * self._width) + ">"

    def _op(self, text: str, kind: str, a: Value, b: Value) -> Lanes:
        a, b = (real(a), real(b)) if kind == REAL else (a, b)
        return self._new(kind, f"{text} {self._type[kind]} {self._ref(a)}, {self._ref(b)}")

    def _arithmetic(self, op: int, a: Value, b: Value) -> Lanes:
        how = " contract" if self._contract and op != ca.OP_DIV else ""
        return self._op(ARITHMETIC[op] + how, REAL, a, b)

    # arithmetic
    def add(self, a: Value, b: Value) -> Value:
        """Return a + b."""
        if not moves(a) and not moves(b):
            return a + b
        if are_whole(a, b):
            return self.whole("add", a, b)
        return b if is_number(a, 0) else a if is_number(b, 0) else self._arithmetic(ca.OP_ADD, a, b)

    def sub(self, a: Value, b: Value) -> Value:
        """Return a - b."""
        if not moves(a) and not moves(b):
            return a - b
        if are_whole(a, b):
            return self.whole("sub", a, b)
        return a if is_number(b, 0) else self.neg(b) if is_number(a, 0) else self._arithmetic(ca.OP_SUB, a, b)

    def mul(self, a: Value, b: Value) -> Value:
        """Return a b; zero if one of them is known to be that."""
        if not moves(a) and not moves(b):
            return a * b
        if are_whole(a, b):
            return self.whole("mul", a, b)
        if is_number(a, 0) or is_number(b, 0):
            return 0.0
        return b if is_number(a, 1) else a if is_number(b, 1) else self._arithmetic(ca.OP_MUL, a, b)

    def div(self, a: Value, b: Value) -> Value:
        """Return a / b."""
        if not moves(a) and not moves(b):
            return a / b
        return 0.0 if is_number(a, 0) else self._arithmetic(ca.OP_DIV, a, b)

    def fma(self, a: Value, b: Value, c: Value) -> Value:
        """Return a b + c with one rounding."""
        if is_number(a, 0) or is_number(b, 0):
            return c
        if is_number(a, 1) or is_number(b, 1):
            return self.add(b if is_number(a, 1) else a, c)
        return self._intrinsic("fma", *map(real, (a, b, c)))

    def twice(self, a: Value) -> Value:
        """Return 2 a."""
        return self._op("fadd", REAL, a, a) if moves(a) else 2.0 * a

    def neg(self, a: Value) -> Value:
        """Return -a."""
        return self._new(REAL, f"fneg {self._type[REAL]} {a.name}") if moves(a) else -a

    def _intrinsic(self, name: str, *args: Value) -> Lanes:
        d = self._type[REAL]
        given = ", ".join(f"{d} {self._ref(a)}" for a in args)
        return self._new(REAL, f"call {d} @llvm.{name}.v{self._width}f64({given})")

    def abs(self, a: Value) -> Value:
        """Return the magnitude."""
        return self._intrinsic("fabs", a) if moves(a) else abs(a)

    def sqrt(self, a: Value) -> Value:
        """Return the square root."""
        return self._intrinsic("sqrt", a)

    def compare(self, how: str, a: Value, b: Value) -> Lanes:
        """Return a mask."""
        return self._new(FLAG, f"fcmp {how} {self._type[REAL]} {self._ref(real(a))}, {self._ref(real(b))}")

    def ordered(self, how: str, a: Value, b: Value) -> Lanes:
        """Return where two numbers are in this order."""
        return self.compare_whole(f"s{how}", a, b) if are_whole(a, b) else self.compare(f"o{how}", a, b)

    def equal(self, a: Value, b: Value) -> Lanes:
        """Return where two numbers are equal."""
        return self.compare("oeq", a, b)

    def logic(self, how: str, a: Value, b: Value) -> Value:
        """Return a mask of two masks, or the bits of two whole numbers."""
        if are_whole(a, b):
            return self.whole(how, a, b)
        for p, q in ((a, b), (b, a)):
            if isinstance(p, bool):
                if how != "xor":
                    return q if p == (how == "and") else p
                if not p:
                    return q
        return self._op(how, FLAG, a, b)

    def opposite(self, mask: Value) -> Value:
        """Return the lanes that are not in a mask."""
        return not mask if isinstance(mask, bool) else self.logic("xor", mask, True)

    def select(self, mask: Value, a: Value, b: Value) -> Value:
        """Return a in the lanes of the mask and b in the others."""
        if isinstance(mask, bool):
            return a if mask else b
        if a is b or (not moves(a) and not moves(b) and a == b):
            return a
        kind = WHOLE if are_whole(a, b) else kind_of(a)
        t = self._type[kind]
        a, b = (real(a), real(b)) if kind == REAL else (a, b)
        return self._new(kind, f"select {self._type[FLAG]} {mask.name}, {t} {self._ref(a)}, {t} {self._ref(b)}")

    def max(self, a: Value, b: Value) -> Value:
        """Return the larger; b if one is NaN."""
        return max(a, b) if not moves(a) and not moves(b) else self.select(self.ordered("gt", a, b), a, b)

    def min(self, a: Value, b: Value) -> Value:
        """Return the smaller; b if one is NaN."""
        return min(a, b) if not moves(a) and not moves(b) else self.select(self.ordered("lt", a, b), a, b)

    # whole numbers, and the bits of others
    def bits(self, a: Lanes) -> Lanes:
        """Return the bits of numbers."""
        return self._new(WHOLE, f"bitcast {self._type[REAL]} {self._ref(a)} to {self._type[WHOLE]}")

    def from_bits(self, a: Lanes) -> Lanes:
        """Return the numbers of some bits."""
        return self._new(REAL, f"bitcast {self._type[WHOLE]} {a.name} to {self._type[REAL]}")

    def whole(self, op: str, a: Value, b: Value) -> Lanes:
        """Return an operation of LLVM on whole numbers."""
        return self._op(op, WHOLE, a, b)

    def compare_whole(self, how: str, a: Value, b: Value) -> Lanes:
        """Return a mask."""
        return self._new(FLAG, f"icmp {how} {self._type[WHOLE]} {self._ref(a)}, {self._ref(b)}")

    # memory
    def _place(self, k: int, of: str = "%S") -> str:
        d = self._type[REAL]
        return f"{d}* {self._plain(f'getelementptr {d}, {d}* {of}, i64 {k}')}, align {8 * self._width}"

    def load(self, k: int) -> Lanes:
        """Return field k."""
        return self._new(REAL, f"load {self._type[REAL]}, {self._place(k)}")

    def store(self, k: int, a: Value) -> None:
        """Set field k."""
        self._lines.append(f"store {self._type[REAL]} {self._ref(a)}, {self._place(k)}")

    def note(self, k: int, a: Value) -> None:
        """Set note k."""
        self._lines.append(f"store {self._type[REAL]} {self._ref(a)}, {self._place(k, '%N')}")

    def store_mask(self, k: int, mask: Value) -> None:
        """Set word k of the masks, one bit for each lane."""
        wide = self._plain(f"zext i{self._width} {self._bitmask(mask)} to i64")
        self._lines.append(f"store i64 {wide}, i64* {self._plain(f'getelementptr i64, i64* %F, i64 {k}')}")

    def load_mask(self, k: int) -> Lanes:
        """Return word k of the masks."""
        wide = self._plain(f"load i64, i64* {self._plain(f'getelementptr i64, i64* %F, i64 {k}')}")
        narrow = self._plain(f"trunc i64 {wide} to i{self._width}")
        return self._new(FLAG, f"bitcast i{self._width} {narrow} to {self._type[FLAG]}")

    def _bitmask(self, mask: Value) -> str:
        return self._plain(f"bitcast {self._type[FLAG]} {self._ref(mask)} to i{self._width}")

    # control
    def _any(self, mask: Value) -> str:
        return self._plain(f"icmp ne i{self._width} {self._bitmask(mask)}, 0")

    def _begin(self, label: str) -> None:
        self._lines.append(f"{label}:")
        self._block = label

    def _phi(self, a: Value, first: str, b: Value, second: str) -> str:
        return f"phi {self._type[kind_of(a)]} [ {self._ref(a)}, %{first} ], [ {self._ref(b)}, %{second} ]"

    def branch(
        self, mask: Value, olds: Sequence[Value], body: Callable[[Sequence[Value]], Sequence[Value]]
    ) -> list[Value]:
        """Return ``body(olds)`` if any lane is in the mask, else olds; the body itself selects what a lane keeps."""
        self._n += 1
        do, end, before = f"do{self._n}", f"end{self._n}", self._block
        self._lines.append(f"br i1 {self._any(mask)}, label %{do}, label %{end}")
        self._begin(do)
        news, after = body(olds), self._block
        self._lines.append(f"br label %{end}")
        self._begin(end)
        return [self._new(kind_of(o), self._phi(o, before, n, after)) for o, n in zip(olds, news, strict=True)]

    def loop(self, state: Sequence[Value], body: Callable[[Sequence[Value]], Sequence[Value]]) -> list[Value]:
        """Repeat ``state = body(state)`` while any lane is in the mask state[0]; lanes that left it must not change."""
        self._n += 1
        do, end, before = f"loop{self._n}", f"end{self._n}", self._block
        self._lines.append(f"br i1 {self._any(state[0])}, label %{do}, label %{end}")
        self._begin(do)
        at, inner = len(self._lines), [self._new(kind_of(a), "") for a in state]
        news = body(inner)
        go, after = self._any(news[0]), self._block
        for j, (a, v, b) in enumerate(zip(state, inner, news, strict=True)):
            self._lines[at + j] = f"{v.name} = {self._phi(a, before, b, after)}"
        self._lines.append(f"br i1 {go}, label %{do}, label %{end}")
        self._begin(end)
        return [self._new(v.kind, self._phi(a, before, b, after)) for a, v, b in zip(state, inner, news, strict=True)]

    # functions
    def _lane_by_lane(self, name: str, args: Sequence[Value]) -> Lanes:
        """Call a function of the C library for one lane after another."""
        made = "undef"
        for lane in range(self._width):
            d = self._type[REAL]
            one = ["double " + self._plain(f"extractelement {d} {self._ref(a)}, i32 {lane}") for a in args]
            value = self._plain(f"call double @{name}({', '.join(one)})")
            made = self._plain(f"insertelement {d} {made}, double {value}, i32 {lane}")
        return Lanes(self, made, REAL)

    def graph(self, f: ca.Function, inputs: Sequence[Sequence[Value]]) -> list[list[Value]]:
        """Return the outputs of a CasADi SX function as lists, given its inputs as lists; rounded, as in memory."""
        given = Instructions.of(f)
        within = {given.sources[k][j] for k, j in given.fused.items()}
        value: list[Any] = [None] * len(given.ops)
        outs: list[list[Value]] = [[0.0] * f.nnz_out(i) for i in range(f.n_out())]
        self._contract = False
        for k, op in enumerate(given.ops):
            if k in within:
                continue
            if op == ca.OP_INPUT:
                place = f.instruction_input(k)
                value[k] = inputs[place[0]][place[1]]
            elif op == ca.OP_CONST:
                value[k] = float(f.instruction_constant(k))
            elif op == ca.OP_OUTPUT:
                place = f.instruction_output(k)
                outs[place[0]][place[1]] = self._number(value[given.sources[k][0]])
            elif k in given.fused:
                j = given.fused[k]
                a, b = (self._number(value[s]) for s in given.factors(given.sources[k][j]))
                c = self._number(value[given.sources[k][1 - j]])
                if op == ca.OP_SUB:
                    b, c = (self.neg(b), c) if j == 1 else (b, self.neg(c))
                value[k] = self.fma(a, b, c)
            elif op not in (ca.OP_ASSIGN, ca.OP_LIFT):
                value[k] = self._operation(op, [value[s] for s in given.sources[k]])
        self._contract = True
        return [[self.rounded(a) for a in out] for out in outs]

    @contextmanager
    def apart(self) -> Iterator[None]:
        """Let no product and sum that are written meanwhile become one instruction."""
        self._contract, before = False, self._contract
        yield
        self._contract = before

    def rounded(self, a: Value) -> Value:
        """Return a value that no later operation becomes one instruction with, as one that is read from memory."""
        return self._intrinsic("arithmetic.fence", a) if moves(a) else a

    def _number(self, a: Value) -> Value:
        return self.select(a, 1.0, 0.0) if kind_of(a) == FLAG else a

    def _flag(self, a: Value) -> Value:
        if kind_of(a) == FLAG:
            return a
        return self.compare("une", a, 0.0) if moves(a) else a != 0.0

    def _operation(self, op: int, given: list[Value]) -> Value:
        if op == ca.OP_IF_ELSE_ZERO:
            return self.select(self._flag(given[0]), self._number(given[1]), 0.0)
        if op in (ca.OP_NOT, ca.OP_AND, ca.OP_OR):
            flags = [self._flag(a) for a in given]
            return self.logic("xor", flags[0], True) if op == ca.OP_NOT else self.logic(_LOGIC[op], *flags)
        v = [self._number(a) for a in given]
        if op in CALLS:
            return self._lane_by_lane(CALLS[op], v)
        if op in COMPARISONS:
            return self.compare(COMPARISONS[op], *v)
        if op in INTRINSICS:
            return self.abs(v[0]) if op == ca.OP_FABS else self._intrinsic(INTRINSICS[op], *v)
        if op in _PLAIN:
            return _PLAIN[op](self, *v)
        raise SceneError(f"CasADi operation number {op} has no machine-code translation; use route='integrators'")


_LOGIC = {ca.OP_AND: "and", ca.OP_OR: "or"}
_PLAIN: dict[int, Callable[..., Value]] = {
    ca.OP_ADD: LaneCode.add,
    ca.OP_SUB: LaneCode.sub,
    ca.OP_MUL: LaneCode.mul,
    ca.OP_DIV: LaneCode.div,
    ca.OP_NEG: LaneCode.neg,
    ca.OP_SQ: lambda g, a: g.mul(a, a),
    ca.OP_TWICE: lambda g, a: g.twice(a),
    ca.OP_INV: lambda g, a: g.div(1.0, a),
}
