"""Numbers with names in the arrays of a run: the same for Python and for compiled code."""

import ast
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import symfric as sf
from symfric.codegen.array_table import ArraySet, Integers, Matrix, Reals, Scalars, Table
from symfric.codegen.numba_types import compiled, opener
from symfric.solve.exact.oscillator.workspace import OscillatorArrays
from symfric.solve.exact.record.workspace import RecordArrays
from symfric.solve.loop.run_arrays import Counts, RunArrays
from symfric.solve.loop.workspace import LoopArrays


class Tally(Scalars, kind=int):
    first: int
    second: int


class More(Tally, kind=int):
    third: int


class Lengths(Scalars):
    long: float
    short: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Some(ArraySet):
    table: Matrix
    tally: More
    lengths: Lengths


_at = opener(Some)


@compiled(from_python=True)
def turn(address):
    w = _at(address)
    w.tally.third += w.tally.first * 2
    w.tally.second = 7
    w.lengths.short = w.lengths.long / w.tally.second + w.table[1, 0]
    w.lengths.long = w.tally.third
    return w.lengths.short


def test_both_sides_read_and_write_the_same_numbers():
    work = Some(table=np.array([[1.0, 2.0], [3.0, 4.0]]), tally=More.zeros(), lengths=Lengths.zeros())
    work.tally.first, work.tally.third, work.lengths.long = 5, 1, 3.5
    assert turn(Table(work).address) == 3.5
    assert work.tally.tolist() == [5, 7, 11]
    assert (work.lengths.long, work.lengths.short) == (11.0, 3.5)
    copied = work.tally.copy()
    copied.first = 0
    assert (work.tally.first, copied.third, type(copied)) == (5, 11, More)
    work.tally.setflags(write=False)
    with pytest.raises(ValueError, match="read-only"):
        work.tally.first = 1


@dataclass(frozen=True, eq=False, kw_only=True)
class Inner(ArraySet):
    flags: Integers
    sizes: Reals


@dataclass(frozen=True, eq=False, kw_only=True)
class Outer(ArraySet):
    before: Reals
    inner: Inner
    after: Matrix


_outer_at = opener(Outer)


@compiled
def largest_of(inner):
    return max(inner.sizes[0], inner.sizes[1])


@compiled(from_python=True)
def mark(address):
    w = _outer_at(address)
    w.inner.flags[w.inner.flags.size - 1] = 4
    w.after[1, 0] = largest_of(w.inner) + w.before[0]
    return w.inner.sizes.size


def test_a_record_of_arrays_is_part_of_the_table():
    work = Outer(before=np.ones(1), inner=Inner.zeros(flags=3, sizes=2), after=np.zeros((2, 2)))
    work.inner.sizes[:] = 2.0, 5.0
    assert mark(Table(work).address) == 2
    assert (work.inner.flags.tolist(), work.after[1, 0]) == ([0, 0, 4], 6.0)
    assert [name for name, _ in work.items()] == ["before", "inner.flags", "inner.sizes", "after"]
    copied = work.copy(shared={"after"})
    assert copied.after is work.after
    assert copied.inner.sizes is not work.inner.sizes


def test_the_arrays_of_every_loop_begin_with_those_that_others_read():
    common = RunArrays.names()
    for arrays in (LoopArrays, OscillatorArrays, RecordArrays):
        assert arrays.names()[: len(common)] == common
    assert Counts.names[:6] == ("steps", "events", "kinks", "grazes", "kept_steps", "kept_events")  # what a run tells


@pytest.mark.parametrize("field", ["counts", "clock", "limits"])
def test_no_number_of_a_run_is_read_by_its_place(field):
    for path in (Path(sf.__file__).parent / "solve").rglob("*.py"):
        text = path.read_text()
        for node in ast.walk(ast.parse(text)) if f".{field}[" in text else ():
            if isinstance(node, ast.Subscript) and getattr(node.value, "attr", "") == field:
                assert isinstance(getattr(node.slice, "value", None), str), f"{path}:{node.lineno}"
