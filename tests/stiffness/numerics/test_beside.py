"""Work beside: what comes back is what the work gives here, whatever becomes of the other process."""

from __future__ import annotations

import os
import threading
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.numerics.beside import FROM, beside, halves
from stiffness.numerics.cores import cores, left_with

needs_fork = pytest.mark.skipif(
    not hasattr(os, "memfd_create") or cores() < 2, reason="one core, or a system without fork and shared memory"
)

pytestmark = pytest.mark.usefixtures("may_fork")

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Path:
    angles: Floats


@needs_fork
def test_another_process_works_with_the_arrays_of_this_one_and_gives_its_own_back() -> None:
    path, (read, write) = _Path(np.arange(12.0).reshape(4, 3)), os.pipe()

    def work() -> tuple[int, Floats, Floats, _Path]:
        os.read(read, 1)
        return os.getpid(), path.angles[::-1] * 2, path.angles, path

    with beside(work, known=(path,), poses=FROM) as other:
        here = cores()
        os.write(write, b"!")
        process, doubled, same, whole = other.result()
    os.close(read)
    os.close(write)
    assert process != os.getpid()
    assert here == cores() - cores() // 2
    np.testing.assert_array_equal(doubled, path.angles[::-1] * 2)
    assert same is path.angles
    assert whole is path
    doubled[0, 0] = -1.0  # as of an array that was made here
    assert doubled[0, 0] == -1.0


@needs_fork
def test_cores_are_free_again_when_the_other_process_is_done() -> None:
    count = cores()
    with beside(os.getpid, known=(), poses=FROM) as other:
        while other.works:
            pass
        assert cores() == count
        assert other.result() not in (0, os.getpid())
    assert not other.works


@needs_fork
def test_a_value_that_stands_in_all_rows_stays_one() -> None:
    def work() -> tuple[Floats, int]:
        return np.broadcast_to(np.array([7.5]), (1000, 3)), os.getpid()

    with beside(work, known=(), poses=FROM) as other:
        values, process = other.result()
    assert process != os.getpid()
    assert values.shape == (1000, 3)
    assert values.strides == (0, 0)
    assert values[999, 2] == 7.5


@pytest.mark.parametrize("poses", [FROM - 1, FROM])
def test_what_is_raised_is_raised_here(poses: int) -> None:
    def work() -> int:
        raise ValueError(f"from {os.getpid()}")

    with beside(work, known=(), poses=poses) as other, pytest.raises(ValueError, match=f"from {os.getpid()}"):
        other.result()


def test_what_cannot_be_sent_or_dies_is_done_here() -> None:
    here = os.getpid()

    def dies() -> int:
        if os.getpid() != here:
            os.abort()
        return here

    with beside(lambda: lambda: here, known=(), poses=FROM) as unsent, beside(dies, known=(), poses=FROM) as dead:
        assert unsent.result()() == here
        assert dead.result() == here


@pytest.mark.parametrize("why", ["short", "one core", "a thread"])
def test_it_is_done_here_when_asked_for(why: str) -> None:
    done = list[int]()
    end = threading.Event()
    thread = threading.Thread(target=end.wait, name="of another")
    if why == "a thread":
        thread.start()
    try:
        with left_with(1 if why == "one core" else 8):
            poses = FROM - 1 if why == "short" else FROM
            with beside(lambda: done.append(os.getpid()), known=(), poses=poses) as other:
                assert done == []
                other.result()
    finally:
        end.set()
        if why == "a thread":
            thread.join()
    assert done == [os.getpid()]


@needs_fork
def test_what_is_not_asked_for_is_ended() -> None:
    with pytest.raises(KeyError), beside(threading.Event().wait, known=(), poses=FROM) as other:
        child = int(repr(other).split()[1].rstrip(")"))
        raise KeyError
    with pytest.raises(ProcessLookupError):
        os.kill(child, 0)


@needs_fork
def test_halves_are_done_by_two_even_where_another_process_works_and_stand_in_their_order() -> None:
    read, write = os.pipe()
    with beside(lambda: os.read(read, 1), known=(), poses=FROM) as other:
        found = halves(lambda k: (k * k, os.getpid()), range(2, 7), FROM)
        assert other.works
        os.write(write, b"!")
        assert other.result() == b"!"
    os.close(read)
    os.close(write)
    assert [square for square, _ in found] == [4, 9, 16, 25, 36]
    assert [process == os.getpid() for _, process in found] == [True, True, True, False, False]


@needs_fork
def test_a_half_that_fails_elsewhere_is_done_here() -> None:
    here = os.getpid()

    def work(k: int) -> int:
        if os.getpid() != here:
            os._exit(3)
        return k + 1

    assert halves(work, (5, 7, 11), FROM) == [6, 8, 12]
    with beside(lambda: work(1), known=(), poses=FROM) as other:
        assert other.found() is None
    with beside(lambda: 7, known=(), poses=FROM) as other:
        assert other.found() == 7
    with left_with(1):
        assert halves(lambda k: os.getpid(), (5, 7), FROM) == [here, here]
