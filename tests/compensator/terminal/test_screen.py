"""What a person sees of a result in the terminal, and that a pipe gets nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, cast

import pytest
from rich.console import Console

from compensator.tasks.compensate import preview_file
from compensator.tasks.identify import Identified
from compensator.tasks.models import clamped_file
from compensator.tasks.stiffness_map import Mapped
from compensator.terminal import screen
from compensator.terminal.fit import show_evaluation, show_fit
from compensator.terminal.made_model import show_made
from compensator.terminal.path import show_path
from compensator.terminal.stiffness_map import show_map
from tests.compensator.report.small_path import prepared
from tests.stiffness.arms import NAMES
from tests.stiffness.model.test_clamped import HEADER, cycle, lines, written

Shown = Callable[[], str]


@pytest.fixture
def shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Shown]:
    """A terminal, and what stands in it."""
    with (tmp_path / "screen").open("w") as file:
        console = Console(record=True, force_terminal=True, width=120, file=file, markup=False)
        monkeypatch.setattr(screen, "Console", lambda **_: console)
        yield console.export_text


def test_a_path(tmp_path: Path, shown: Shown) -> None:
    folder = prepared(tmp_path)
    done = preview_file(folder / "circle.csv", folder / "cell.toml", csv=folder / "out.csv")
    screen.print_findings(done.report)
    show_path(done)
    text = " ".join(shown().split())
    assert f"{done.report['n_poses']} poses, {done.report['n_cut']} cutting" in text
    assert "uncompensated" in text and "program as written" not in text
    assert f"{done.report['predicted_error_mm']['before']['max']:.3f}" in text
    assert all(f"{f['level']}: " in text and f["what"][:60] in text for f in done.report["findings"])
    assert "wrote " in text and "tool looks along (0.00, 0.00, -1.00)" in text and "largest correction" not in text


def test_findings_in_square_brackets_are_text(shown: Shown) -> None:
    """Not markup; how many places there are more, and the remedy behind."""
    one = {"level": "warning", "kind": "solve", "where": "a.nc:3", "what": "[start] is", "remedy": "[b]", "count": 2}
    screen.print_findings({"findings": [one]}, ["a figure is missing"])
    assert shown() == "warning: a.nc:3 (and 1 more place): [start] is. [b]\nwarning: a figure is missing\n"


def test_a_fit(shown: Shown) -> None:
    report = {
        "n_readings": 40,
        "effects": ["joint-stiffness"],
        "stiffness_nm_per_rad": [1.5e6, None],
        "stiffness_sd_nm_per_rad": [2.0e4, None],
        "rms_mm": {"displacement": {"rigid": 0.5, "fitted": 0.03, "noise_floor": 0.029}, "absolute": None},
        "outlier_rows": [{"session": "s", "row": 17}],
        "notes": ["[a note]"],
        "not_identified": ["stiffness of joint 2"],
    }
    show_fit(Identified(cast(Any, None), report, (Path("model.toml"),)))
    text = shown()
    assert "40 readings, effects joint-stiffness" in text and "1.5e+06" in text and "not identified" in text
    assert "displacement: 0.5000 mm rigid, 0.0300 mm fitted, noise 0.0290 mm" in text and "absolute" not in text
    assert "1 rows (17)" in text and "- [a note]" in text and "wrote model.toml" in text


def test_an_evaluation(shown: Shown) -> None:
    score = {"rms_mm": 0.01, "p95_mm": 0.02, "max_mm": 0.03, "noise_floor_mm": 0.005}
    show_evaluation({"displacement": score, "absolute": None, "path": None})
    assert shown().splitlines() == [
        "displacement: rms 0.0100 mm per axis (noise 0.0050), 95 % 0.0200 mm, max 0.0300 mm",
        "absolute: no such evidence",
    ]


def test_a_map(shown: Shown) -> None:
    place = {"n_per_um": 1.25, "mm": 0.5, "um": 3.0, "ratio": 0.01, "urad": 2.0, "q_deg": [0.0, 30.0, -45.0]}
    keys = ("stiffness_min", "stiffness_max", "deflection_max", "kc_shift_max", "nu_p_max", "nu_r_max")
    counts = {"n_postures": 9, "n_ok": 6, "n_limit": 2, "n_singular": 1, "n_no_equilibrium": 0}
    report = {**counts, **dict.fromkeys(keys, place), "notes": ["the tool weighs nothing here"]}
    show_map(Mapped(cast(Any, None), cast(Any, None), report, (Path("map.csv"),)))
    text = shown()
    assert "9 postures: 6 ok, 2 beyond a limit, 1 singular, 0 without equilibrium" in text
    assert "1.25 N/µm" in text and "0, 30, -45" in text and "wrote map.csv" in text


def test_a_model_from_clamped_readings(tmp_path: Path, shown: Shown) -> None:
    readings = written(tmp_path, lines(cycle(branches=("loading",)), cycle()), HEADER)
    done = clamped_file(readings, NAMES[0], tmp_path / "m.toml")
    screen.print_findings(done.report)
    show_made(done)
    text = " ".join(shown().split())  # the path of a folder decides where lines end
    assert "1.5e+06" in text and "not identified" in text and "joint 1: no unloading branch" in text


def test_a_pipe_gets_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    show_evaluation({"displacement": None, "absolute": None})
    screen.show_lines(["a line"])
    with screen.progress(False) as say:
        say("reading")
    assert capsys.readouterr() == ("", "")
