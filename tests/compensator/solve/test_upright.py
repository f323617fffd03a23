"""A filtered program without words for the tool's axis: positions take back what the tilt that stays would spoil."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from compensator.errors import SolveError
from compensator.program import filter_in_place as filtering
from compensator.tasks.compensate import Done, compensate_file
from toolpaths.languages.gcode import filter as gcode_filter

EXAMPLES = Path(__file__).parents[3] / "examples"


def cell(tmp_path: Path) -> Path:
    """The cell of the example, its tool 180 mm longer, with a force that no stock has a say in."""
    head, _, rest = (EXAMPLES / "cell.toml").read_text().partition("[process]")
    process = '[process]\nkind = "constant"\nframe = "path"\nwrench = [-120.0, 80.0, -60.0, 0.0, 0.0, 0.0]\n\n'
    head = head.replace("[0.0, 0.0, 250.0]", "[0.0, 0.0, 430.0]").replace("[0.0, 0.0, 120.0]", "[0.0, 0.0, 300.0]")
    model = head.replace('"stiffness.toml"', f'"{EXAMPLES}/stiffness.toml"')
    path = tmp_path / "cell.toml"
    path.write_text(f"{model}{process}[program]{rest.partition('[program]')[2]}")
    return path


def filtered(tmp_path: Path, head: str = "") -> Done:
    """The first passes of the example over its wave; ``head`` comes before the first move."""
    lines = (EXAMPLES / "wave.nc").read_text().split("\n")
    first = next(k for k, line in enumerate(lines) if line.startswith("G0"))
    file = tmp_path / "wave.nc"
    file.write_text("\n".join([*lines[:first], *([head] if head else []), *lines[first:420], "G0 Z50", "M30", ""]))
    return compensate_file(file, cell(tmp_path), tmp_path / "wave_c.nc")


def test_positions_take_back_what_the_tilt_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done = filtered(tmp_path)
    after, before = (done.report["predicted_error_mm"][k] for k in ("after", "before"))
    assert after["max"] < 0.02 and after["mean"] < 1e-3 < 0.5 < before["mean"]
    assert sum("tilts the tool by up to 0.06" in str(f) for f in done.findings) == 1
    with monkeypatch.context() as m:  # what the test is worth: commands with a tilt, written without it
        m.setattr(filtering, "without_tilt", lambda c: c)
        spoilt = filtered(tmp_path).report["predicted_error_mm"]["after"]
    assert spoilt["max"] > 0.06 and spoilt["mean"] > 2 * after["mean"]


def test_what_is_written_is_reported_and_kept_within_bounds(tmp_path: Path) -> None:
    c = filtered(tmp_path).result
    np.testing.assert_allclose(c.command.rotation[c.cutting], c.path.tcp.rotation[c.cutting], atol=1e-12)
    tight = c.job.placement.solve.model_copy(update={"max_correction": 0.1})
    job = replace(c.job, placement=replace(c.job.placement, solve=tight))
    with pytest.raises(SolveError, match=r"is above solve\.max_correction = 0\.1 mm"):
        filtering.without_tilt(replace(c, job=job))


def test_a_file_with_tool_vectors_takes_the_tilt(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(filtering, "without_tilt", None)  # it must not be called
    done = filtered(tmp_path, "G43.4 H1")
    assert done.report["predicted_error_mm"]["after"]["max"] < 0.02
    assert not any("tilts" in str(f) for f in done.findings)
    axis = [line for line in (tmp_path / "wave_c.nc").read_text().split("\n") if "K0.99" in line or "K1" in line]
    assert len(axis) > 100
    assert not np.any(["K0.99" in line for line in (tmp_path / "wave.nc").read_text().split("\n")])


def test_a_flank_change_within_an_arc_that_stays_an_arc(shared: Path, tmp_path: Path) -> None:
    """The pose put in there stands nowhere in the file: the arc says it. Small letters, turned at many places."""
    lines = (shared / "data/cam/gcode_fusion/1110_wall_265bit.nc").read_text().split("\n")
    file = tmp_path / "wall.nc"
    file.write_text("\n".join([*lines[:400], "G1 Z5", "M30", "%", ""]))
    done = compensate_file(file, cell(tmp_path), tmp_path / "wall_c.nc")
    after = done.report["predicted_error_mm"]["after"]
    assert after["mean"] < 2e-3 and after["p95"] < 5e-3 and after["max"] < 0.13
    assert re.search(r"^G[23] X\S+ Y\S+ I", (tmp_path / "wall_c.nc").read_text(), re.M)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("G21\nG43.4 H1\n", True), ("g043.5h2", True), ("G1 X1 G 43.4", True), ("(G43.4)\nG43 H1\n", False),
        ("G43 H1 ; G43.4\n", False), ("G43.40 H1", True), ("G21 X43.4", False),
    ],
)  # fmt: skip
def test_which_files_have_words_for_the_axis(text: str, says: bool) -> None:
    assert gcode_filter.says_turns(text.encode()) is says
