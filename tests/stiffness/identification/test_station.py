"""Station: tracker poses, rough reflectors and probes, their derivatives against differences, their first guess."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from stiffness.identification.station import Station, TrackerPoses, rigid_fit
from stiffness.session.path_trace import PathTrace
from stiffness.session.session import Session
from tests.stiffness.identification import many_sided

Floats = npt.NDArray[np.float64]


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return many_sided.session(tmp_path_factory.mktemp("many"))


@pytest.fixture(scope="module")
def station(session: Session) -> Station:
    return Station(session)


def vector(station: Station, seed: int, size: float = 0.05) -> Floats:
    return size * np.random.default_rng(seed).normal(size=station.size)


def test_the_layout_has_six_numbers_per_pose_and_three_per_reflector(station: Station) -> None:
    assert [(e.name, e.span.stop - e.span.start) for e in station.entries] == [
        ("tracker block 0", 6), ("tracker block 1", 6), ("reflector rough", 3), ("probe probe", 6),
    ]  # fmt: skip
    assert station.size == 21
    assert station.prior_sd()[:6].tolist() == [1.0] * 3 + [0.5] * 3
    assert station.prior_sd()[12:15].tolist() == [1.0] * 3


def test_a_registered_frame_is_nearly_what_was_declared(tmp_path: Path) -> None:
    from tests.stiffness import session_desk

    known, _ = session_desk.write(tmp_path, form=session_desk.lab.Form())
    station = Station(known)
    assert [e.name for e in station.entries] == ["tracker block 0", "reflector side"]
    assert station.prior_sd().tolist() == [2e-4] * 6 + [1.0] * 3
    assert station.prior_sd(exact=True).tolist() == [1e-9] * 6 + [1.0] * 3
    base = known.samples.position
    poses = station.placed(base + 0.1)
    read, back, by_pose = station.seen(np.zeros(9), base, poses)
    assert read == pytest.approx(base, abs=1e-15)
    assert np.array_equal(back, np.broadcast_to(np.eye(3), back.shape))
    assert not by_pose[:, :, 6:].any() and np.array_equal(by_pose[:, :, :3], -back)


def test_a_registered_frame_of_a_trace_is_what_was_declared(tmp_path: Path) -> None:
    from tests.stiffness import session_desk

    known, _ = session_desk.write(tmp_path, form=session_desk.lab.Form())
    station = Station(replace(known, path=cast(PathTrace, object())))
    assert [e.name for e in station.entries] == ["reflector side"]
    base = known.samples.position
    read, back, by_pose = station.seen(np.zeros(3), base, station.placed(base))
    assert read is base
    assert np.array_equal(back, np.broadcast_to(np.eye(3), back.shape))
    assert not by_pose.any()


def test_reflectors_move_as_their_numbers_say(session: Session, station: Station) -> None:
    v = vector(station, 1)
    nominal, moved = station.reflectors(np.zeros(station.size)), station.reflectors(v)
    assert nominal == pytest.approx(np.array([r.position for r in session.reflectors]), abs=1e-15)
    names = [r.name for r in session.reflectors]
    exact = [names.index(n) for n in ("tcp", "elbow")]
    assert np.array_equal(moved[exact], nominal[exact])
    assert moved[names.index("rough")] == pytest.approx(nominal[names.index("rough")] + v[12:15])
    probe = [names.index(f"probe-{k}") for k in "abc"]
    turn = Rotation.from_rotvec(v[18:21]).as_matrix()
    first = nominal[probe[0]]
    for k in probe:
        assert moved[k] == pytest.approx(first + v[15:18] + turn @ (nominal[k] - first))
    # a probe is rigid
    assert np.linalg.norm(moved[probe[1]] - moved[probe[2]]) == pytest.approx(
        np.linalg.norm(nominal[probe[1]] - nominal[probe[2]])
    )


def test_the_derivative_of_reflectors_is_that_of_differences(station: Station) -> None:
    v = vector(station, 2)
    found = station.reflector_derivative(v)
    for k in range(station.size):
        step = 1e-6 * (np.arange(station.size) == k)
        slope = (station.reflectors(v + step) - station.reflectors(v - step)) / 2e-6
        if k < 18:
            assert found[:, :, k] == pytest.approx(slope, abs=1e-8)
        else:  # a small rotation on top of the one at hand: exact at zero
            at_zero = (station.reflectors(step) - station.reflectors(-step)) / 2e-6
            assert station.reflector_derivative(np.zeros(station.size))[:, :, k] == pytest.approx(at_zero, abs=1e-8)
            assert found[:, :, k] == pytest.approx(slope, abs=0.1 * np.abs(slope).max())


def test_readings_are_those_of_a_tracker_at_its_pose(session: Session, station: Station) -> None:
    rng = np.random.default_rng(3)
    base = rng.uniform(-1, 1, (len(session), 3))
    poses = TrackerPoses(Rotation.random(2, random_state=4).as_matrix(), rng.uniform(-3, 3, (2, 3)))
    v = vector(station, 5)
    read, back, by_pose = station.seen(v, base, poses)
    which = np.searchsorted(station.blocks, session.samples.block)
    assert set(which) == {0, 1}
    for k in range(0, len(base), 17):
        b = which[k]
        turn = Rotation.from_rotvec(v[6 * b + 3 : 6 * b + 6]).as_matrix() @ poses.rotation[b]
        origin = poses.origin[b] + v[6 * b : 6 * b + 3]
        assert turn @ read[k] + origin == pytest.approx(base[k], abs=1e-12)
        assert back[k] == pytest.approx(turn.T, abs=1e-14)
    assert not by_pose[:, :, 12:].any()
    zero = np.zeros(station.size)
    at_zero = station.seen(zero, base, poses)[2]
    for k in range(12):
        step = 1e-6 * (np.arange(station.size) == k)
        slope = (station.seen(step, base, poses)[0] - station.seen(-step, base, poses)[0]) / 2e-6
        assert at_zero[:, :, k] == pytest.approx(slope, abs=1e-7)
        assert np.abs(slope).max() > 0.1


def test_the_first_guess_is_the_pose_that_the_readings_were_made_from(session: Session, station: Station) -> None:
    """Points read from known poses, with noise: both poses come back to within it."""
    rng = np.random.default_rng(6)
    true = TrackerPoses(Rotation.random(2, random_state=7).as_matrix(), rng.uniform(-3, 3, (2, 3)))
    which = np.searchsorted(station.blocks, session.samples.block)
    at = np.einsum("nij,nj->ni", true.rotation[which], session.samples.position) + true.origin[which]
    found = station.placed(at + 1e-5 * rng.normal(size=at.shape))
    assert found.rotation == pytest.approx(true.rotation, abs=1e-4)
    assert found.origin == pytest.approx(true.origin, abs=1e-4)
    exact = station.placed(at)
    assert station.seen(np.zeros(station.size), at, exact)[0] == pytest.approx(session.samples.position, abs=1e-9)


def test_one_point_gives_a_shift_and_no_turn() -> None:
    rotation, origin = rigid_fit(np.array([[1.0, 2.0, 3.0]]), np.array([[0.5, 2.5, 3.0]]))
    assert np.array_equal(rotation, np.eye(3))
    assert origin == pytest.approx([-0.5, 0.5, 0.0])
