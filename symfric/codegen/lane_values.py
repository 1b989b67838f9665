"""Values of functions that do the same to several cases side by side; see `symfric.codegen.lane_ir`."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from symfric.codegen.lane_ir import LaneCode

REAL, FLAG, WHOLE = "d", "b", "i"  # kinds of values
Value = Any  # Lanes, or a number that is the same in all of them


class Lanes:
    """A value in every lane; plain numbers fold.

    Comparisons are ordered: false for NaN.
    """

    __slots__ = ("g", "kind", "name")

    def __init__(self, g: "LaneCode", name: str, kind: str):
        self.g, self.name, self.kind = g, name, kind

    def __add__(self, other: Value) -> Value:
        return self.g.add(self, other)

    def __radd__(self, other: Value) -> Value:
        return self.g.add(other, self)

    def __sub__(self, other: Value) -> Value:
        return self.g.sub(self, other)

    def __rsub__(self, other: Value) -> Value:
        return self.g.sub(other, self)

    def __mul__(self, other: Value) -> Value:
        return self.g.mul(self, other)

    def __rmul__(self, other: Value) -> Value:
        return self.g.mul(other, self)

    def __truediv__(self, other: Value) -> Value:
        return self.g.div(self, other)

    def __rtruediv__(self, other: Value) -> Value:
        return self.g.div(other, self)

    def __neg__(self) -> Value:
        return self.g.neg(self)

    def __abs__(self) -> Value:
        return self.g.abs(self)

    def __lt__(self, other: Value) -> Value:
        return self.g.ordered("lt", self, other)

    def __le__(self, other: Value) -> Value:
        return self.g.ordered("le", self, other)

    def __gt__(self, other: Value) -> Value:
        return self.g.ordered("gt", self, other)

    def __ge__(self, other: Value) -> Value:
        return self.g.ordered("ge", self, other)

    def __and__(self, other: Value) -> Value:
        return self.g.logic("and", self, other)

    __rand__ = __and__

    def __or__(self, other: Value) -> Value:
        return self.g.logic("or", self, other)

    __ror__ = __or__

    def __xor__(self, other: Value) -> Value:
        return self.g.logic("xor", self, other)

    def __invert__(self) -> Value:
        return self.g.logic("xor", self, True)

    def __lshift__(self, other: int) -> Value:
        return self.g.whole("shl", self, other)

    def __rshift__(self, other: int) -> Value:
        return self.g.whole("ashr", self, other)

    __hash__ = None  # type: ignore[assignment]


def kind_of(a: Value) -> str:
    """Return the kind of a value."""
    return a.kind if isinstance(a, Lanes) else FLAG if isinstance(a, bool) else REAL


def moves(a: Value) -> bool:
    """Whether a value is anything but a number that is known now."""
    return isinstance(a, Lanes)


def real(a: Value) -> Value:
    return a if isinstance(a, Lanes) else float(a)


def is_number(a: Value, x: float) -> bool:
    return not isinstance(a, Lanes) and a == x


def are_whole(*values: Value) -> bool:
    """Whether whole numbers are among the values."""
    return any(isinstance(a, Lanes) and a.kind == WHOLE for a in values)
