"""Weighting: the covariance of readings against its definition reading by reading, and what it makes of offsets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.effects import BASE
from stiffness.identification import weighting
from stiffness.identification.observations import SessionObservations
from stiffness.identification.predicted_readings import PredictedReadings
from stiffness.identification.reading_slopes import ReadingSlopes
from stiffness.identification.session_data import SessionData
from stiffness.identification.unknowns import unknowns
from stiffness.identification.weighting import Weighting
from stiffness.numerics.whitened import Whitened
from stiffness.session.session import Session
from tests.stiffness.identification import many_sided

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
OFFSET = 0.02


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return many_sided.session(tmp_path_factory.mktemp("many"))


@pytest.fixture(scope="module")
def plain(session: Session) -> SessionObservations:
    layout, fixed = many_sided.free()
    return many_sided.observed(session, layout, fixed)


@pytest.fixture(scope="module")
def seen(plain: SessionObservations) -> PredictedReadings:
    return plain.predict(plain.first_state(), np.concatenate([1 / many_sided.STIFFNESS, np.zeros(21)]), slice(6, 27))


def noise(session: Session, seen: PredictedReadings, rows: Index, offset: float) -> Floats:
    """Covariance (3k, 3k) of readings of single reflectors, pair by pair, from what the instruments are said to do."""
    s, sensor = session.samples, session.instruments
    sd = np.array([sensor.force] * 3 + [sensor.torque] * 3)
    c = np.zeros((len(rows), 3, len(rows), 3))
    for i, a in enumerate(rows):
        for j, b in enumerate(rows):
            if a == b:
                c[i, :, j] += np.diag(s.sd[a] ** 2)
            if session.sensor_reading[a] == session.sensor_reading[b]:
                c[i, :, j] += (seen.by_wrench[a] * sd) @ (seen.by_wrench[b] * sd).T
            if s.reflector[a] == s.reflector[b]:
                c[i, :, j] += offset**2 * np.eye(3)
    return c.reshape(3 * len(rows), 3 * len(rows))


def blocks(session: Session, seen: PredictedReadings, offset: float) -> list[Whitened]:
    return Weighting(session, offset).blocks(seen, slice(6, 27), 27)


def single(session: Session, rows: Index) -> Index:
    """Places in a block of readings that are no probe's."""
    return np.flatnonzero(session.group[session.samples.reflector[rows]] < 0)


@pytest.mark.parametrize("offset", [0.0, OFFSET])
def test_the_covariance_of_single_reflectors_is_that_of_its_definition(
    session: Session, seen: PredictedReadings, offset: float
) -> None:
    total = 0
    for block in blocks(session, seen, offset):
        here = single(session, block.rows)
        inner = 3 * len(here)
        expected = noise(session, seen, block.rows[here], offset)
        assert (block.factor @ block.factor.T)[:inner, :inner] == pytest.approx(expected, rel=1e-9, abs=1e-18)
        assert np.count_nonzero(np.abs(expected) > 1e-12) > 3 * inner  # readings share more than their own noise
        r = (session.samples.position - seen.position)[block.rows[here]].reshape(-1)
        assert (block.factor @ block.residual)[:inner] == pytest.approx(r, abs=1e-12)
        total += len(block.rows)
    assert total == len(session)


def test_a_probe_is_read_as_six_numbers(session: Session, seen: PredictedReadings) -> None:
    """Without noise of the wrench: the shift and the turn of its first reflector that fit the nine coordinates best,
    each with its own standard deviation."""
    quiet = replace(session, instruments=replace(session.instruments, force=0.0, torque=0.0))
    s, r = quiet.samples, session.samples.position - seen.position
    probes = quiet.group[s.reflector] >= 0
    for block in blocks(quiet, seen, 0.0):
        mine = block.rows[~probes[block.rows]]
        expected = float(np.sum((r[mine] / s.sd[mine]) ** 2))
        pose_of = {k: (s.state[k], s.block[k], s.repeat[k]) for k in block.rows[probes[block.rows]].tolist()}
        poses = set(pose_of.values())
        for pose in poses:
            members = sorted((k for k, p in pose_of.items() if p == pose), key=lambda k: s.reflector[k])
            lever = np.zeros((3 * len(members), 6))
            for i, k in enumerate(members):
                arm = s.position[k] - s.position[members[0]]
                turned = np.array([np.cross(axis, arm) for axis in np.eye(3)]).T
                lever[3 * i : 3 * i + 3] = np.hstack([np.eye(3), turned])
            six = np.linalg.lstsq(lever, r[members].reshape(-1), rcond=None)[0]
            sd = np.concatenate([s.sd[members[0]], np.full(3, quiet.instruments.tracker_angle)])
            expected += float(np.sum((six / sd) ** 2))
        assert len(poses) > 3
        assert block.residual @ block.residual == pytest.approx(expected, rel=1e-8)
        assert len(block.residual) == 3 * len(mine) + 6 * len(poses)


def test_columns_stand_where_they_are_told(session: Session, seen: PredictedReadings) -> None:
    more = np.random.default_rng(0).normal(size=(len(session), 3, 2))
    for narrow, wide in zip(
        Weighting(session, 0.0).blocks(seen, slice(6, 27), 27),
        Weighting(session, 0.0).blocks(seen, slice(30, 51), 60, [ReadingSlopes.plain(more)]),
        strict=True,
    ):
        assert wide.jacobian.shape[1] == 62
        assert wide.jacobian[:, :6] == pytest.approx(narrow.jacobian[:, :6], rel=1e-9, abs=1e-9)
        assert wide.jacobian[:, 30:51] == pytest.approx(narrow.jacobian[:, 6:27], rel=1e-9, abs=1e-9)
        assert not wide.jacobian[:, 6:30].any() and not wide.jacobian[:, 51:60].any()
        inner = (3 * single(session, wide.rows)[:, None] + np.arange(3)).ravel()
        raw = more[wide.rows].reshape(-1, 2)[inner]
        assert (wide.factor @ wide.jacobian[:, 60:])[: len(inner)] == pytest.approx(raw, abs=1e-12)


def registered(of: Session) -> Session:
    """Readings of single reflectors only."""
    keep = of.group[of.samples.reflector] < 0
    return of.take(np.flatnonzero(keep & (of.samples.repeat == of.samples.repeat.min())))


def test_a_large_offset_leaves_the_displacements(session: Session) -> None:
    """Chi-square with a free offset per reflector is that of the differences to state 0, whose noise they share."""
    some = registered(session)
    layout = unknowns([BASE], 6, [BASE.name])
    fixed = {BASE.name: {"k_nm_per_rad": many_sided.STIFFNESS}}
    data = SessionData.of(some)
    observations = SessionObservations.of(data, Weighting(some, 1.0), layout, fixed)
    state = observations.first_state()
    own = np.zeros(data.station.size)
    seen = observations.predict(state, own, slice(0, len(own)))
    r = some.samples.position - seen.position
    for block in observations.weighting.blocks(seen, slice(0, len(own)), len(own)):
        rows, s = block.rows, some.samples
        c = noise(some, seen, rows, 0.0)
        pairs = [
            (i, int(np.flatnonzero((s.reflector[rows] == s.reflector[a]) & (s.state[rows] == 0))[0]))
            for i, a in enumerate(rows)
            if s.state[a] != 0
        ]
        difference = np.zeros((3 * len(pairs), 3 * len(rows)))
        for k, (i, j) in enumerate(pairs):
            difference[3 * k : 3 * k + 3, 3 * i : 3 * i + 3] = np.eye(3)
            difference[3 * k : 3 * k + 3, 3 * j : 3 * j + 3] = -np.eye(3)
        moved = difference @ r[rows].reshape(-1)
        expected = moved @ np.linalg.solve(difference @ c @ difference.T, moved)
        assert block.residual @ block.residual == pytest.approx(expected, rel=1e-4, abs=1e-4)


def test_offsets_take_up_three_numbers_per_reflector_of_a_setup(session: Session) -> None:
    s, used = session.samples, np.random.default_rng(1).random(len(session)) < 0.6
    pairs = {(int(a), int(b)) for a, b in zip(s.setup[used], s.reflector[used], strict=True)}
    assert Weighting(session, OFFSET).spent(used) == 3 * len(pairs)
    assert Weighting(session, 0.0).spent(used) == 0


def test_only_readings_in_use_are_weighted(session: Session, seen: PredictedReadings) -> None:
    used = session.samples.setup != session.samples.setup[0]
    used &= ~((session.samples.state == 2) & (session.samples.repeat == 1))  # whole poses of the probe
    some = replace(seen, state=replace(seen.state, used=used))
    rows = np.concatenate([b.rows for b in Weighting(session, 0.0).blocks(some, slice(6, 27), 27)])
    assert sorted(rows.tolist()) == np.flatnonzero(used).tolist()
    for block in Weighting(session, 0.0).blocks(some, slice(6, 27), 27):
        assert len(set(session.samples.setup[block.rows].tolist())) == 1


def test_large_setups_are_cut(session: Session, seen: PredictedReadings, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = blocks(session, seen, 0.0)
    monkeypatch.setattr(weighting, "LARGEST_BLOCK", 20)
    cut = blocks(session, seen, 0.0)
    assert max(len(b.rows) for b in cut) <= 20 < max(len(b.rows) for b in whole)
    assert sorted(np.concatenate([b.rows for b in cut]).tolist()) == list(range(len(session)))


def test_deletion_asks_each_reading_and_each_pose_of_a_probe(session: Session, seen: PredictedReadings) -> None:
    weights = Weighting(session, 0.0)
    for block in weights.blocks(seen, slice(6, 27), 27):
        rows, chi2, freedom = weights.deletion(block)
        assert sorted(np.concatenate(rows).tolist()) == sorted(block.rows.tolist())
        poses = [r for r in rows if len(r) > 1]
        assert all(len(r) == 3 and session.group[session.samples.reflector[r]].min() >= 0 for r in poses)
        assert freedom.tolist() == [3.0 if len(r) == 1 else 6.0 for r in rows]
        assert len(chi2) == len(rows) and np.all(chi2 >= 0)


def test_a_wrong_row_has_the_largest_deletion(session: Session, seen: PredictedReadings) -> None:
    """Moved by ten standard deviations, from what is predicted: it stands out by itself, whatever else is there."""
    rng = np.random.default_rng(4)
    position = seen.position + session.samples.sd * rng.normal(size=seen.position.shape)
    wrong = int(np.flatnonzero(session.group[session.samples.reflector] < 0)[7])
    position[wrong, 1] += 10 * session.samples.sd[wrong, 1]
    spoiled = replace(session, samples=replace(session.samples, position=position))
    weights = Weighting(spoiled, 0.0)
    found: list[tuple[float, Index]] = []
    for block in weights.blocks(seen, slice(6, 27), 27):
        rows, chi2s, _ = weights.deletion(block)
        found += [(float(c), r) for c, r in zip(chi2s, rows, strict=True) if len(r) == 1]
    chi2, row = max(found, key=lambda f: f[0])
    assert row.tolist() == [wrong]
    assert chi2 == pytest.approx(100, abs=60)
