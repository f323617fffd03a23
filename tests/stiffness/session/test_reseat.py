"""Columns reseat and read1..n: every seat is a reflector of its own, the lag of the servo is a regressor."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffness.diagnosis.regressors import columns
from stiffness.identify import identify
from stiffness.session.session import load_session
from stiffness.session.table import SessionError
from tests.plant import lab
from tests.stiffness.session_desk import TARGETS, Rows, write

SEATS = {"reseat": [0, 0, 2, 2, 2, 0]}


def seated(folder: Path) -> Path:
    """Six set-ups; in three of them ``elbow`` sits 4 mm aside, seat 2; the others were never taken off."""
    write(folder, design={"count": 6}, noise=lab.Noise(1e-5), form=lab.Form(extra=SEATS))
    rows = Rows(folder)
    for row in rows.order:
        if row["reflector"] != "elbow":
            row["reseat"] = "0"
    return rows.write()


def test_every_seat_is_a_reflector_of_its_own(tmp_path: Path) -> None:
    session = load_session(seated(tmp_path))
    names = [r.name for r in session.reflectors]
    assert names == [*(t.name for t in TARGETS), "elbow (reseat 2)"]
    again, first = session.reflectors[3], session.reflectors[1]
    assert (again.link, again.exact, first.exact) == (3, False, True)
    assert again.position == pytest.approx(first.position)
    mine = session.samples.reflector == 3
    assert set(session.samples.setup[mine]) == {3, 4, 5}
    assert not np.isin(session.samples.setup[session.samples.reflector == 1], [3, 4, 5]).any()
    assert "reseat" not in session.samples.extra
    fit = identify([session], ["joint-stiffness", "kinematic-offset"])
    assert fit.sessions[0].reflectors[3] == pytest.approx(first.position, abs=3e-4)
    pairs = session.pairs
    assert np.array_equal(session.samples.reflector[pairs.row], session.samples.reflector[pairs.reference])


@pytest.mark.parametrize(
    ("value", "said"), [("1.5", "expected an integer"), ("-1", "put on anew"), ("", "empty"), ("two", "not a number")]
)
def test_what_counts_nothing_is_refused(tmp_path: Path, value: str, said: str) -> None:
    seated(tmp_path)
    rows = Rows(tmp_path)
    rows.order[7]["reseat"] = value
    with pytest.raises(SessionError, match=r"samples\.csv: row 9, column reseat") as caught:
        load_session(rows.write())
    assert said in str(caught.value)


def test_a_probe_is_put_on_as_a_whole(tmp_path: Path) -> None:
    path = seated(tmp_path)
    text = path.read_text()
    for name, link in (("tcp", 6), ("side", 6)):
        head = f"[reflectors.{name}]\n"
        text = text.replace(f"{head}link = {link}", f'{head}group = "probe"\nlink = {link}')
    path.write_text(text.replace("exact = true", "exact = false"))
    rows = Rows(tmp_path)
    for row in rows.order:
        row["reseat"] = "1" if int(row["setup"]) > 2 else "0"
    session = load_session(rows.write())
    groups = {r.name: r.group for r in session.reflectors}
    assert groups["tcp (reseat 1)"] == groups["side (reseat 1)"] == "probe (reseat 1)"
    assert len(session.reflectors) == 6 and sorted(set(session.group.tolist())) == [-1, 0, 1]
    rows.order[2]["reseat"] = "3"
    with pytest.raises(SessionError, match=r"row 4, column reseat = '3'.*as a whole"):
        load_session(rows.write())


def test_the_angles_read_back_are_a_regressor(tmp_path: Path) -> None:
    write(tmp_path, noise=lab.Noise(1e-5))
    rows = Rows(tmp_path)
    lag = np.linspace(-0.02, 0.03, len(rows.order)).tolist()
    for row, off in zip(rows.order, lag, strict=True):
        for k in range(1, 7):
            row[f"read{k}"] = repr(float(row[f"q{k}"]) + k * off)
    session = load_session(rows.write())
    s = session.samples
    for k in range(6):
        assert s.extra[f"read{k + 1}"] == pytest.approx(np.radians((k + 1) * np.array(lag)), abs=1e-12)
    assert np.degrees(s.q[0, 0]) == pytest.approx(float(rows.order[0]["q1"]))
    assert {f"read{k}" for k in range(1, 7)} <= set(columns(session))
    rows.order[4]["read3"] = repr(float(rows.order[4]["q3"]) + 3.0)
    with pytest.raises(SessionError, match=r"samples\.csv: row 6, column read3 .* from the commanded angle"):
        load_session(rows.write())
    for row in rows.order:
        del row["read6"]
    with pytest.raises(SessionError, match="column read6 missing beside"):
        load_session(rows.write())
