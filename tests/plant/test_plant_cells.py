"""Scenarios as files: sizes, seeds, designs, and that nothing leaks from the truth into them."""

from __future__ import annotations

import csv
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from .ailment import Ailment
from .cell_design import CELLS, NOISE, design
from .cells import PAIRS, SCENARIOS, SESSIONS, SINGLE, Case, Scenario, pair, write
from .geometry import Array
from .hand import Day
from .plant import Plant
from .sizing import rms
from .walk import Walk
from .wear import Wear
from .worn_plant import WornPlant

ARMS = tuple(CELLS)
CATALOGUE = {
    *("preload-softening", "backlash", "joint-hardening", "joint-friction", "joint-coupling", "posture-stiffness"),
    *("kinematic-offset", "gravity-compensator", "payload", "base-compliance", "link-compliance", "tool-compliance"),
    *("thermal-drift", "tracker-drift", "force-sensor-bias"),
}


def rows(path: Path) -> list[dict[str, str]]:
    with path.with_name("samples.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def column(path: Path, *names: str) -> Array:
    return np.array([[float(row[c]) for c in names] for row in rows(path)])


def files(case: Case) -> dict[str, bytes]:
    return {f"{n} {f.name}": f.read_bytes() for n, p in case.paths.items() for f in sorted(p.parent.iterdir())}


@pytest.mark.parametrize("arm", ARMS)
def test_healthy_cell_is_the_plain_plant(arm: str) -> None:
    cell = CELLS[arm]
    plan = design(cell, 4, 3)
    q = np.array([s.q for s in plan])
    w = np.array([[*s.steps[2].force, *s.steps[2].moment] for s in plan])
    walks: list[Walk] = [
        plant.walk(q, w)
        for plant in (Plant(cell.arm, stiffness=np.array(cell.stiffness)), WornPlant(cell.arm, cell.healthy))
    ]
    np.testing.assert_allclose(walks[1].links, walks[0].links, atol=1e-12)
    np.testing.assert_allclose(walks[1].nominal, walks[0].nominal, atol=1e-15)
    np.testing.assert_allclose(walks[1].torque, walks[0].torque, atol=1e-7)
    assert np.abs(walks[0].deflection).max() > 1e-4


@pytest.mark.parametrize("name", SINGLE)
def test_an_ailment_of_no_size_does_nothing_and_one_of_some_size_does(name: str) -> None:
    day = Day(setups=2)
    for s, expected in ((0.0, False), (0.5, True)):
        wear, values = SINGLE[name].apply(day.cell.healthy, day.cell.arm, s)
        notes = day.measured(wear)
        seen = day.column(*"xyz", "fx", "mz", notes=notes) - day.column(*"xyz", "fx", "mz")
        assert (np.abs(seen).max() > 1e-6) == expected
        if not expected:
            assert np.abs(seen).max() < 1e-10
        assert values and not np.isnan(list(values.values())).any()


def test_every_effect_of_the_catalogue_is_there_and_six_that_are_in_none() -> None:
    assert {a.effect for a in SINGLE.values()} == CATALOGUE | {"unknown"}
    assert sum(not a.known for a in SINGLE.values()) == 6
    assert SCENARIOS["clean"].effects == ()
    assert SCENARIOS["backlash joint-1 + tool-compliance"].effects == (
        ("backlash", ("joint-1",)),
        ("tool-compliance", ("tool",)),
    )
    assert len(PAIRS) >= 10 and all({SINGLE[a].effect for a in p} != {SINGLE[p[0]].effect} for p in PAIRS)


@pytest.mark.parametrize(
    ("name", "arm", "size"),
    [
        ("backlash joint-3", "ur10", 3.0),
        ("thermal-drift link-2 joint-2", "abb-irb6600-175-255", 1.5),
        ("joint-friction joint-1", "kuka-kr210-r2700", 5.0),
        ("tracker-drift", "ur10", 10.0),
    ],
)
def test_size_is_what_it_changes_over_the_noise_floor(name: str, arm: str, size: float, tmp_path: Path) -> None:
    # noise of a seed is the same whatever the cell: the difference of two files is free of it
    ill = write(SCENARIOS[name], tmp_path / "ill", 4, arm, size=size, sessions=("D", "A_healthy"))
    well = write(SCENARIOS["clean"], tmp_path / "well", 4, arm, sessions=("D", "A_healthy"))
    change = 1e-3 * (column(ill.paths["D"], *"xyz") - column(well.paths["D"], *"xyz"))
    assert rms(change) == pytest.approx(size * ill.floor, rel=0.011)
    (truth,) = ill.truth
    assert truth.change == pytest.approx(rms(change), rel=1e-3)
    assert 0 < truth.left <= truth.change
    assert NOISE.tracker <= ill.floor < 1.2 * NOISE.tracker
    before = {
        name: files(case)[f"A_healthy {name}"] for case in (ill, well) for name in ("samples.csv", "session.toml")
    }
    assert all(files(ill)[f"A_healthy {n}"] == b for n, b in before.items())


def test_size_may_be_what_joint_stiffnesses_leave(tmp_path: Path) -> None:
    case = write(SINGLE_3, tmp_path, 1, "ur10", size=2.0, of="left", sessions=("D",))
    (truth,) = case.truth
    assert truth.left == pytest.approx(2 * case.floor, rel=0.011)
    assert truth.change > 1.2 * truth.left
    # by hand: least squares on the six columns dx/d(1/K), from the turns of each joint under its own torque
    day = Day("ur10", setups=20, seed=9)
    wear, _ = SINGLE_3.ailments[0].apply(day.cell.healthy, day.cell.arm, truth.factor)
    change = day.change(wear).ravel()
    A = np.array([day.turned(k, day.torque(k)).ravel() for k in range(1, 7)]).T
    rest = change - A @ np.linalg.lstsq(A, change, rcond=None)[0]
    assert rms(rest) / rms(change) == pytest.approx(truth.left / truth.change, rel=0.25)  # other postures


SINGLE_3 = Scenario("bump", (SINGLE["posture-stiffness joint-3"],))


def test_a_seed_is_a_session_and_another_seed_another(tmp_path: Path) -> None:
    scenario = pair("joint-coupling joint-2 joint-3", "payload")
    a, b = (write(scenario, tmp_path / k, 7, "abb-irb6600-175-255", size=3.0, sessions=("B", "D")) for k in "ab")
    assert files(a) == files(b)
    assert a.truth == b.truth
    other = write(scenario, tmp_path / "c", 8, "abb-irb6600-175-255", size=3.0, sessions=("D",))
    assert abs(column(other.paths["D"], "q1") - column(a.paths["D"], "q1")).max() > 1
    text = b"".join(files(a).values())
    assert not any(word in text for word in (b"coupling", b"payload", b"unknown", b"ailment"))


@pytest.mark.parametrize("arm", ARMS)
def test_designs_are_what_a_lab_would_do(arm: str, tmp_path: Path) -> None:
    case = write(SCENARIOS["clean"], tmp_path, 3, arm)
    assert tuple(case.paths) == SESSIONS
    postures = set()
    for path in case.paths.values():
        table, read = tomllib.loads(path.read_text(encoding="utf-8")), rows(path)
        assert 400 <= len(read) <= 950
        setups = {int(r["setup"]) for r in read}
        assert 30 <= len(setups) <= 45
        assert {r["reflector"] for r in read} == {"tcp", "outrigger", "forearm", "upper", "pedestal"}
        assert {r.get("approach1") for r in read} == {"-1", "1"}
        assert table["instruments"] == {"tracker": 0.02, "force": 0.3, "torque": 0.1}
        assert table["registered"] and table["reference_temperature"] == 20.0
        again = [r for r in read if r["repeat"] == "1"]
        assert len(again) == 8 * 5 and {r["state"] for r in again} == {"0"}
        clock = column(path, "time")[:, 0]
        assert clock[-1] == pytest.approx(8000, rel=0.01) and np.all(np.diff(clock) > 0)
        postures |= {r["q1"] for r in read}
        check_loads(column(path, "setup", "state", "fx", "fy", "fz"), CELLS[arm].force)
    assert len(postures) == 36 + 34 + 30 + 34  # no posture twice


def check_loads(table: Array, force: float) -> None:
    """Two levels, up to three directions, and some set-ups that go back to nothing."""
    ends = []
    for number in np.unique(table[:, 0]):
        here = table[table[:, 0] == number]
        size = [np.linalg.norm(here[here[:, 1] == k, 2:].mean(axis=0)) / force for k in range(5)]
        assert size[0] < 0.01 and max(size) == pytest.approx(1, rel=0.02)
        assert {round(s, 1) for s in size} == {0.0, 0.5, 1.0}
        ends.append(size[-1])
    assert 0.25 < np.mean(np.array(ends) < 0.01) < 0.4


def test_later_a_joint_or_a_bolt_has_moved(tmp_path: Path) -> None:
    def moved(name: str) -> tuple[str, Wear, Wear]:
        case = write(SCENARIOS[name], tmp_path / name.replace(" ", ""), 2, "ur10", sessions=("B", "C"))
        return case.later, case.plants["B"].wear, case.plants["C"].wear

    later, before, after = moved("backlash joint-1")
    assert later == "joint-3 stiffness x 0.8"
    np.testing.assert_allclose(after.stiffness / before.stiffness, [1, 1, 0.8, 1, 1, 1])
    assert after.gap[0] == before.gap[0] > 0
    later, before, after = moved("base-compliance")
    assert later == "base compliance x 1.8"
    np.testing.assert_allclose(after.flexures[0].compliance, 1.8 * before.flexures[0].compliance)
    later, before, after = moved("joint-coupling joint-2 joint-3")
    assert later == "joint-1 stiffness x 0.8" and after.ties == before.ties


def test_controller_knows_nothing_of_the_wear() -> None:
    day = Day()
    wear = day.cell.healthy
    for name in ("kinematic-offset joint-3", "kinematic-offset link-3", "tool-compliance", "payload"):
        wear, _ = SINGLE[name].apply(wear, day.cell.arm, 1.0)
    ill, well = WornPlant(day.cell.arm, wear), Plant(day.cell.arm, stiffness=np.array(day.cell.stiffness))
    q = np.array([0.3, 0.2, -0.4, 0.5, 0.7, -0.6])
    np.testing.assert_allclose(ill.nominal(q), well.nominal(q), atol=1e-15)
    poses = np.array([well.nominal(q + 0.01 * k) for k in range(3)])
    np.testing.assert_allclose(ill.follow(poses, q), [q, q + 0.01, q + 0.02], atol=1e-10)
    # run at commands that undo what was measured at the same place: the closed loop of compensation, by iteration
    load, command = [0, 300.0, -500.0, 0, 0, 0], q.copy()
    for _ in range(8):
        walk = ill.run([command], load)
        miss = poses[0] @ np.linalg.inv(walk.tcp[0])
        command = ill.inverse(miss @ ill.nominal(command), command)
    assert max(e[0] for e in ill.run([command], load).errors(poses[:1])) < 1e-9
    assert np.linalg.norm(ill.run([q], load).deflection) > 1e-4


def test_what_cannot_be_so_large_or_be_twice_is_said() -> None:
    day = Day(setups=2)
    with pytest.raises(ValueError, match="coupling of joints 2 and 3 by 6"):
        SINGLE["joint-coupling joint-2 joint-3"].apply(day.cell.healthy, day.cell.arm, 6.0)
    for name in ("tracker-drift", "force-sensor-bias zero", "gravity-compensator"):
        once, _ = SINGLE[name].apply(day.cell.healthy, day.cell.arm, 1.0)
        with pytest.raises(ValueError, match="one cell has one"):
            SINGLE[name].apply(once, day.cell.arm, 1.0)
    odd = replace(SINGLE["payload"], apply=lambda wear, arm, s: (wear, {}))
    assert isinstance(odd, Ailment)
    with pytest.raises(ValueError, match="payload at tool on ur10: 62 um not reached, 0 um"):
        write(Scenario("nothing", (odd,)), Path("unused"), 1, "ur10", size=3.0)
