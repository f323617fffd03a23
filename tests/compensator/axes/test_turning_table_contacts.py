"""What stands on a table that turns is looked at against all that stands around."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from compensator.cell.job import load_job
from compensator.errors import CompensatorError
from compensator.scene.bodies import bodies_of
from compensator.scene.pairs import pairs_of
from compensator.scene.path_collisions import collisions_along
from compensator.tasks.compensate import compensate_file
from tests.compensator.axes.test_tables_on_the_plant import WORK
from tests.compensator.axes.test_turning_table_files import job, path_on_table, table_of

BAR = {"name": "bar", "box": [[350.0, -20.0, -60.0], [700.0, 20.0, -30.0]], "frame": "workobject"}


def at(angle: float) -> dict[str, object]:
    """A post in the hall where the bar is with the table at an angle, deg: about the work object, near enough."""
    turn = np.radians(angle)
    work = np.array(WORK["xyz"][:2]) - [1650.0, 60.0]
    c, s = np.cos(turn), np.sin(turn)
    x, y = [1650.0, 60.0] + np.array([[c, -s], [s, c]]) @ work
    way = turn + np.radians(WORK["rpy"][2])
    x, y = x + 520.0 * np.cos(way), y + 520.0 * np.sin(way)
    return {"name": "post", "box": [[x - 20.0, y - 20.0, 0.0], [x + 20.0, y + 20.0, 1000.0]], "frame": "base"}


@pytest.mark.parametrize(("begin", "end", "touches"), [(0.0, 60.0, True), (0.0, 20.0, False), (60.0, 130.0, False)])
def test_a_bar_that_sweeps_a_post(tmp_path: Path, begin: float, end: float, touches: bool) -> None:
    """The arm stands; the bar goes from angle to angle, past the post at 40 deg or not."""
    one, path, free, _ = path_on_table(job(tmp_path, scene=[BAR, at(40.0)]), 0.0)
    moved = free.on(path, np.linspace(begin, end, len(path))[:, None])
    q = np.tile(np.radians([170.0, -30.0, 30.0, 0.0, 30.0, 0.0]), (len(path), 1))
    found = collisions_along(one, moved, q)
    names = [set(found.names(a)) for a in found.contacts]
    assert ({"bar", "post"} in names) == touches


def test_pairs_of_a_table_that_is_set_once(tmp_path: Path) -> None:
    """Nothing moves between bar and post there: as it was."""
    one = load_job(job(tmp_path, scene=[BAR, at(40.0)]).cell)
    bodies, settings = bodies_of(one).all, one.placement.surroundings.settings
    named = [{bodies[p.inner].name, bodies[p.outer].name} for on_table in (False, True)
             for p in pairs_of(bodies, one.arm.robot, settings, "cell", on_table=on_table)]  # fmt: skip
    assert named.count({"bar", "post"}) == 1


def test_what_stands_on_the_table_is_kept_away_from_the_hall(tmp_path: Path) -> None:
    """A bar on the table that would sweep a post: refused, or gone about, but never touched."""
    alone = job(tmp_path / "alone", scene=[BAR])
    best = compensate_file(alone.toolpath, alone.cell, alone.out / "c.csv")
    angle = table_of(alone.out / "c.csv")["E2_deg"]
    held = job(tmp_path / "held", scene=[BAR, at(float(np.median(angle)))])
    try:
        done = compensate_file(held.toolpath, held.cell, held.out / "c.csv")
    except CompensatorError as e:
        assert "bar" in str(e) and "post" in str(e)
        return
    assert done.report["collisions"]["contacts"] == []
    least = [one.report["external"]["axes"]["E2"]["least_deg"] for one in (done, best)]
    assert abs(least[0] - least[1]) > 1.0
