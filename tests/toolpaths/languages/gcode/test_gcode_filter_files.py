"""G-code filtered in place: real files and random programs."""

from __future__ import annotations

import random
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.commanded import program_of
from tests.oracles.filtered_gcode import corrected, cuts, filtered, read
from tests.oracles.linuxcnc import PRINTED_INCH, check, reference
from tests.oracles.random_gcode import RandomProgram
from toolpaths.languages.gcode.filter import rewrite
from toolpaths.toolpath import CUT, Toolpath
from toolpaths.writing.marker import MARKER
from toolpaths.writing.program import Program


@pytest.mark.parametrize("seed", range(30))
def test_random_programs_with_shifts(seed: int, tmp_path: Path) -> None:
    """G52, G92 and its kin, inch and mm, G90 and G91: cuts are where they have to be; rs274 reads the same."""
    text = RandomProgram(seed, 60).text
    new, program, _ = filtered(text, 2e-4)
    again = read(new.text)
    np.testing.assert_allclose(cuts_without_arcs(again, program), 0, atol=1.1e-3)
    if shutil.which("rs274"):
        file = tmp_path / "new.ngc"
        file.write_bytes(new.text)
        check(again, reference(file), PRINTED_INCH if "G20" in text.upper() else 1e-4)


@pytest.mark.parametrize(
    "name",
    [
        "gcode_fusion/1110_wall_265bit.nc", "gcode_fusion/1121_btn8copies_20bit.nc", "gcode_cncjs/tball.gcode",
        "gcode_cncjs/tball-pocket.gcode", "gcode_cncjs/jsdc.gcode",
    ],
)  # fmt: skip
def test_real_files(shared: Path, name: str) -> None:
    data = (shared / "data/cam" / name).read_bytes()
    path = read(data)
    same = rewrite(data, program_of(path), path.row, Path("a.nc"))
    lines = same.text.split(b"\n")
    at = next(k for k, line in enumerate(lines) if MARKER.encode() in line)
    assert b"\n".join(lines[:at] + lines[at + 1 :]) == data and at < 4
    program = program_of(path, corrected(path, 1e-3))
    new = rewrite(data, program, path.row, Path("a.nc"))
    again = read(new.text)
    assert len(again) == len(path)
    np.testing.assert_allclose(cuts(again), cuts(program), atol=6e-4)
    kept = [t for t in new.text.split(b"\n") if not re.search(rb"[XYZ]", re.sub(rb"\(.*\)", b"", t))]
    assert [t for t in kept if MARKER.encode() not in t] == [
        t for t in data.split(b"\n") if not re.search(rb"[XYZ]", re.sub(rb"\(.*\)", b"", t))
    ]


@pytest.mark.parametrize("seed", range(25))
def test_random_programs(seed: int, tmp_path: Path) -> None:
    """Cuts are where they have to be, rapids within the correction of where they were; rs274 reads the same."""
    text = RandomProgram(seed, 60, shifts=False).text
    new, program, _ = filtered(text, 2e-4)
    again = read(new.text)
    np.testing.assert_allclose(cuts_without_arcs(again, program), 0, atol=1.1e-3)
    if shutil.which("rs274") and random.Random(seed).random() < 0.2:
        file = tmp_path / "new.ngc"
        file.write_bytes(new.text)
        np.testing.assert_allclose(reference(file).ends[-1], again.position[-1] * 1e3, atol=6e-3)


def cuts_without_arcs(again: Toolpath, program: Program) -> np.ndarray:
    """Distance, mm, of every commanded cut to the nearest way of the file that was read again, in order."""
    ways = again.position * 1e3
    at, out = 1, []
    for p in program.position[program.kind == CUT] * 1e3:
        window = slice(max(at - 1, 0), min(at + 400, len(ways)))
        distance = np.linalg.norm(ways[window] - p, axis=1)
        best = int(np.argmin(distance))
        out.append(distance[best])
        if distance[best] < 2e-3:
            at = window.start + int(np.flatnonzero(distance < 2e-3)[0])
    return np.array(out)
