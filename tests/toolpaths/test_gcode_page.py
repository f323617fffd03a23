"""The examples of docs/gcode.md do what the page says."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.toolpaths.test_gcode_filter import program_of
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath, write_program
from toolpaths.frame import Frame
from toolpaths.languages.gcode.filter import rewrite
from toolpaths.rotation import rotation_of_axis
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import CUT
from toolpaths.writing.program import Program

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "gcode.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+) ?([^\n]*)\n(.*?)^```$", PAGE, re.M | re.S)


def blocks(language: str, what: str = "") -> list[tuple[str, str]]:
    return [(said, text) for lang, said, text in BLOCKS if lang == language and said.startswith(what)]


def test_every_block_is_one_that_is_tested() -> None:
    kinds = [f"{lang} {said.split(' ')[0]}".strip() for lang, said, _ in BLOCKS]
    assert kinds.count("nc refused") == 6 and set(kinds) == {
        "nc reads", "nc refused", "nc written", "python", "text", "diff filtered",
    }  # fmt: skip


def test_what_is_read(tmp_path: Path) -> None:
    ((said, text),) = blocks("nc", "reads")
    file = tmp_path / "a.nc"
    file.write_text(text)
    assert len(read_toolpath(file)) == int(said.split()[1])


@pytest.mark.parametrize(("said", "text"), blocks("nc", "refused"))
def test_what_is_refused(tmp_path: Path, said: str, text: str) -> None:
    line, why = re.fullmatch(r"refused in line (\d+): (.*)", said).groups()
    file = tmp_path / "a.nc"
    file.write_text(text)
    with pytest.raises(ReadError) as caught:
        read_toolpath(file)
    assert caught.value.line == int(line) and why in str(caught.value)


def test_the_machine(tmp_path: Path) -> None:
    ((_, code),), ((_, printed),) = blocks("python"), blocks("text")
    run = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path, capture_output=True, text=True, timeout=60, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert run.stdout == printed, run.stderr


def test_what_is_written(tmp_path: Path) -> None:
    ((_, text),) = blocks("nc", "written")
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
    ((_, text),) = blocks("diff", "filtered")
    lines = text.splitlines(keepends=True)
    before = "".join(line[1:] for line in lines if line[0] != "+")
    after = "".join(line[1:] for line in lines if line[0] != "-")
    file = tmp_path / "a.nc"
    file.write_text(before)
    path = read_toolpath(file)
    moved = path.position + np.where((path.kind == CUT)[:, None], [[1e-4, 0.0, 2e-5]], 0.0)
    assert rewrite(before.encode(), program_of(path, moved), path.row, file).text.decode() == after
