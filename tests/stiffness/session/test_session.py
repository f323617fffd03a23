"""Sessions at the door: what a lab wrote is what comes out."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.session.session import Session, load_session
from tests.plant import lab
from tests.stiffness.session_desk import TARGETS, TOOL, Rows, ur10, write

Floats = npt.NDArray[np.float64]


def in_base(session: Session, notes: lab.Notes) -> Floats:
    """(N, 6) the wrench as read, in base axes about the true point, with the plant's links."""
    load, links = session.samples.load, notes.truth.walk.links[notes.truth.at]
    rows = np.arange(len(links))
    tool = links[:, -1, :3, :3] @ TOOL.pose[:3, :3]
    axes = np.where(load.in_tool[:, None, None], tool, np.eye(3))
    f, m = ((axes @ part[:, :, None])[:, :, 0] for part in (load.wrench[:, :3], load.wrench[:, 3:]))
    frame = links[rows, load.point_link]
    about = (frame[:, :3, :3] @ load.point[:, :, None])[:, :, 0] + frame[:, :3, 3]
    return np.hstack([f, m + np.cross(about - notes.truth.point, f)])


@pytest.mark.parametrize(
    ("length", "angle", "frame", "about", "columns"),
    [
        ("mm", "deg", "base", "tcp", True),
        ("m", "rad", "tool", "flange", False),
        ("mm", "rad", "tool", "base", True),
        ("m", "deg", "base", "base", False),
    ],
)
def test_units_frames_and_loads(tmp_path: Path, length: Any, angle: Any, frame: Any, about: Any, columns: bool) -> None:
    form = lab.Form(length, angle, frame, about, step=True, seconds=8.0, load_columns=columns)
    pulls = (None, "elbow") if columns else (None, "side")
    session, notes = write(tmp_path, form=form, design={"pulls": pulls, "preload": 15.0, "payload": 1.5})
    s, truth = session.samples, notes.truth
    np.testing.assert_allclose(s.position, truth.position, atol=1e-8)
    np.testing.assert_allclose(s.q, truth.walk.q_cmd[truth.at], atol=1e-12)
    np.testing.assert_array_equal(s.approach, truth.walk.direction[truth.at])
    moves = np.diff(truth.walk.q_cmd, axis=0)[::7]  # before the move, then states 0 to 5
    np.testing.assert_allclose(s.step, np.repeat(moves, 18, axis=0), atol=1e-12)
    np.testing.assert_allclose(in_base(session, notes), truth.wrench, atol=1e-8)
    assert np.linalg.norm(s.load.wrench[s.state == 0, :3], axis=1) == pytest.approx(15)
    np.testing.assert_allclose(s.sd, 1e-9)
    assert session.instruments.tracker == pytest.approx(1e-9)
    assert s.payload.tolist() == ([0.0] * 15 + [1.5] * 3) * 4
    assert s.time[:3].tolist() == [0, 8, 16] and np.isnan(s.temperature).all()
    np.testing.assert_allclose(session.tool.rotation, TOOL.pose[:3, :3], atol=1e-12)
    np.testing.assert_allclose(session.tool.position, np.array(TOOL.xyz), atol=1e-15)
    assert session.tool.com is not None
    np.testing.assert_allclose(session.tool.com, np.array(TOOL.com), atol=1e-15)
    assert (session.tool.mass, session.tool.name) == (2.5, "tool")
    assert (session.tool.tool().mass, session.has_wrench, len(session)) == (2.5, True, 72)
    for r, t in zip(session.reflectors, TARGETS, strict=True):
        assert (r.name, r.link, r.exact, r.group) == (t.name, t.link, t.exact, None)
        np.testing.assert_allclose(r.position, np.array(t.at), atol=1e-12)
    assert [session.reflectors[k].name for k in s.reflector[:4]] == ["tcp", "elbow", "side", "tcp"]


def test_where_a_load_acts(tmp_path: Path) -> None:
    session, notes = write(tmp_path, design={"pulls": (None, "elbow", "side"), "count": 3, "directions": 1})
    load = session.samples.load
    pulled = np.array([row["load_at"] for row in notes.rows])
    for name, link, place, at in (("", 6, TOOL.xyz, -1), ("elbow", 3, TARGETS[1].at, 1), ("side", 6, TARGETS[2].at, 2)):
        rows = pulled == name
        assert rows.sum() >= 6
        assert set(load.link[rows]) == set(load.point_link[rows]) == {link}
        assert set(load.at[rows]) == {at}  # the reflector "side" is not exact: its place is to be estimated
        np.testing.assert_allclose(load.point[rows], np.tile(place, (rows.sum(), 1)), atol=1e-12)


def test_sensor_readings_that_rows_share(tmp_path: Path) -> None:
    noise = lab.Noise(2e-5)
    each, _ = write(tmp_path / "each", noise=noise)
    assert len(np.unique(each.sensor_reading)) == len(each) == 60
    once, _ = write(tmp_path / "once", noise=noise, form=lab.Form(sensed="state", repeats=2))
    shared = once.sensor_reading.reshape(40, 3)
    assert (shared == shared[:, :1]).all() and len(np.unique(shared)) == 40


def test_unregistered_blocks_repeats_and_columns(tmp_path: Path) -> None:
    extra: dict[str, Any] = {"humidity": [0.1, 0.2, 0.3, 0.4], "shift": ["late", 2, 3, 4], "gap": [1, "", 3, 4]}
    extra["temperature"] = [20, 21, 22, 23]
    form = lab.Form(registered=False, blocks=2, repeats=3, sd=True, extra=extra)
    session, notes = write(tmp_path, form=form, noise=lab.Noise(5e-5))
    s = session.samples
    assert not session.registered
    for block in (0, 1):
        rows = s.block == block
        assert rows.sum() == 90
        station = notes.truth.station[block]
        np.testing.assert_allclose(
            s.position[rows] @ station[:3, :3].T + station[:3, 3], notes.truth.position[rows], atol=4e-4
        )
    assert s.repeat[:9].tolist() == [0] * 3 + [1] * 3 + [2] * 3
    assert list(s.extra) == ["humidity"]
    assert s.extra["humidity"][[0, 45, -1]].tolist() == [0.1, 0.2, 0.4]
    assert session.not_numeric == ("shift", "gap")
    assert s.temperature[[0, -1]].tolist() == [20, 23]
    assert np.unique(s.sd) == pytest.approx([5e-5])
    assert s.line.tolist() == list(range(2, 182))


def test_everything_is_read_only_and_short_to_print(tmp_path: Path) -> None:
    session, _ = write(tmp_path)
    arrays = [v for part in (session.samples, session.samples.load) for v in vars(part).values()]
    arrays += [*vars(session.states).values(), *vars(session.pairs).values(), session.group, session.counts]
    arrays += [session.reflectors[0].position]
    found = [a for a in arrays if isinstance(a, np.ndarray)]
    assert len(found) > 25
    assert not any(a.flags.writeable for a in found)
    with pytest.raises(AttributeError):
        session.gravity = "no"  # type: ignore[misc]
    for thing in (session, session.samples, session.states, session.pairs):
        assert "\n" not in repr(thing) and len(repr(thing)) < 250 and "array" not in repr(thing)
    assert "4 set-ups, 20 states, 60 readings, evidence: displacement and absolute" in repr(session)
    for key, name in (("session", "session.toml"), ("samples", "samples.csv")):
        assert session.sha256[key] == hashlib.sha256((tmp_path / name).read_bytes()).hexdigest()


def test_states_in_order_of_reading(tmp_path: Path) -> None:
    write(tmp_path, design={"count": 2, "directions": 1})
    rows = Rows(tmp_path)
    # set-up 2 first, and within it state 2 before 1
    rows.order = sorted(rows.order, key=lambda r: (-int(r["setup"]), {"0": 0, "2": 1, "1": 2}[r["state"]]))
    states = load_session(rows.write()).states
    assert states.setup.tolist() == [2, 2, 2, 1, 1, 1]
    assert states.state.tolist() == [0, 2, 1, 0, 2, 1]
    assert states.first.tolist() == [0, 3, 6, 9, 12, 15]
    assert states.of.tolist() == [k for k in range(6) for _ in range(3)]
    assert states.before.tolist() == [-1, 2, 0, -1, 5, 3]  # load history goes by the number


def test_pairs_match_repeats(tmp_path: Path) -> None:
    session, notes = write(tmp_path, form=lab.Form(repeats=3), noise=lab.Noise(3e-5))
    pairs, s = session.pairs, session.samples
    assert len(pairs) == 4 * 4 * 3 * 3 and not len(pairs.alone)
    for name in ("setup", "reflector", "repeat", "block"):
        np.testing.assert_array_equal(getattr(s, name)[pairs.row], getattr(s, name)[pairs.reference])
    assert (s.state[pairs.reference] == 0).all() and (s.state[pairs.row] > 0).all()
    truth = notes.truth.position[pairs.row] - notes.truth.position[pairs.reference]
    off = pairs.displacement - truth
    assert np.abs(truth).max() > 5e-4
    assert off.std() == pytest.approx(3e-5 * np.sqrt(2), rel=0.1)
    np.testing.assert_allclose(pairs.sd, 3e-5 * np.sqrt(2))


def test_pairs_match_repeats_by_number_not_by_order(tmp_path: Path) -> None:
    write(tmp_path, form=lab.Form(repeats=3))
    rows = Rows(tmp_path)
    rows.order = [r for r in reversed(rows.order) if r["state"] == "0"] + [r for r in rows.order if r["state"] != "0"]
    session = load_session(rows.write())
    repeat = session.samples.repeat
    np.testing.assert_array_equal(repeat[session.pairs.row], repeat[session.pairs.reference])


def test_pairs_share_a_reference_that_was_read_less_often(tmp_path: Path) -> None:
    write(tmp_path, form=lab.Form(repeats=3), design={"count": 1})
    rows = Rows(tmp_path)
    rows.order = [r for r in rows.order if r["state"] != "0" or int(r["repeat"]) < 2]
    rows.order = [r for r in rows.order if (r["state"], r["reflector"]) != ("0", "side")]
    session = load_session(rows.write())
    pairs, s = session.pairs, session.samples
    assert len(pairs) == 4 * 2 * 3
    third = s.repeat[pairs.row] == 2
    assert set(s.repeat[pairs.reference[third]].tolist()) <= {0, 1}
    np.testing.assert_array_equal(s.repeat[pairs.reference[~third]], s.repeat[pairs.row[~third]])
    assert [session.reflectors[k].name for k in s.reflector[pairs.alone]] == ["side"] * 12


def test_pairs_do_not_cross_tracker_stations(tmp_path: Path) -> None:
    write(tmp_path, form=lab.Form(blocks=2))
    rows = Rows(tmp_path)
    for row in rows.order:
        row["block"] = "1" if row["state"] == "4" else "0"
    session = load_session(rows.write())
    assert len(session.pairs) == 4 * 3 * 3
    assert set(session.samples.state[session.pairs.alone]) == {4}


def test_two_stations_may_read_the_same(tmp_path: Path) -> None:
    write(tmp_path, design={"count": 1})
    rows = Rows(tmp_path)
    rows.order = [{**row, "block": block} for block in "01" for row in rows.order]
    session = load_session(rows.write())
    assert (len(session.samples), len(session.states), len(session.pairs)) == (30, 5, 24)


def test_part_of_a_session(tmp_path: Path) -> None:
    session, _ = write(tmp_path)
    part = session.take(session.samples.setup != 2)
    assert part.samples.line.tolist() == [*range(2, 17), *range(32, 62)]
    assert part.states.setup.tolist() == [1] * 5 + [3] * 5 + [4] * 5
    assert part.pairs.row.max() < len(part.samples) == 45
    np.testing.assert_array_equal(part.samples.load.wrench, session.samples.load.wrench[part.samples.line - 2])
    np.testing.assert_array_equal(part.pairs.displacement[-1], session.pairs.displacement[-1])


def test_unloaded_calibration(tmp_path: Path) -> None:
    form = lab.Form(registered=False, wrench=False)
    session, _ = write(tmp_path, form=form, design={"directions": 0, "count": 6})
    assert session.has_absolute and not session.has_displacement
    assert session.wrench_frame is None and not session.has_wrench and not session.samples.load.wrench.any()
    # 6 numbers for the tracker and 3 for the reflector that is not exact leave nothing of three readings
    assert not session.take(np.arange(3)).has_absolute
    assert session.take(np.arange(4)).has_absolute


def test_probe_of_unknown_placement(tmp_path: Path) -> None:
    probe = [replace(t, exact=False, group="probe", link=6) for t in TARGETS]
    noise = lab.Noise(2e-5, 1e-4, 0.5, 0.06)
    setups = [lab.Setup([0.1 * k, -1.0, 0.7 + 0.1 * k, 0.3, 0.8, 0.2 * k], [0.1] * 6) for k in range(3)]
    notes = lab.measure(ur10(), setups, probe, noise=noise, form=lab.Form(registered=False, rough=0.002))
    session = load_session(notes.write(tmp_path, "ur10"))
    given = session.instruments
    assert given.tracker == pytest.approx(2e-5) and given.tracker_angle == 1e-4
    assert (given.force, given.torque) == (0.5, 0.06)
    # six numbers a pose, and twelve to place tracker and probe
    assert not session.take(session.samples.setup < 3).has_absolute
    assert session.has_absolute


# ---- real sessions


@pytest.mark.parametrize(("name", "count"), [("A", 3000), ("B", 1495)])
def test_real_ur10(shared: Path, name: str, count: int) -> None:
    path = shared / "data/ur10" / name / "session.toml"
    session = load_session(path)
    s = session.samples
    assert len(s) == 3 * count == 3 * len(session.states)
    assert (session.robot.tip, session.robot.base, session.registered) == ("wrist_3_link", "base", False)
    assert session.has_absolute and not session.has_displacement
    assert session.instruments.tracker == pytest.approx(2e-5)
    assert session.group.tolist() == [0, 0, 0] and session.counts.sum() == count
    assert list(s.extra) == ["sequence"]
    # a probe is rigid: its points stay 100 mm apart
    arms = s.position.reshape(-1, 3, 3)
    np.testing.assert_allclose(np.linalg.norm(arms[:, 1] - arms[:, 0], axis=1), 0.1, atol=1e-6)


def test_ten_thousand_rows(tmp_path: Path) -> None:
    design = {"count": 250, "levels": (0.2, 0.4, 0.6, 0.8, 1.0), "directions": 1, "payload": 1.0}
    _, notes = write(tmp_path, design=design, form=lab.Form(repeats=2))
    assert len(notes.rows) == 10_500
    session = load_session(tmp_path / "session.toml")
    assert len(session.samples) == 10_500
    assert (len(session.states), len(session.pairs)) == (250 * 7, 250 * 6 * 3 * 2)


def test_replace_keeps_views_apart(tmp_path: Path) -> None:
    session, _ = write(tmp_path)
    assert len(session.pairs) == 48
    assert len(replace(session, samples=session.samples.take(np.arange(15))).pairs) == 12
