"""Every public function from four threads at once gives the serial answer, to the last bit."""

import inspect
import random
import types

import matplotlib
import matplotlib.pyplot as plt
import pytest

import symfric as sf
from tests.longer import longer
from tests.threads.calls import CALLS, SLOW
from tests.threads.together import THREADS, difference, together

OTHERWISE = {  # public functions that are tried elsewhere or read files
    "export.write_c": "test_c_code",
    "export.write_fmu": "test_c_code",
    "motions.read_at2": "test_files_of_motions",
    "motions.read_text": "test_files_of_motions",
    "read": "test_starting",
    "explore": "test_explore",
    "keep_when_interrupted": "test_progress",
    "show_progress": "test_progress",
    "structures.read": "test_faults",
    "structures.write": "test_faults",
}
VARIANTS = 2


def public_functions(module, prefix="", seen=frozenset()):
    """Yield the names of the functions that a user reaches from the package."""
    said = hasattr(module, "__all__")  # else what the module defines itself
    for name in module.__all__ if said else [n for n in dir(module) if not n.startswith("_")]:
        value = getattr(module, name)
        if isinstance(value, types.ModuleType) and said and value not in seen:
            yield from public_functions(value, f"{prefix}{name}.", seen | {value})
        elif inspect.isfunction(value) and (said or value.__module__ == module.__name__):
            yield prefix + name


def test_no_public_function_is_forgotten():
    known = {name.removeprefix("theory.") for name in (*CALLS, *SLOW, *OTHERWISE)}
    found = {name.removeprefix("theory.") for name in public_functions(sf)}
    assert found - known == set()
    assert len(found) > 100


def compare(calls, rounds, seed=0, share=1.0):
    """Run all calls, or a random share of them, from every thread in an order of its own; return what differs."""
    matplotlib.use("agg")
    with matplotlib.rc_context({"figure.max_open_warning": 0}):  # none is closed before all calls have ended
        serial = {(name, k): call(k) for name, call in calls.items() for k in range(VARIANTS)}

        def work(thread):
            rng, found = random.Random(f"{seed} {thread}"), []
            for _ in range(rounds):
                order = list(serial)
                rng.shuffle(order)
                for name, k in order[: round(share * len(order))]:
                    found.append(difference(serial[name, k], calls[name](k), f"{name}({k})"))
            return [f for f in found if f]

        found = [f for part in together(work) for f in part]
    plt.close("all")
    return found


@pytest.mark.parametrize("part", longer(range(8), range(1, 8)))
def test_all_at_once(part):
    assert compare(dict(list(CALLS.items())[part::8]), rounds=1, share=0.3) == []


@pytest.mark.long(beside="test_all_at_once")
def test_slow_ones_at_once():
    assert compare(SLOW, rounds=1) == []


@pytest.mark.long(beside="test_all_at_once")
@pytest.mark.parametrize("name", [*CALLS, *SLOW])
def test_one_function_often(name):
    rounds = 5 if name in SLOW else 125  # 1000 calls: a race of one in a thousand shows in two of three
    assert compare({name: {**CALLS, **SLOW}[name]}, rounds) == []


@pytest.mark.long(beside="test_all_at_once")
def test_all_at_once_often():
    assert compare(CALLS, rounds=50, seed=1) == []


def test_files_of_motions(tmp_path):
    columns, record = tmp_path / "a.txt", tmp_path / "a.at2"
    columns.write_text("\n".join(f"{0.01 * k} {k % 7}" for k in range(200)))
    head = "PEER\nsomewhere\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS=   10, DT=   .0100 SEC\n"
    record.write_text(head + " ".join(f"{0.1 * k:.2f}" for k in range(10)))

    def read(_):
        both = sf.motions.read_text(columns, unit="m/s^2"), sf.motions.read_at2(record)
        return [m.samples for m in both]

    serial = read(0)
    assert [difference(serial, found) for found in together(read)] == [""] * THREADS
