"""G-code against LinuxCNC's interpreter (``rs274 -g``): every move, its kind and feed, and the arcs between."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from tests.oracles.linuxcnc import PRINTED_INCH, check, installed, reference, run
from tests.oracles.random_gcode import RandomProgram, joined
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.languages.table import LANGUAGES

pytestmark = installed
REAL = [
    "gcode_fusion/1110_wall_265bit.nc", "gcode_fusion/1121_btn8copies_20bit.nc", "gcode_cncjs/tball-pocket.gcode",

    "gcode_cncjs/tball.gcode",
]  # fmt: skip
ENDED = ["jsdc", "g2-arc", "circle-inch", "arc-xy-plane", "arc-xz-plane", "arc-yz-plane", "arc-ijk"]  # no M2 in these
#: The others: what the reader says of them; rs274 refuses them, too.
REFUSED = {
    "gcode_cncjs/Circle_Diamond_Square_Calibration.gcode": (624, "the radius is 29 mm at the start, 27.5862 mm"),
    "gcode_cncjs/full-circle-without-xyz.gcode": (1, "no units"),  # and a G2 in force for a line without a centre
    "gcode_cncjs/helical-thread-milling.gcode": (4, "Z-0.6533 in G91, but where Z starts is not known"),
    "gcode_cncjs/sample.gcode": (10, "3D printers"),
    "krl_waam/Hollow_Box_cleaned.gcode": (12, "3D printers"),
    "krl_waam/circle4_cleaned.gcode": (12, "3D printers"),
}  # fmt: skip


def test_every_real_file_is_compared_or_refused_by_both(shared: Path) -> None:
    cam = shared / "data/cam"
    files = {str(f.relative_to(cam)) for f in cam.rglob("*") if f.suffix in LANGUAGES["gcode"].reads}
    assert files == {*REAL, *(f"gcode_cncjs/{name}.gcode" for name in ENDED), *REFUSED}
    for name, (line, words) in REFUSED.items():
        with pytest.raises(ReadError, match=re.escape(words)) as caught:
            read_toolpath(cam / name)
        assert caught.value.line == line, name
        with pytest.raises(ReadError):
            run(cam / name)


@pytest.mark.parametrize("name", REAL)
def test_real_files_agree(shared: Path, name: str) -> None:
    file = shared / "data/cam" / name
    check(read_toolpath(file), reference(file), 1e-4)


@pytest.mark.parametrize("name", ENDED)
def test_unfinished_real_files_agree_once_they_end(shared: Path, tmp_path: Path, name: str) -> None:
    text = (shared / "data/cam/gcode_cncjs" / f"{name}.gcode").read_text()
    head = "" if "G21" in text or "G20" in text else "G21\nG0 X0 Y0 Z0\n"
    file = tmp_path / f"{name}.nc"
    file.write_text(f"{head}{text}\nM2\n")
    check(read_toolpath(file), reference(file), PRINTED_INCH if "inch" in name else 1e-4)


PROGRAMS = int(os.environ.get("RS274_PROGRAMS", "1000"))  # docs/gcode.md has the number of the longest run
PER_FILE, PER_TEST = 10, 100


@pytest.mark.parametrize("first", range(0, PROGRAMS, PER_TEST))
def test_random_modal_programs_agree(tmp_path: Path, first: int) -> None:
    agreed = 0
    for seed in range(first, min(first + PER_TEST, PROGRAMS), PER_FILE):
        text = joined(range(seed, min(seed + PER_FILE, PROGRAMS)))
        file = tmp_path / f"random{seed}.ngc"
        file.write_text(text)
        ref = reference(file)
        check(read_toolpath(file), ref, PRINTED_INCH if "G20" in text.upper() else 1e-4)
        agreed += len(ref.ends)
    assert agreed > 75 * min(PER_TEST, PROGRAMS - first)


@pytest.mark.parametrize("change", ["G2 as G3", "G91", "a lost line", "a digit", "a feed"])
def test_a_disagreement_is_seen(tmp_path: Path, change: str) -> None:
    """What the comparison is worth: the reader gets another file than LinuxCNC."""
    text = RandomProgram(9).text  # in mm
    at = text.index("\n", len(text) // 2)
    text = f"{text[:at]}\nG80\nG94 G90 G21 G17 G91.1\nF400\nG1 X3 Y4 Z5\nG2 X7 I2\nG1 X9 Y1\nM2\n"
    other = {
        "G2 as G3": text.replace("G2 X7 I2", "G3 X7 I2"), "G91": text.replace("G94 G90 G21", "G94 G91 G21"),
        "a lost line": text.replace("G1 X3 Y4 Z5\n", ""), "a digit": text.replace("X9 Y1", "X9 Y1.0003"),
        "a feed": text.replace("F400", "F410"),
    }[change]  # fmt: skip
    files = tmp_path / "a.ngc", tmp_path / "b.ngc"
    for file, content in zip(files, (text, other), strict=True):
        file.write_text(content)
    ref = reference(files[0])
    check(read_toolpath(files[0]), ref, 1e-4)
    with pytest.raises((AssertionError, ReadError)):
        check(read_toolpath(files[1]), ref, 1e-4)
