"""numba options and types of the compiled functions; see `symfric.codegen.array_table` for their arrays."""

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, get_type_hints, overload

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core.cgutils import alloca_once_value, for_range, get_or_insert_function
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    lower_setattr_generic,
    models,
    register_jitable,
    register_model,
)
from numba.extending import overload as meaning
from numba.np.arrayobj import make_array, populate_array

from symfric.codegen.array_table import VECTOR, WIDTH, WORD, ArraySet, Scalars
from symfric.codegen.elementwise import bits_of, choose, larger, of_bits, smaller

_P = ParamSpec("_P")
_R = TypeVar("_R")
_A = TypeVar("_A", bound=ArraySet)

# fused multiply-add is allowed; infinities and NaN are kept
_FUSED = {"contract"}


@overload
def compiled(function: Callable[_P, _R], /) -> Callable[_P, _R]: ...


@overload
def compiled(
    *, inline: bool = False, fused: bool | None = None, ieee_division: bool = False, from_python: bool = False
) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]: ...


def compiled(
    function: Callable[_P, _R] | None = None,
    /,
    *,
    inline: bool = False,
    fused: bool | None = None,
    ieee_division: bool = False,
    from_python: bool = False,
) -> Callable[_P, _R] | Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Decorate a function that other compiled functions call, with arrays that it does not own.

    References to arrays are not counted, which would cost more than the function itself.

    Parameters
    ----------
    inline : bool
        For short functions, and for those that one other calls at every step. numba hands this down to all that the
        function calls unless they say otherwise, as those with False do: everything would become one function, which
        takes a minute to compile.
    fused : bool, optional
        Whether a product and a sum may become one instruction with one rounding; as in the caller unless given.
    ieee_division : bool
        A division by zero gives an infinity or NaN instead of an error.
    from_python : bool
        Callable from Python too, as tests do; without `inline`, the caller decides whether it is inlined.
    """
    options: dict[str, Any] = {"nogil": True, "_nrt": False}
    if not from_python:
        options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    if inline or not from_python:
        options["forceinline"] = inline
    if fused is not None:
        options["fastmath"] = _FUSED if fused else False
    if ieee_division:
        options["error_model"] = "numpy"

    def decorate(function: Callable[_P, _R]) -> Callable[_P, _R]:
        return njit(**options)(function)

    return decorate if function is None else decorate(function)


def shared(function: Callable[_P, _R], *, inline: bool = True, fused: bool = True) -> Callable[_P, _R]:
    """Let compiled code call a function of `symfric.codegen.elementwise`, which stays a function of Python.

    Parameters
    ----------
    function : callable
    inline, fused : bool
        As for `compiled`.
    """
    options = {"nogil": True, "_nrt": False, "forceinline": inline, "fastmath": _FUSED if fused else False}
    return register_jitable(**options)(function)


_INLINED: Any = {"_nrt": False, "forceinline": True}


@meaning(larger, jit_options=_INLINED, strict=False)
def _larger(a: types.Type, b: types.Type) -> Callable[..., Any]:
    return lambda a, b: max(a, b)


@meaning(smaller, jit_options=_INLINED, strict=False)
def _smaller(a: types.Type, b: types.Type) -> Callable[..., Any]:
    return lambda a, b: min(a, b)


@meaning(choose, jit_options=_INLINED, strict=False)
def _choose(condition: types.Type, a: types.Type, b: types.Type) -> Callable[..., Any]:
    return lambda condition, a, b: a if condition else b


@meaning(bits_of, jit_options=_INLINED, strict=False)
def _bits_of(x: types.Type) -> Callable[..., Any]:
    return lambda x: np.float64(x).view(np.int64)


@meaning(of_bits, jit_options=_INLINED, strict=False)
def _of_bits(n: types.Type) -> Callable[..., Any]:
    return lambda n: np.int64(n).view(np.float64)


def part(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Decorate a function that is inlined in its only caller."""
    return njit(inline="always")(function)


_KINDS = {float: types.float64, int: types.int64}


class NamedNumbers(types.Type):
    """The numba type of a `Scalars`: a pointer to its numbers."""

    def __init__(self, scalars: type[Scalars]):
        super().__init__(f"NamedNumbers({scalars.__module__}.{scalars.__qualname__})")
        self.number = _KINDS[scalars.kind]
        self.places = {name: place for place, name in enumerate(scalars.names)}


class Arrays(types.Type):
    """The numba type of an `ArraySet`: a pointer to its first row of the table.

    Attributes
    ----------
    fields : dict
        First row and type of every field, by name.
    rows : int
        Number of rows.
    """

    def __init__(self, record: type[ArraySet]):
        super().__init__(f"Arrays({record.__module__}.{record.__qualname__})")
        hints = get_type_hints(record, include_extras=True)
        self.fields: dict[str, tuple[int, Any]] = {}
        self.rows = 0
        for name in record.names():
            kind = _type_of(hints[name])
            self.fields[name] = self.rows, kind
            self.rows += kind.rows if isinstance(kind, Arrays) else 1


def _type_of(hint: Any) -> types.Type:
    if isinstance(hint, type) and issubclass(hint, ArraySet):
        return Arrays(hint)
    if isinstance(hint, type) and issubclass(hint, Scalars):
        return NamedNumbers(hint)
    ((kind, indices),) = hint.__metadata__
    return types.Array(_KINDS[kind], indices, "C")


class _Pointer(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: types.Type):
        super().__init__(manager, kind, ir.IntType(64).as_pointer())


register_model(Arrays)(_Pointer)
register_model(NamedNumbers)(_Pointer)


@infer_getattr
class _Fields(AttributeTemplate):
    key = Arrays

    def generic_resolve(self, value: Any, attr: str) -> types.Type | None:  # type: ignore[override]  # numba: "not implemented" until a class does
        return value.fields[attr][1] if attr in value.fields else None


@infer_getattr
class _Numbers(AttributeTemplate):
    key = NamedNumbers

    def generic_resolve(self, value: Any, attr: str) -> types.Type | None:  # type: ignore[override]
        return value.number if attr in value.places else None


@lower_getattr_generic(Arrays)
def _field(context: Any, builder: Any, kind: Arrays, table: Any, name: str) -> Any:
    """Generate code that builds an array from its row of the table, constant while compiled code runs."""
    row, array = kind.fields[name]
    if isinstance(array, Arrays):
        return builder.gep(table, [ir.Constant(ir.IntType(64), WIDTH * row)])
    constant = builder.module.add_metadata([])

    def entry(column: int) -> Any:
        place = builder.gep(table, [ir.Constant(ir.IntType(64), WIDTH * row + column)])
        number = builder.load(place)
        number.set_metadata("invariant.load", constant)
        return number

    if isinstance(array, NamedNumbers):
        return builder.inttoptr(entry(0), ir.IntType(64).as_pointer())
    made = make_array(array)(context, builder)
    shape = [entry(1 + axis) for axis in range(array.ndim)]
    word = ir.Constant(ir.IntType(64), WORD)
    strides = [word]
    for length in shape[:0:-1]:
        strides.insert(0, builder.mul(strides[0], length, flags=["nsw"]))
    data = builder.inttoptr(entry(0), made.data.type)
    populate_array(made, data=data, shape=shape, strides=strides, itemsize=word, meminfo=None)
    return made._getvalue()


def _place(context: Any, builder: Any, kind: NamedNumbers, numbers: Any, name: str) -> Any:
    """Generate code for the address of a number."""
    start = builder.bitcast(numbers, context.get_value_type(kind.number).as_pointer())
    return builder.gep(start, [ir.Constant(ir.IntType(64), kind.places[name])])


@lower_getattr_generic(NamedNumbers)
def _read(context: Any, builder: Any, kind: NamedNumbers, numbers: Any, name: str) -> Any:
    return builder.load(_place(context, builder, kind, numbers, name))


@lower_setattr_generic(NamedNumbers)
def _write(context: Any, builder: Any, signature: Any, args: Any, name: str) -> None:
    kind, given = signature.args
    value = context.cast(builder, args[1], given, kind.number)
    builder.store(value, _place(context, builder, kind, args[0], name))


def opener(record: type[_A]) -> Callable[[int], _A]:
    """Return the compiled function from the address of a table to the arrays of its `ArraySet`."""
    kind = Arrays(record)

    @inlined
    def at_addresses(typing_context: Any, address: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return builder.inttoptr(args[0], ir.IntType(64).as_pointer())

        return kind(address), generate

    return at_addresses


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return numba's `intrinsic` with the type of the function that compiled code calls, without typing context."""
    return intrinsic(function)


@inlined
def call_code(typing_context: Any, address: Any, a: Any, b: Any, out: Any) -> Any:
    """Call machine code ``void f(double*, double*, double*)`` at an integer address, from numba."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        pointer = ir.DoubleType().as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [pointer] * 3)
        target = builder.inttoptr(args[0], kind.as_pointer())
        builder.call(target, [builder.inttoptr(x, pointer) for x in args[1:]])
        return context.get_dummy_value()

    return types.void(types.int64, types.uintp, types.uintp, types.uintp), generate


@inlined
def signs_of_sums(typing_context: Any, table: Any, factors: Any, rows: Any, blocks: Any, sums: Any) -> Any:
    """Compute ``sums[j] = sum(factors[k] table[k, j])`` over all rows; bit j of the result says that it is negative.

    The arguments are addresses, that of the table and of the sums each of `VECTOR` times `blocks` columns. The table is
    zero where k > j. Each product is added with one rounding, in the order of the rows.
    """

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        word, double = ir.IntType(64), ir.DoubleType()
        vector, number = ir.VectorType(double, VECTOR), lambda n: ir.Constant(word, n)
        fma = get_or_insert_function(builder.module, ir.FunctionType(vector, [vector] * 3), f"llvm.fma.v{VECTOR}f64")
        table, sums = (builder.inttoptr(args[k], vector.as_pointer()) for k in (0, 4))
        factors, (rows, blocks) = builder.inttoptr(args[1], double.as_pointer()), args[2:4]
        zero, found = ir.Constant(vector, [0.0] * VECTOR), alloca_once_value(builder, number(0))
        total = alloca_once_value(builder, zero)
        with for_range(builder, blocks) as block:
            builder.store(zero, total)
            end = builder.mul(builder.add(block.index, number(1)), number(VECTOR))
            some = builder.select(builder.icmp_signed("<", end, rows), end, rows)
            with for_range(builder, some) as row:
                place = builder.add(builder.mul(row.index, blocks), block.index)
                column = builder.load(builder.gep(table, [place]), align=WORD)
                one = builder.insert_element(
                    ir.Constant(vector, ir.Undefined), builder.load(builder.gep(factors, [row.index])), number(0)
                )
                same = ir.Constant(ir.VectorType(ir.IntType(32), VECTOR), [0] * VECTOR)
                factor = builder.shuffle_vector(one, ir.Constant(vector, ir.Undefined), same)
                builder.store(builder.call(fma, [column, factor, builder.load(total)]), total)
            last = builder.load(total)
            builder.store(last, builder.gep(sums, [block.index]), align=WORD)
            bits = builder.bitcast(builder.fcmp_ordered("<", last, zero), ir.IntType(VECTOR))
            own = builder.shl(builder.zext(bits, word), builder.mul(block.index, number(VECTOR)))
            builder.store(builder.or_(builder.load(found), own), found)
        return builder.load(found)

    return types.int64(types.uintp, types.uintp, types.int64, types.int64, types.uintp), generate
