"""Registration: a frame that misses by what laboratories miss by is found and told, and no effect stands in for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stiffness.diagnosis.diagnose import diagnose
from stiffness.diagnosis.doubts import registration_doubts
from stiffness.identification.placed_station import placed_trackers
from stiffness.identify import identify
from stiffness.session.session import Session
from tests.plant.cell_design import CELLS
from tests.stiffness.diagnosis.sick import UR, sick

SHIFT, TURN = np.array([1.2e-4, -1.5e-4, 0.9e-4]), np.array([1.5e-4, 1.0e-4, -0.4e-4])


def missed(session: Session, shift: np.ndarray = SHIFT, turn: np.ndarray = TURN) -> Session:
    """As read by a tracker whose frame stands ``shift`` (m) and ``turn`` (rad) off the base that is declared."""
    read = (session.samples.position - shift) @ Rotation.from_rotvec(turn).as_matrix()
    return replace(session, samples=replace(session.samples, position=read))


def off(k: np.ndarray) -> float:
    return float(np.abs(k / np.array(CELLS[UR].stiffness) - 1).max())


def test_a_frame_is_as_declared_where_the_readings_allow_it() -> None:
    session = sick("clean").session
    assert session.registered
    fit = identify([session])
    assert not placed_trackers(fit) and registration_doubts(fit) == ()
    assert np.abs(fit.sessions[0].own[:6]).max() < 1e-8 and fit.solution.misfit == 1


def test_a_frame_that_misses_is_estimated_and_told() -> None:
    fit = identify([missed(sick("clean").session)])
    (doubt,) = registration_doubts(fit)
    (pose,) = placed_trackers(fit)
    far = f"{1e3 * np.linalg.norm(pose.origin):.2f} mm"
    assert far in doubt.what and "Register anew" in doubt.what and doubt.where == fit.sessions[0].session.source
    assert fit.solution.misfit == 1 and not fit.lacks
    # about z it turns as joint 1 does, and along z the first link may be longer: those two a drawing takes
    assert np.abs((pose.origin - SHIFT) / pose.origin_sd).max() < 3 and pose.origin_sd[:2].max() < 3e-5
    assert pose.rpy[:2] == pytest.approx(TURN[:2], abs=3e-5)
    assert off(fit.values()["joint-stiffness"]["k_nm_per_rad"]) < 0.03


@pytest.mark.parametrize(("scenario", "added"), [("clean", []), ("payload", ["payload"])])
def test_no_effect_stands_in_for_a_frame_that_misses(scenario: str, added: list[str]) -> None:
    ill = missed(sick(scenario).session)
    said = diagnose([ill], identify([ill]).model(UR, {}))
    assert [a.effect for a in said.added] == added
    assert said.verdict == ("explained" if added else "adequate")
    assert len(registration_doubts(said.last)) == len(placed_trackers(said.last)) == 1


def test_a_diagnosis_takes_a_frame_as_declared_where_the_readings_allow_it() -> None:
    ill = sick("payload").session
    said = diagnose([ill], identify([ill]).model(UR, {}))
    assert said.verdict == "explained" and registration_doubts(said.last) == ()
    assert not placed_trackers(said.last) and np.abs(said.last.sessions[0].own[:6]).max() < 1e-8


def test_a_frame_that_imitates_what_a_model_lacks_is_not_told() -> None:
    """Half a millimetre of sag of a tool that nobody declared: the frame takes what it can."""
    fit = identify([sick("payload", size=6.0).session])
    assert fit.lacks and len(placed_trackers(fit)) == 1 and registration_doubts(fit) == ()
