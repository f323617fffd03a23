"""Doubts: a wrench of wrong sign or unit, a tool without weight, one session twice; and none where all is well."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffness.diagnosis.diagnose import diagnose
from stiffness.diagnosis.doubts import session_doubts, tool_doubts
from stiffness.diagnosis.wrench_scale import wrench_doubt
from stiffness.identification.evaluate import evaluate
from stiffness.identification.fit import Fit
from stiffness.identify import identify
from stiffness.session.session import Session, load_session
from stiffness.session.table import SessionError
from tests.stiffness.bench_lab import Lab
from tests.stiffness.diagnosis.sick import sick

ROBOTS = ("ur10", "abb-irb6600-175-255")


def scaled(session: Session, factor: float) -> Session:
    s = session.samples
    return replace(session, samples=replace(s, load=replace(s.load, wrench=factor * s.load.wrench)))


def springs(session: Session) -> Fit:
    return identify([session], ["joint-stiffness"])


@pytest.fixture(scope="module", params=ROBOTS)
def session(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Session:
    return Lab(request.param).session(tmp_path_factory.mktemp("lab"), 5, setups=12)[0]


@pytest.mark.parametrize(
    ("factor", "said"),
    [
        (-1.0, ["wrong sign"]),
        (1e-3, ["in kN"]),
        (1e3, ["thousand times too large"]),
        (-1e-3, ["wrong sign", "in kN"]),
    ],
)
def test_a_wrench_with_another_sign_or_unit(session: Session, factor: float, said: list[str]) -> None:
    fit = springs(scaled(session, factor))
    first = session_doubts(fit.sessions)[0]
    assert all(word in first.what for word in said)
    assert ("wrong sign" in first.what) == (factor < 0)
    assert first.where == f"{session.samples_file}, columns fx fy fz mx my mz"


def test_a_right_wrench_is_not_doubted(session: Session, tmp_path: Path) -> None:
    assert session_doubts(springs(session).sessions) == ()
    for factor in (0.5, 2.0):  # stiffness is not known to a factor of two
        assert wrench_doubt(springs(scaled(session, factor)).sessions[0]) is None
    loose, _ = Lab("ur10", gap=(2e-3,) * 6).session(tmp_path, 5, setups=8)
    assert wrench_doubt(springs(loose).sessions[0]) is None
    idle = replace(session, samples=replace(session.samples, load=replace(
        session.samples.load, wrench=0 * session.samples.load.wrench)))  # fmt: skip
    assert wrench_doubt(springs(idle).sessions[0]) is None


def test_a_model_is_told_of_the_wrench_too(session: Session) -> None:
    model = springs(session).model(session.robot_name, {})
    found = evaluate(scaled(session, -1.0), model)
    assert "wrong sign" in session_doubts([found.seen])[0].what
    assert session_doubts([evaluate(session, model).seen]) == ()


def test_a_tool_in_metres_is_asked_about(session: Session) -> None:
    """A thousandth of a tool of 300 mm, and of one of 1.5 m; the flange itself and a short tool are right."""
    for z, asked in ((0.0003, "(0, 0, 0.3) mm"), (0.0015, "(0, 0, 1.5) mm"), (0.0, ""), (0.005, "")):
        tool = replace(session.tool, position=np.array([0.0, 0.0, z]))
        found = tool_doubts(replace(session, tool=tool))
        assert [asked in d.what and "metres" in d.what for d in found] == ([True] if asked else [])


def test_a_tool_of_unknown_weight_is_named(session: Session) -> None:
    bare = replace(session, tool=replace(session.tool, mass=None, com=None))
    (found,) = session_doubts(springs(bare).sessions)
    assert found.where == session.source and "tool.mass" in found.what
    known = replace(bare, gravity="calibrated-out")
    assert session_doubts(springs(known).sessions) == ()


def test_one_session_twice_is_refused_under_any_name(tmp_path: Path) -> None:
    first, _ = Lab("ur10").session(tmp_path / "a", 5, setups=4)
    shutil.copytree(tmp_path / "a", tmp_path / "b")
    samples = tmp_path / "b" / "samples.csv"
    head, *rows = samples.read_text().splitlines()
    samples.write_text("\n".join([head, *reversed(rows)]) + "\n")  # another order, the same readings
    again = load_session(tmp_path / "b" / "session.toml")
    other, _ = Lab("ur10").session(tmp_path / "c", 6, setups=4)
    model = identify([first, other], ["joint-stiffness"]).model("ur10", {})
    for twice in ([first, first], [first, other, again]):
        with pytest.raises(SessionError, match="given twice"):
            identify(twice)
        with pytest.raises(SessionError, match="given twice"):
            diagnose(twice, model)


def test_rows_that_came_back_are_not_called_wrong() -> None:
    """What a poorer model left out and the refined one took back is no finding."""
    ill = sick("base-compliance")
    used = np.ones(len(ill.session), dtype=bool)
    used[[40, 41]] = False
    fit = replace(ill.fits, used=(used,)).fit([])
    assert any("left out as wrong" in d.what for d in session_doubts(fit.sessions))
    assert not any("left out as wrong" in d.what for d in session_doubts(fit.sessions, ()))
    line = int(ill.session.samples.line[40])
    (said,) = (d for d in session_doubts(fit.sessions, [(ill.session.source, line)]) if "left out as wrong" in d.what)
    assert said.count == 1 and said.first == line
