"""G-code that people and disks have damaged: clear refusals only, in bounded time and memory."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.contracts.languages.gcode import MACHINE, WORDS
from tests.oracles.patience import not_hanging
from tests.oracles.random_gcode import RandomProgram
from toolpaths.errors import ReadError
from toolpaths.languages.gcode import reader as gcode
from toolpaths.machine import Machine

SEEDS = [RandomProgram(seed, 12).text for seed in range(30)]
KEEP = [HealthCheck.function_scoped_fixture, HealthCheck.too_slow]


def attempt(folder: Path, data: bytes, machine: Machine | None = None) -> bool:
    file = folder / "part.nc"
    file.write_bytes(data)
    try:
        path = gcode.read(file, "part.nc", 1e-4, machine)
    except ReadError as refusal:
        assert str(refusal).startswith("part.nc") and len(str(refusal)) < 500
        return False
    assert len(path) and np.isfinite(path.position).all() and (np.diff(path.row) > 0).all()
    np.testing.assert_allclose(np.linalg.norm(path.axis, axis=1), 1, atol=1e-12)
    assert (path.feed[path.kind == 1] > 0).all()
    assert all(0 <= e.pose <= len(path) for e in path.events)
    assert (np.diff(path.line) >= 0).all() and path.line[-1] <= data.count(b"\n") + data.count(b"\r") + 1
    return True


@settings(max_examples=100, deadline=None, suppress_health_check=KEEP)
@given(data=st.data())
def test_damaged_programs(tmp_path: Path, data: st.DataObject) -> None:
    raw = bytearray(data.draw(st.sampled_from(SEEDS)).encode())
    for _ in range(data.draw(st.integers(1, 6))):
        at = data.draw(st.integers(0, len(raw) - 1))
        kind = data.draw(st.integers(0, 3))
        if kind == 0:
            del raw[at : at + data.draw(st.integers(1, 30))]
        elif kind == 1:
            raw[at:at] = data.draw(st.sampled_from(WORDS)).encode()
        elif kind == 2:
            raw[at] = data.draw(st.sampled_from(b"0123456789.-+XYZGIJKRFMPQ \n\r;()%\0\x07\xff"))
        else:
            raw[at:at] = raw[at : at + data.draw(st.integers(1, 60))]
        if not raw:
            return
    attempt(tmp_path, bytes(raw))


@settings(max_examples=100, deadline=None, suppress_health_check=KEEP)
@given(blocks=st.lists(st.lists(st.sampled_from(WORDS), max_size=6), max_size=25), turning=st.booleans())
def test_words_in_any_order(tmp_path: Path, blocks: list[list[str]], turning: bool) -> None:
    text = "G21 G90 F100\nG0 X0 Y0 Z5 " + ("B0 C0\n" if turning else "\n")
    text += "\n".join(" ".join(block) for block in blocks) + "\nM30\n"
    attempt(tmp_path, text.encode("latin-1"), MACHINE if turning else None)


def test_the_undamaged_ones_are_read(tmp_path: Path) -> None:
    assert all(attempt(tmp_path, text.encode()) for text in SEEDS)


HEAD = "G21 F100\nG0 X0 Y0 Z0\n"
HARD = {
    "blanks": HEAD + "X1" + " " * 200_000 + "\nM30\n",
    "blanks between": HEAD + ("X" + " " * 100_000) * 2 + "1\nM30\n",
    "brackets": HEAD + "(" * 200_000 + "\nM30\n",
    "comments": HEAD + "()" * 100_000 + "X1\nM30\n",
    "digits": HEAD + "X" + "1" * 200_000 + "\nM30\n",
    "zeros": HEAD + "M" + "0" * 200_000 + "7\nX1\nM30\n",
    "O": HEAD + "O" + "1" * 200_000 + " x\nM30\n",
    "letters": HEAD + "G" * 200_000 + "\nM30\n",
    "numbers of G": HEAD + "".join(f"G1.{k:05d}\n" for k in range(20_000)) + "M30\n",
    "pecks": HEAD + "G83 Z-900 R1 Q0.0001\nM30\n",
    "turns": HEAD + "G2 I900000 P9999999\nM30\n",
    "repeats": HEAD + "G91 G81 X1 Z-1 R1 L100000000\nM30\n",
    "rotary": "G21 F100\nG0 X0 Y0 Z0 B0 C0\nG1 C99999999 B-99999999\nM30\n",
}


@pytest.mark.parametrize("name", HARD)
def test_no_hang_and_little_memory(tmp_path: Path, name: str) -> None:
    tracemalloc.start()
    try:
        with not_hanging():  # what is quadratic takes minutes
            attempt(tmp_path, HARD[name].encode(), MACHINE)
        used = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert used < 100e6
