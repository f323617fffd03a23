"""Plans of circles and touches: what they promise is true of the program that is written, seen by other means.

A joint with play is simulated along the joint angles of run.csv, and its gap is found again from the readings.
"""

from __future__ import annotations

import csv
import json
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import tomli_w
from click.testing import CliRunner

from compensator.cli import main
from compensator.errors import CompensatorError, PathError
from compensator.tasks.plan_trial import plan_trial_file
from stiffness.robot.load import load_robot
from tests.compensator import small_job

GAPS = np.array([6e-5, 5e-5, 6e-5, 1.1e-4, 1.6e-4, 2.2e-4])  # rad
Q = [f"q{k}_deg" for k in range(1, 7)]


@dataclass(frozen=True)
class Made:
    """A plan in its folder: report, run.csv as text cells, samples, trace."""

    folder: Path
    report: dict
    run: list[dict[str, str]]
    samples: list[dict[str, str]]
    trace: dict

    @property
    def q(self) -> np.ndarray:
        """(N, 6) rad of the program."""
        return np.radians([[float(row[name]) for name in Q] for row in self.run])

    def sample(self, name: str) -> np.ndarray:
        """(M,) of a column of the samples."""
        return np.array([float(row[name]) for row in self.samples])

    @property
    def index(self) -> np.ndarray:
        """(M,) rows of the program."""
        return self.sample("index").astype(int)


def table(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text().splitlines()))


def planned(folder: Path, *words: str, program: str = "trial.mod") -> Made:
    job = small_job.files(folder)
    done = CliRunner().invoke(
        main, ["plan", *words, "--cell", str(job.cell), "-o", str(job.out / program), "--json", str(job.out / "p.json")]
    )
    assert done.exit_code == 0, done.output
    report = json.loads((job.out / "p.json").read_text())
    trace = tomllib.loads((job.out / "trace.toml").read_text())
    return Made(job.out, report, table(job.out / trace["program"]), table(job.out / "samples.csv"), trace)


@pytest.fixture(scope="module")
def circles(tmp_path_factory: pytest.TempPathFactory) -> Made:
    return planned(tmp_path_factory.mktemp("circles"), "--ballbar")


@pytest.fixture(scope="module")
def touches(tmp_path_factory: pytest.TempPathFactory) -> Made:
    return planned(tmp_path_factory.mktemp("touches"), "--probe", program="trial.src")


def with_play(q: np.ndarray, gap: np.ndarray) -> np.ndarray:
    """Where joints stand that follow the motor ``q`` only when they touch a flank of their gap."""
    out = q.copy()
    for k in range(1, len(q)):
        out[k] = np.clip(out[k - 1], q[k] - gap / 2, q[k] + gap / 2)
    return out


def tcp(q: np.ndarray) -> np.ndarray:
    """(N, 3) m, base axes."""
    robot = load_robot(small_job.ABB)
    tool = np.array(small_job.CELL["tool"]["xyz"]) / 1e3
    return np.array([(pose := robot.pose(row))[:3, :3] @ tool + pose[:3, 3] for row in q])


def test_the_trace_is_empty_but_ready(circles: Made) -> None:
    assert circles.trace["kind"] == "ballbar" and circles.trace["dry"] is True
    assert (circles.trace["cell"], circles.trace["program"]) == ("../cell.toml", "run.csv")
    assert circles.trace["ballbar"]["radius"] == 150.0 and circles.trace["ballbar"]["calibrated"] is False
    assert list(circles.samples[0]) == ["index", "radius", "circle", "angle", "direction"]
    assert {row["radius"] for row in circles.samples} == {""}
    assert {p.name for p in circles.folder.iterdir()} == {
        "trial.mod", "run.csv", "trace.toml", "samples.csv", "p.json"
    }  # fmt: skip
    assert [row["index"] for row in circles.run] == [str(k) for k in range(len(circles.run))]


def test_every_reading_lies_on_its_circle_in_both_directions_and_at_both_feeds(circles: Made) -> None:
    at = tcp(circles.q[circles.index]) * 1e3
    radius = np.linalg.norm(at - circles.trace["ballbar"]["center"], axis=1)
    assert np.abs(radius - 150.0).max() < 1e-3  # rounding of run.csv
    assert {row["kind"] for k in circles.index for row in [circles.run[k]]} == {"cut"}
    feed = [float(circles.run[k]["feed_mm_min"]) for k in circles.index]
    assert {(f, d) for f, d in zip(feed, circles.sample("direction"), strict=True)} == {
        (f, d) for f in (500.0, 2000.0) for d in (1.0, -1.0)
    }
    assert {tuple(float(row[k]) for k in ("fx_n", "fy_n", "fz_n")) for row in circles.run} == {(0.0, 0.0, 0.0)}


def test_joints_turn_round_where_the_plan_has_it(circles: Made) -> None:
    """A change of sign of the motion, with the lever by differences of the radius."""
    robot = load_robot(small_job.ABB)
    centre = np.array(circles.trace["ballbar"]["center"]) / 1e3
    one_way = (circles.sample("direction") == 1) & (np.arange(len(circles.samples)) < len(circles.samples) // 2)
    assert [j["joint"] for j in circles.report["joints"]] == [1, 2, 3, 4, 5, 6]
    for told in circles.report["joints"]:
        assert told["why_not"] is None and told["apart_deg"] >= 10.0 and abs(told["um_per_mrad"]) >= 20.0
        rows = np.flatnonzero(one_way & (circles.sample("circle") == told["circle"]))
        angle, q = circles.sample("angle")[rows], circles.q[circles.index[rows]]
        j = told["joint"] - 1
        turns = angle[1:-1][np.diff(np.sign(np.diff(q[:, j]))) != 0]
        assert np.abs(turns - told["at_deg"]).min() < 4.0  # the plan looks every 3 deg
        at = q[np.argmin(np.abs(angle - told["at_deg"]))]
        moved = at + 1e-6 * np.eye(6)[j]
        by = np.linalg.norm(tcp(moved[None]) - centre) - np.linalg.norm(tcp(at[None]) - centre)
        assert by / 1e-6 * 1e3 == pytest.approx(told["um_per_mrad"], rel=0.05, abs=1.0)
    assert np.all(circles.q > robot.lower) and np.all(circles.q < robot.upper)


def test_gaps_are_found_again_from_the_circles(circles: Made) -> None:
    q, index = circles.q, circles.index
    centre = np.array(circles.trace["ballbar"]["center"]) / 1e3
    rng = np.random.default_rng(1)
    truth = tcp(with_play(q, GAPS))[index] - (centre + np.array([2e-4, -1e-4, 3e-4]))
    radius = np.linalg.norm(truth, axis=1) + 4e-5 + rng.normal(0.0, 5e-6, len(index))

    # plain least squares: gaps by differences of the simulation, centre along the bar, length
    def predicted(gap: np.ndarray) -> np.ndarray:
        return np.linalg.norm(tcp(with_play(q, gap))[index] - centre, axis=1)

    nominal, small = predicted(np.zeros(6)), np.full(6, 1e-4)
    columns = [(predicted(small * np.eye(6)[j]) - nominal) / 1e-4 for j in range(6)]
    bar = (tcp(q[index]) - centre) / nominal[:, None]
    design = np.column_stack([*columns, -bar, np.ones(len(index))])
    found, *_ = np.linalg.lstsq(design, radius - nominal, rcond=None)
    sd = 5.0 * np.array([j["gap_sd_urad"] for j in circles.report["joints"]]) * 1e-6  # of 1 um: 5 um here
    assert np.all(np.abs(found[:6] - GAPS) < 3.0 * sd + 0.03 * GAPS)
    assert abs(found[0] / GAPS[0] - 1) < 0.05


def test_only_the_touched_joint_changes_its_side(touches: Made) -> None:
    assert touches.trace["kind"] == "surface" and touches.trace["registered"] is False
    assert list(touches.samples[0])[:8] == ["index", "x", "y", "z", "i", "j", "k", "deviation"]
    assert {row["deviation"] for row in touches.samples} == {""}
    assert [j["joint"] for j in touches.report["joints"] if j["touch"]] == [1, 2, 3, 4, 5]
    assert "it lies near its axis" in touches.report["joints"][5]["why_not"]
    for told in touches.report["touches"]:
        rows = touches.index[touches.sample("touch") == told["touch"]]
        assert len(rows) == 4  # two sides, twice
        j = told["joint"] - 1
        others = [k for k in range(6) if k != j]
        between = touches.q[rows[0] : rows[-1] + 1]
        assert np.abs(between[:, others] - between[0, others]).max() < 3e-6  # far less than a gap
        assert np.ptp(between[:, j]) == pytest.approx(np.radians(2 * told["turn_deg"]), rel=1e-3)
        assert np.degrees(touches.q[rows]) == pytest.approx(np.tile(told["q_deg"], (4, 1)), abs=1e-3)
        last = np.sign(touches.q[rows, j] - touches.q[rows - 1, j])
        assert last.tolist() == touches.sample("side")[touches.sample("touch") == told["touch"]].tolist()


def test_gaps_are_the_differences_of_two_touches(touches: Made) -> None:
    """As a person with a dial gauge reckons: the difference over the lever."""
    seen = tcp(with_play(touches.q, GAPS)) @ rotation().T
    for told in touches.report["touches"]:
        mine = touches.sample("touch") == told["touch"]
        gauge = seen[touches.index[mine]] @ np.array([touches.sample(k)[mine][0] for k in "ijk"])
        side = touches.sample("side")[mine]
        lost = gauge[side < 0].mean() - gauge[side > 0].mean()
        assert lost / (told["um_per_mrad"] / 1e3) == pytest.approx(GAPS[told["joint"] - 1], rel=0.02)


def rotation() -> np.ndarray:
    """Base axes in the work object."""
    yaw = np.radians(small_job.CELL["workobject"]["rpy"][2])
    return np.array([[np.cos(yaw), np.sin(yaw), 0], [-np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])


def test_the_program_waits_for_people(circles: Made, touches: Made) -> None:
    rapid = (circles.folder / "trial.mod").read_text()
    assert rapid.count("Stop;") == 2 * len(circles.report["circles"]) and "mount the ball-bar, circle 1" in rapid
    krl = (touches.folder / "trial.src").read_text()
    assert krl.count("HALT") >= len(touches.samples) and "read the gauge" in krl


def test_a_plan_is_no_compensated_program(circles: Made) -> None:
    text = (circles.folder / "trial.mod").read_text()
    assert "Test program" in text and "Compensated" not in text


def test_joints_that_the_weight_holds_are_told(circles: Made) -> None:
    """Joint 1 stands upright: no weight; joint 2 carries the arm in front of it."""
    joints = circles.report["joints"]
    assert joints[0]["torque_nm"] == pytest.approx([0, 0], abs=1e-3) and not joints[0]["weight_keeps_its_side"]
    assert joints[1]["weight_keeps_its_side"] and np.prod(joints[1]["torque_nm"]) > 0
    note = next(f for f in circles.report["findings"] if "looks like a joint zero" in f["what"])
    assert note["level"] == "note" and "2 (" in note["what"]


def test_a_csv_is_the_program_of_its_trace_and_the_same_every_time(tmp_path: Path) -> None:
    job = small_job.files(tmp_path)
    center = (1500.0, -150.0, 1000.0)
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        plan_trial_file(job.cell, tmp_path / name / "p.csv", ballbar=True, center=center, radius=100.0, feeds=(300.0,))
    assert {p.name for p in (tmp_path / "a").iterdir()} == {"p.csv", "trace.toml", "samples.csv"}
    for file in (tmp_path / "a").iterdir():
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes()
    trace = tomllib.loads((tmp_path / "a" / "trace.toml").read_text())
    assert trace["program"] == "p.csv" and trace["ballbar"]["center"] == pytest.approx(list(center))


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["--ballbar", "--probe"], "a program for each"),
        (["--ballbar", "--count", "3"], "--count: belongs to a plan of set-ups"),
        (["--ballbar", "--radius", "5"], "--radius 5: expected mm, 20"),
        (["--probe", "--radius", "150"], "--radius 150: expected mm"),
        (["--probe", "--feed", "100"], "--feed 100: expected mm/min"),
        (["--ballbar", "--center", "9000", "0", "0"], "none of 15 circles of radius 150 mm can be run"),
        (["--probe", "--center", "9000", "0", "0"], "no posture near the work object is reached"),
    ],
)  # fmt: skip
def test_refused_plans(tmp_path: Path, words: list[str], why: str) -> None:
    job = small_job.files(tmp_path)
    done = CliRunner().invoke(main, ["plan", *words, "--cell", str(job.cell), "-o", str(job.out / "p.mod")])
    assert done.exit_code == 1 and why in done.stderr, done.output
    assert job.left() == []


def test_more_refusals(tmp_path: Path) -> None:
    job = small_job.files(tmp_path)
    run = CliRunner().invoke
    assert run(main, ["plan", "-o", "x.csv"]).exit_code == 2  # wrong usage: MODEL is missing
    assert "give --cell" in run(main, ["plan", "--ballbar", "-o", str(job.out / "p.mod")]).stderr
    model = str(tmp_path / "model.toml")
    both = run(main, ["plan", model, "--radius", "150", "-o", str(job.out / "p.csv")])
    assert "--radius: belongs to --ballbar or --probe" in both.stderr
    with pytest.raises(CompensatorError, match="name a file"):
        plan_trial_file(job.cell, Path("-"), ballbar=True)
    with pytest.raises(CompensatorError, match="give the program another name"):
        plan_trial_file(job.cell, job.out / "samples.csv", ballbar=True)
    (job.out / "samples.csv").write_text("filled in")
    with pytest.raises(CompensatorError, match=r"samples\.csv: stands there and may hold readings"):
        plan_trial_file(job.cell, job.out / "p.mod", ballbar=True)
    other = small_job.merged(small_job.MODEL, {"robot": "kuka-kr500"})
    (job.out / "samples.csv").unlink()
    (job.out / "trace.toml").write_bytes(job.cell.read_bytes())  # the cell stands where the trace is to be
    (job.out / "model.toml").write_bytes((tmp_path / "model.toml").read_bytes())
    with pytest.raises(CompensatorError, match=r"trace\.toml: stands there and may hold readings"):
        plan_trial_file(job.out / "trace.toml", job.out / "p.mod", ballbar=False)
    (job.out / "trace.toml").unlink()
    (tmp_path / "other.toml").write_text(tomli_w.dumps(other))
    with pytest.raises(CompensatorError, match="is for another robot"):
        plan_trial_file(job.cell, job.out / "p.mod", ballbar=True, model=tmp_path / "other.toml")
    assert issubclass(PathError, CompensatorError)
