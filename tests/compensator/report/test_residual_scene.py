"""The arm with its residuals: links where they stood, an arrow per reading that counts, the largest set-up first."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from compensator.report.html.arm_scene import drawn_scene, meaning
from compensator.report.scene.residual_scene import ArmReadings, mean_residuals, residual_scene
from stiffness.robot.load import load_robot
from tests.compensator.report.test_scene import unpacked
from toolpaths.frame import Frame

ROBOT = load_robot("ur10")


def readings(**changed: Any) -> ArmReadings:
    """Six readings in two set-ups, one of them left out; those of set-up 7 are the larger ones."""
    q = np.repeat([[0.1, -1.0, 1.2, 0.3, 0.4, 0.5], [-0.4, -1.3, 1.0, 0.2, 0.9, 0.1]], 3, axis=0)
    links = Frame(np.tile(np.eye(3), (6, 7, 1, 1)), np.arange(126.0).reshape(6, 7, 3) / 100)
    given = {
        "q": q, "links": links, "setup": np.array([3, 3, 3, 7, 7, 7]), "reflector": np.array([0, 1, 0, 0, 1, 0]),
        "link": np.array([6, 3, 6, 6, 3, 6]), "at": links.origin[np.arange(6), [6, 3, 6, 6, 3, 6]] + 0.05,
        "before": np.array([[1], [2], [3], [4], [5], [100]]) * [1e-4, 0, 0],
        "after": np.full((6, 3), 1e-5), "sound": np.array([True] * 5 + [False]),
    }  # fmt: skip
    return ArmReadings(**{**given, **changed})


def test_the_largest_set_up_comes_first_with_the_readings_that_count() -> None:
    scene = residual_scene(ROBOT, [readings()])
    assert scene["residuals"]["first"] == [0, 2, 5]
    assert scene["stations"]["title"] == [
        "set-up 7, 2 readings: residual 0.450 mm, 0.017 mm after, on average",
        "set-up 3, 3 readings: residual 0.200 mm, 0.017 mm after, on average",
    ]
    assert unpacked(scene["residuals"]["before"]).reshape(-1, 3)[:, 0] == pytest.approx([4e-4, 5e-4, 1e-4, 2e-4, 3e-4])
    drawn = unpacked(scene["stations"]["nominal"]).reshape(2, 8, 3, 4)
    assert drawn[0, :7, :, 3] == pytest.approx(readings().links.origin[3])
    assert drawn[1, :7, :, 3] == pytest.approx(readings().links.origin[0])
    assert unpacked(scene["joints"]["q"])[:6] == pytest.approx(np.degrees(readings().q[3]), abs=1e-4)


def test_reflectors_stand_on_their_links() -> None:
    balls = [b for b in residual_scene(ROBOT, [readings()])["bodies"] if b["kind"] == "reflector"]
    assert [b["frame"] for b in balls] == [6, 3]
    assert unpacked(balls[0]["vertices"]).reshape(-1, 3).mean(axis=0) == pytest.approx([0.05] * 3, abs=1e-3)


def test_without_a_refined_model_there_is_one_side() -> None:
    scene = residual_scene(ROBOT, [readings(), readings()], refined=False)
    assert "after" not in scene["stations"] and "after" not in scene["residuals"]
    assert scene["stations"]["title"][0] == "session 1, set-up 7, 2 readings: residual 0.450 mm, on average"


def test_the_first_sentence_says_what_it_means_for_a_part() -> None:
    assert mean_residuals([readings()]) == pytest.approx((3e-4, 3**0.5 * 1e-5))
    models = ("the model at hand", "the refined model")
    both = meaning([readings()], refined=True, models=models)
    assert "comes out 0.300 mm off on average with the model at hand, 0.017 mm with the refined model (" in both
    assert "refined" not in meaning([readings()], refined=False, models=models)


def test_a_scene_that_fails_costs_no_page() -> None:
    told: list[str] = []
    assert drawn_scene([readings(link=np.array([9] * 6))], ROBOT, told.append) is None
    assert len(told) == 1 and "everything else is complete" in told[0]
