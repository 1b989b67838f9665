"""LLVM assembly of a function that does the same to several columns of numbers, side by side in vectors.

The function of one column is given as a CasADi SX function; every column has the bits of that function.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca

from symfric.codegen.llvm_ir import ARITHMETIC, Drafted, Instructions, Written, definition, literal
from symfric.errors import SceneError

_WIDEST = 8  # columns side by side


@dataclass(frozen=True)
class Layout:
    """Where a series with columns of derivatives has its numbers.

    Attributes
    ----------
    n_x, n_s : int
        States of the motion, and columns.
    between : int
        Rows between the states of the last column and the rows of the columns: guards, and observables.
    """

    n_x: int
    n_s: int
    between: int

    @cached_property
    def chunks(self) -> tuple[tuple[int, int, int], ...]:
        """First column, number of columns and of lanes of every part."""
        starts = range(0, self.n_s, _WIDEST)
        counts = [min(_WIDEST, self.n_s - s) for s in starts]
        return tuple((s, n, 1 << (n - 1).bit_length()) for s, n in zip(starts, counts, strict=True))

    @property
    def room_of_entry(self) -> int:
        """Numbers that an entry with a value for every column takes."""
        return self.chunks[-1][0] + self.chunks[-1][2]


@dataclass(frozen=True)
class WithColumns:
    """A series with columns of derivatives, ``([y; t], aux) -> c``, with the methods that a CasADi function has.

    Attributes
    ----------
    label : str
        Its name.
    values : casadi.Function
        ``([y; t], aux) -> (states, others, handed)``: rows of the motion, and what its columns take from it: shared
        values, then those that every column has of its own, `Layout.room_of_entry` for each of them.
    column : casadi.Function
        ``(V, shared, aux, own) -> (states, rows)``.
    layout : Layout
    """

    label: str
    values: ca.Function
    column: ca.Function
    layout: Layout

    def name(self) -> str:
        """Return the name of the function."""
        return self.label

    def serialize(self) -> str:
        """Return a text that identifies the function."""
        return f"{self.label} {self.values.serialize()} {self.column.serialize()} {self.layout}"

    def n_instructions(self) -> int:
        """Return the number of instructions for all columns, one after the other."""
        return int(self.values.n_instructions() + self.layout.n_s * self.column.n_instructions())

    def drafted(self) -> Drafted:
        """Return the function as it is compiled, with columns side by side."""
        instructions = int(self.values.n_instructions() + self.column.n_instructions())
        return Drafted(self.label, self.serialize(), lambda: _written(*self._parts()), instructions)

    def _parts(self) -> tuple[str, ca.Function, ca.Function, Layout]:
        return self.label, self.values, self.column, self.layout

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON can hold."""
        layout = self.layout.n_x, self.layout.n_s, self.layout.between
        return {"label": self.label, "functions": [self.values.serialize(), self.column.serialize()], "layout": layout}

    @classmethod
    def from_dict(cls, told: dict[str, Any]) -> "WithColumns":
        """Return the function of which `to_dict` told."""
        values, column = (ca.Function.deserialize(e) for e in told["functions"])
        return cls(told["label"], values, column, Layout(*told["layout"]))

    def of(
        self,
        graph: Callable[[ca.Function, list[Sequence[Any]]], list[list[Any]]],
        state: Sequence[Any],
        aux: Sequence[Any],
    ) -> list[Any]:
        """Return the coefficients, one column after the other, by a way to carry out a CasADi function.

        Parameters
        ----------
        graph : callable
            Takes a function and lists of its inputs, and returns lists of its outputs.
        state, aux : sequence
        """
        n_x, n_s, room = self.layout.n_x, self.layout.n_s, self.layout.room_of_entry
        states, others, handed = graph(self.values, [state, aux])
        shared, own = handed[: self.column.nnz_in(1)], handed[self.column.nnz_in(1) :]
        found = [
            graph(self.column, [state[n_x * (1 + s) : n_x * (2 + s)], shared, aux, own[s::room]]) for s in range(n_s)
        ]
        orders = len(states) // n_x
        for motion, _ in found:
            states = states + motion
        rows = range(0, self.column.nnz_out(1), orders)
        return [*states, *others, *(e for r in rows for _, rows_of in found for e in rows_of[r : r + orders])]


def _written(name: str, values: ca.Function, column: ca.Function, layout: Layout) -> Written:
    orders, room = column.nnz_out(0) // layout.n_x, max(values.nnz_out(2), 1)
    behind = layout.n_x * (1 + layout.n_s)  # rows before those of the guards
    lines = [
        f"%room = alloca [{room} x double], align 64",
        f"%handed = getelementptr [{room} x double], [{room} x double]* %room, i64 0, i64 0",
        f"%others = getelementptr double, double* %c, i64 {behind * orders}",
        f"call void @{name}.values(double* %y, double* %aux, double* %c, double* %others, double* %handed)",
    ]
    texts, declared = [definition(values, f"{name}.values")], set()
    for first, count, lanes in layout.chunks:
        part = _Chunk(column, layout, first, count, lanes)
        texts.append(part.text(f"{name}.columns_{first}"))
        declared |= part.declared
        lines.append(f"call void @{name}.columns_{first}(double* %y, double* %aux, double* %handed, double* %c)")
    head = f"define void @{name}(double* noalias %y, double* noalias %aux, double* noalias %c) nounwind {{"
    return Written(name, "\n".join([*texts, head, *lines, "ret void", "}"]), tuple(sorted(declared)))


class _Chunk:
    """Writer of the recurrence of some columns; the value of an instruction is named by its index."""

    def __init__(self, column: ca.Function, layout: Layout, first: int, count: int, lanes: int) -> None:
        self._f, self._layout, self._first, self._count, self._lanes = column, layout, first, count, lanes
        self._given = Instructions.of(column, cut=False)
        self._type = f"<{lanes} x double>" if lanes > 1 else "double"
        self._orders = column.nnz_out(0) // layout.n_x
        self._lines: list[str] = []
        self._known: dict[int, str] = {}
        kind = f"v{lanes}f64" if lanes > 1 else "f64"
        self._fma = f"@llvm.fma.{kind}"
        self.declared = {f"declare {self._type} {self._fma}({', '.join(3 * [self._type])})"} if lanes > 1 else set()

    def text(self, name: str) -> str:
        """Return the definition of the function ``(y, aux, handed, c)``."""
        within = {self._given.sources[k][j] for k, j in self._given.fused.items()}
        for k, op in enumerate(self._given.ops):
            if op == ca.OP_OUTPUT:
                self._output(k)
            elif op not in (ca.OP_INPUT, ca.OP_CONST, ca.OP_ASSIGN, ca.OP_LIFT) and k not in within:
                self._known[k] = self._fused(k) if k in self._given.fused else self._operation(k, op)
        names = ", ".join(f"double* noalias nocapture %{e}" for e in ("y", "aux", "handed", "c"))
        return "\n".join([f"define internal void @{name}({names}) nounwind {{", *self._lines, "ret void", "}"])

    def _fused(self, k: int) -> str:
        j = self._given.fused[k]
        a, b = (self._value(s) for s in self._given.factors(self._given.sources[k][j]))
        c, t = self._value(self._given.sources[k][1 - j]), self._type
        if self._given.ops[k] == ca.OP_SUB:
            self._lines.append(f"%n{k} = fneg {t} {b if j == 1 else c}")
            b, c = (f"%n{k}", c) if j == 1 else (b, f"%n{k}")
        self._lines.append(f"%r{k} = call {t} {self._fma}({t} {a}, {t} {b}, {t} {c})")
        return f"%r{k}"

    def _operation(self, k: int, op: int) -> str:
        v = [self._value(s) for s in self._given.sources[k]]
        if op == ca.OP_NEG:
            self._lines.append(f"%r{k} = fneg {self._type} {v[0]}")
        elif op in ARITHMETIC or op in (ca.OP_TWICE, ca.OP_SQ):
            name = ARITHMETIC.get(op, "fadd" if op == ca.OP_TWICE else "fmul")
            self._lines.append(f"%r{k} = {name} {self._type} {v[0]}, {v[-1]}")
        else:
            raise SceneError(f"CasADi operation number {op} is not one of a linear recurrence")
        return f"%r{k}"

    def _value(self, k: int) -> str:
        """Return the name of a value in all lanes, loaded at its first use."""
        if k not in self._known:
            op = self._given.ops[k]
            if op == ca.OP_CONST:
                self._known[k] = self._same(literal(self._f.instruction_constant(k)))
            else:
                self._known[k] = self._input(k, *self._f.instruction_input(k))
        return self._known[k]

    def _input(self, k: int, argument: int, element: int) -> str:
        n_x, shared = self._layout.n_x, self._f.nnz_in(1)
        if argument == 0:  # lanes without a column repeat the last one
            columns = [self._first + min(lane, self._count - 1) for lane in range(self._lanes)]
            return self._gathered(
                k, [f"%v{k}_{n}" for n in range(self._lanes)], [n_x * (1 + s) + element for s in columns]
            )
        if argument < 3:
            array = ("%handed", "%aux")[argument - 1]
            self._load(f"%v{k}", "double", array, element)
            return self._splat(k, f"%v{k}")
        place = shared + element * self._layout.room_of_entry + self._first
        self._load(f"%r{k}", self._type, "%handed", place)
        return f"%r{k}"

    def _gathered(self, k: int, names: list[str], places: list[int]) -> str:
        for name, place in zip(names, places, strict=True):
            self._load(name, "double", "%y", place)
        if self._lanes == 1:
            return names[0]
        vector = "undef"
        for n, name in enumerate(names):
            self._lines.append(f"%g{k}_{n} = insertelement {self._type} {vector}, double {name}, i64 {n}")
            vector = f"%g{k}_{n}"
        return vector

    def _load(self, name: str, kind: str, array: str, place: int) -> None:
        self._lines.append(f"{name}_at = getelementptr double, double* {array}, i64 {place}")
        address = f"{name}_at"
        if kind != "double":
            self._lines.append(f"{name}_to = bitcast double* {address} to {kind}*")
            address = f"{name}_to"
        self._lines.append(f"{name} = load {kind}, {kind}* {address}, align 8")

    def _splat(self, k: int, name: str) -> str:
        if self._lanes == 1:
            return name
        self._lines.append(f"%g{k} = insertelement {self._type} undef, double {name}, i64 0")
        self._lines.append(
            f"%r{k} = shufflevector {self._type} %g{k}, {self._type} undef, <{self._lanes} x i32> zeroinitializer"
        )
        return f"%r{k}"

    def _same(self, number: str) -> str:
        return number if self._lanes == 1 else "<" + ", ".join(self._lanes * [f"double {number}"]) + ">"

    def _output(self, k: int) -> None:
        group, element = self._f.instruction_output(k)
        value = self._value(self._given.sources[k][0])
        row, order = divmod(element, self._orders)
        n_x, n_s = self._layout.n_x, self._layout.n_s
        for lane in range(self._count):
            s = self._first + lane
            r = n_x * (1 + s) + row if group == 0 else n_x * (1 + n_s) + self._layout.between + row * n_s + s
            name = value
            if self._lanes > 1:
                name = f"%e{k}_{lane}"
                self._lines.append(f"{name} = extractelement {self._type} {value}, i64 {lane}")
            self._lines.append(f"%p{k}_{lane} = getelementptr double, double* %c, i64 {r * self._orders + order}")
            self._lines.append(f"store double {name}, double* %p{k}_{lane}")
