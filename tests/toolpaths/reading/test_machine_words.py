"""Spindle and commands of SINUMERIK and Klartext, and where a file starts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.machine import Machine
from toolpaths.toolpath import RAPID, Toolpath

SIEMENS = (
    "G710 G90\nT5\nM6\nG0 X0 Y0 Z5\nS3000 M3 M8\nF600\nG1 X1\nS4000\nX2\nM5\nG0 X3\nS2=70 M2=3\nM4\nG1 X4\n"
    "G4 F0.5\nM0\nT7\nM6\nG0 X5\nM30\n"
)
KLARTEXT = (
    "BEGIN PGM A MM\nTOOL CALL 5 Z S3000\nL X+0 Y+0 Z+5 FMAX\nL M13\nL F600\nL X+1\nTOOL CALL Z S4000\nL X+2\nM5\n"
    "L X+3 FMAX\nM4\nL X+4\nSTOP\nTOOL CALL 7 Z S4000\nL X+5 FMAX\nEND PGM A MM\n"
)


def read(folder: Path, name: str, text: str, machine: Machine | None = None) -> Toolpath:
    (folder / name).write_text(text)
    return read_toolpath(folder / name, machine=machine)


@pytest.mark.parametrize(("name", "text"), [("part.mpf", SIEMENS), ("part.h", KLARTEXT)])
def test_speed_and_sense_of_the_spindle(tmp_path: Path, name: str, text: str) -> None:
    path = read(tmp_path, name, text)
    np.testing.assert_allclose(path.spindle[1:] * 60 / (2 * np.pi), [3000, 4000, 0, 4000, 0], rtol=1e-12)
    assert path.sense.tolist() == [0, 1, 1, 1, -1, -1]


def test_commands(tmp_path: Path) -> None:
    path = read(tmp_path, "part.mpf", SIEMENS)
    found = [(c.word, dict(c.values)) for e in path.events for c in e.commands]
    assert found == [
        ("T", {"T": 5.0}), ("M6", {"T": 5.0}), ("M3", {"S": 3000.0}), ("M8", {}), ("M3", {"S": 4000.0}), ("M5", {}),
        ("M4", {"S": 4000.0}), ("G4", {"P": 0.5}), ("M0", {}), ("T", {"T": 7.0}), ("M6", {"T": 7.0}),
    ]  # fmt: skip
    path = read(tmp_path, "part.h", KLARTEXT)
    found = [(c.word, dict(c.values)) for e in path.events for c in e.commands]
    assert found == [
        ("M6", {"T": 5.0}), ("M3", {"S": 3000.0}), ("M8", {}), ("M3", {"S": 4000.0}), ("M5", {}), ("M4", {"S": 4000.0}),
        ("M0", {}), ("M6", {"T": 7.0}),
    ]  # fmt: skip


CUTS = {
    "part.mpf": "G710 G90\nF600\nG1 X10\nM30\n",
    "part.h": "BEGIN PGM A MM\nL F600\nL X+10\nEND PGM A MM\n",
    "arc.mpf": "G710 G90\nF600\nG2 X10 I5\nM30\n",
}


@pytest.mark.parametrize("name", CUTS)
def test_a_file_that_begins_with_a_cut(tmp_path: Path, name: str) -> None:
    """Refused, unless the cell says where the tool starts; then that is its first pose."""
    with pytest.raises(ReadError):
        read(tmp_path, name, CUTS[name])
    path = read(tmp_path, name, CUTS[name], Machine(start=(0.0, 0.002, 0.003)))
    assert path.kind[0] == RAPID and path.position[0].tolist() == [0.0, 0.002, 0.003]
    assert path.position[-1] == pytest.approx([0.01, 0.002, 0.003])
