"""Sessions of a URDF that do not tell base and tip mean what they did, and are warned of in the words of cells."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import tomli_w
from click.testing import CliRunner

from compensator.cell.arm import load_arm
from compensator.cell.cell_file import load_cell
from compensator.cell.controller_frames import session_frame_findings
from compensator.cli import main
from compensator.tasks.compensate import preview_file
from compensator.tasks.diagnose import diagnose_files
from compensator.tasks.identify import evaluate_file, identify_files
from compensator.tasks.measurements import load_measurement
from stiffness.session.session import load_session
from stiffness.session.table import SessionError
from tests.compensator.framed_arm import FRAMED
from tests.compensator.small_job import columns, files, write_csv
from tests.plant import Arm, Plant, Tool, lab
from tests.plant.lab_design import random_setups

SOFT = [1.1e6, 0.9e6, 0.8e6, 2.5e5, 1.1e5, 6e4]
TOOL = Tool((0.03, -0.05, 0.15), (0.3, -0.4, 0.5), mass=20.0, com=(0.01, 0.0, 0.06))
WORDS = {
    "tip": "tools are taken as measured from 'J6_link', the last moving link of the URDF; 'fanuc_flange' stands 175 mm",
    "base": "positions in the base are taken as measured from 'world', the root of the URDF; 'wbase' stands 878.9 mm",
}


def measured(folder: Path, base: str, tip: str) -> Path:
    """A day in the lab in these frames; nothing in the file tells so."""
    robot = folder / "given" / "framed.urdf"
    robot.parent.mkdir()
    robot.write_text(FRAMED)
    high, arm = (Arm.load(robot, tool=TOOL, base=name, tip=tip) for name in ("world", base))
    noise = lab.Noise(tracker=1e-6, force=0.0, torque=0.0)
    targets = (lab.Target("tcp", 6, TOOL.xyz), lab.Target("elbow", 3, (0.2, 0.06, 0.05)))
    notes = lab.measure(Plant(arm, stiffness=SOFT), random_setups(high, 12, 1), targets, noise=noise, seed=2)
    return notes.write(folder, robot)


@pytest.fixture(scope="module")
def day(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Measured from the root, and from the last moving link."""
    return measured(tmp_path_factory.mktemp("day"), "world", "J6_link")


def told(session: Path, *keys: str) -> Path:
    """The session with frames that it means named in it."""
    named = {"base": 'base = "world"\n', "tip": 'tip = "J6_link"\n'}
    out = session.with_name(f"told-{'-'.join(keys)}.toml")
    out.write_text("".join(named[key] for key in keys) + session.read_text())
    return out


@pytest.mark.parametrize(("keys", "left"), [((), ("tip", "base")), (("tip",), ("base",)), (("base", "tip"), ())])
def test_identify_warns_and_means_what_it_did(keys: tuple, left: tuple, day: Path, tmp_path: Path) -> None:
    session = told(day, *keys) if keys else day
    done = identify_files([session], tmp_path / "m.toml")
    found = [f for f in done.report["findings"] if "taken as measured" in f["what"]]
    assert [f["what"].startswith(WORDS[key]) for f, key in zip(found, left, strict=True)] == [True] * len(left)
    for f in found:
        assert (f["level"], f["where"]) == ("warning", str(session))
        assert "in session and model; if not" in f["remedy"]
    assert done.report["stiffness_nm_per_rad"] == pytest.approx(SOFT, rel=0.02)
    assert 'base = "world"' in (tmp_path / "m.toml").read_text()


def test_evaluate_and_diagnose_say_the_same(day: Path, tmp_path: Path) -> None:
    done = identify_files([day], tmp_path / "m.toml")
    again = diagnose_files([day], tmp_path / "m.toml").report
    said = [
        [f["what"] for f in report["findings"] if "taken as measured" in f["what"]]
        for report in (done.report, evaluate_file(day, tmp_path / "m.toml")[1], again)
    ]
    assert len(said[0]) == 2 and said[0] == said[1] == said[2]


def test_a_day_in_the_frames_of_the_controller_has_to_name_them(tmp_path: Path) -> None:
    """Positions are in the controller's base: without its name they lie 1.4 m aside, and the refusal has it."""
    session = measured(tmp_path, "wbase", "fanuc_flange")
    text = session.read_text()
    with pytest.raises(SessionError, match=r"would fit with base = \"wbase\" and tip = \"fanuc_flange\"$"):
        load_session(session)
    session.write_text(f'tip = "fanuc_flange"\n{text}')
    with pytest.raises(SessionError, match=r"would fit with base = \"wbase\" or registered = false"):
        load_session(session)
    session.write_text(f'base = "wbase"\ntip = "fanuc_flange"\n{text}')
    done = identify_files([session], tmp_path / "m.toml")
    assert done.report["stiffness_nm_per_rad"] == pytest.approx(SOFT, rel=0.02)
    assert not [f for f in done.report["findings"] if "taken as measured" in f["what"]]


def test_the_words_are_those_about_a_cell(day: Path) -> None:
    """Only the file that has to tell has another name; the terminal shows them."""
    folder = day.parent
    job = files(folder, {"robot": "framed.urdf", "tip": None}, {"robot": "framed.urdf"})
    of_cell = load_arm(load_cell(job.cell)).findings
    of_session = session_frame_findings([load_session(day)])
    assert [f.what for f in of_cell] == [f.what for f in of_session] and len(of_cell) == 2
    assert [f.remedy.replace("cell", "session") for f in of_cell] == [f.remedy for f in of_session]
    done = CliRunner().invoke(main, ["identify", str(day), "-o", str(folder / "m.toml")])
    for words in WORDS.values():
        assert words in done.stderr


def test_of_a_trace_the_cell_is_asked(tmp_path: Path) -> None:
    (tmp_path / "framed.urdf").write_text(FRAMED)
    places = {"workobject": {"xyz": [1000.0, 0.0, 800.0]}}
    job = files(tmp_path, {"robot": "framed.urdf", "tip": None, **places}, {"robot": "framed.urdf"})
    preview_file(job.toolpath, job.cell, csv=tmp_path / "run.csv")
    told = columns(tmp_path / "run.csv", "x_mm", "y_mm", "z_mm")
    turn = np.radians(20.0)  # of the work object
    read = told @ [[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]] + [1000.0, 0.0, 800.0]
    write_csv(tmp_path / "samples.csv", ["index", "x", "y", "z"], [[k, *row] for k, row in enumerate(read)])
    table = {"schema": "trace/1", "cell": "cell.toml", "program": "run.csv", "samples": "samples.csv"}
    table |= {"kind": "positions", "registered": True, "approach": [0] * 6, "instrument": {"noise": 0.005}}
    (tmp_path / "trace.toml").write_text(tomli_w.dumps(table))
    found = session_frame_findings([load_measurement(tmp_path / "trace.toml")])
    assert [f.what.split(";")[0] for f in found] == [words.split(";")[0] for words in WORDS.values()]
    assert all("in cell of the trace and model; if not" in f.remedy for f in found)
