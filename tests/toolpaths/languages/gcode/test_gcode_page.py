"""docs/gcode.md: the examples of rotary axes, of what is written and of what is filtered."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

from tests.oracles.commanded import program_of
from toolpaths.files import read_toolpath, write_program
from toolpaths.frame import Frame
from toolpaths.languages.gcode.filter import rewrite
from toolpaths.rotation import rotation_of_axis
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import CUT
from toolpaths.writing.program import Program

ROOT = Path(__file__).parents[4]
PAGE = (ROOT / "docs" / "gcode.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+) ?([^\n]*)\n(.*?)^```$", PAGE, re.M | re.S)


def block(language: str, what: str = "") -> str:
    (text,) = (text for lang, info, text in BLOCKS if (lang, info) == (language, what))
    return text


def test_the_machine(tmp_path: Path) -> None:
    code, printed = block("python"), block("text")
    run = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path, capture_output=True, text=True, timeout=60, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert run.stdout == printed, run.stderr


def test_what_is_written(tmp_path: Path) -> None:
    text = block("nc", "slot")
    workobject = Frame(np.eye(3), np.array([0.8, -0.1, 0.2]))
    tilted = [0.1, 0.0, np.sqrt(0.99)]
    program = Program(
        name="slot", position=np.array([[0, 0, 20], [0, 0, -1], [60, 0, -1], [60, 0, 20]]) * 1e-3,
        rotation=rotation_of_axis(np.array([[0, 0, 1], [0, 0, 1], tilted, tilted])), joints=np.zeros((4, 6)),
        feed=np.array([np.nan, 0.005, 0.02, np.nan]), kind=np.array([0, 1, 1, 0], dtype=np.uint8),
        tool=np.ones(4, dtype=np.int32), line=np.arange(4, 8, dtype=np.int32),
        tools={1: ToolFrame("spindle", Frame(np.eye(3), np.array([0, 0, 0.15])))},
        workobject=workobject, rapid_speed=0.5,
        exact=np.array([False, False, True, False]), comments=((1, "S8000 M3"),), robot="a robot", source="slot.cls",
    )  # fmt: skip
    write_program(program, tmp_path / "a.nc")
    assert (tmp_path / "a.nc").read_text() == text


def test_what_is_filtered(tmp_path: Path) -> None:
    text = block("diff", "lifted")
    lines = text.splitlines(keepends=True)
    before = "".join(line[1:] for line in lines if line[0] != "+")
    after = "".join(line[1:] for line in lines if line[0] != "-")
    file = tmp_path / "a.nc"
    file.write_text(before)
    path = read_toolpath(file)
    moved = path.position + np.where((path.kind == CUT)[:, None], [[1e-4, 0.0, 2e-5]], 0.0)
    assert rewrite(before.encode(), program_of(path, moved), path.row, file).text.decode() == after
