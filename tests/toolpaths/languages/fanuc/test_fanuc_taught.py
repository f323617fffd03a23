"""Fanuc .ls in: what hand-taught programs say besides their moves: calls, registers, conditions, external axes."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from tests.oracles.read_text import read_text
from tests.oracles.tp_programs import plain, pose, program
from toolpaths.errors import ReadError
from toolpaths.external_axes import unmodelled
from toolpaths.languages.fanuc import interpreter as fanuc

read = partial(read_text, "test.ls")


def test_calls(tmp_path):
    """Signals pass; behind what may move the arm a J move has to come; what sets a frame is refused."""
    other = tmp_path / "tcp_on.LS"
    straight = plain("  CALL TCP_On", "L P[1] 5mm/sec FINE")
    assert [e.word for e in read(tmp_path, straight).events] == ["CALL TCP_On"]  # not beside: let pass
    other.write_text(program(["  !on", "  DO[1]=ON", "  WAIT .50(sec)", "  END"]))
    assert [e.word for e in read(tmp_path, straight).events] == ["CALL TCP_On"]
    for line in ("L P[1] 5mm/sec FINE", "  IF DI[1]=ON,DO[1]=OFF", "  CALL DEEPER"):
        other.write_text(program([line], pose(1, 3)))
        with pytest.raises(ReadError, match=r"starts where CALL TCP_On .* in line 5 of it\) leads") as bad:
            read(tmp_path, straight)
        assert bad.value.line == 6
        t = read(tmp_path, plain("  CALL TCP_On", "J P[4] 5% FINE", "L P[1] 5mm/sec FINE"))
        assert t.kind.tolist() == [0, 1]
    other.write_text(program(["  UTOOL[2]=PR[1]"]))
    with pytest.raises(ReadError, match=r"test\.ls:5: CALL TCP_On: that program sets a frame"):
        read(tmp_path, straight)


def test_what_a_called_program_may_set_is_not_known_behind_it(tmp_path):
    lines = ["  R[3]=40", "L P[1] R[3]mm/sec FINE", "  CALL SETUP(1,2)", "L P[2] R[3]mm/sec FINE"]
    np.testing.assert_allclose(read(tmp_path, plain(*lines)).feed, 0.04)
    (tmp_path / "setup.ls").write_text(program(["  R[3]=AR[1]", "  UFRAME_NUM=4"]))
    with pytest.raises(ReadError, match=r"test\.ls:8: the speed R\[3\] is not known"):
        read(tmp_path, plain(*lines))
    t = read(tmp_path, plain("  UFRAME_NUM=1", "  CALL SETUP", "L P[1] 5mm/sec FINE"))
    assert len(t) == 1  # the position itself says which frame has to be active


def test_what_a_hand_taught_program_says_besides(tmp_path):
    """Registers, conditions about signals, a home position in a register, what a move sets off on its way."""
    t = read(
        tmp_path,
        plain(
            "J PR[1:home] 100% FINE",
            "  R[2:feed, mm]=12.5",
            "  R[7]=(-1)",
            "  R[2]=R[9]",
            "  R[2]=25",
            "J P[4] 50% CNT100",
            "L P[1] R[2:feed]mm/sec FINE TB   .10sec,DO[3]=ON",
            "  IF DI[1:clamp]=OFF,CALL ALARM(2)",
            "  IF (DI[1] OR R[4]=2) THEN",
            "  R[9]=R[9]+1",
            "  UALM[1]",
            "  ELSE",
            "  ABORT",
            "  ENDIF",
            "L P[2] 7cm/min CNT100 ACC50 DB 10.0mm,DO[3]=OFF",
            "J P[4] 50% FINE Offset,PR[2]",
            "J PR[1:home] 100% FINE",
        ),
    )
    assert t.kind.tolist() == [0, 1, 1] and t.line.tolist() == [10, 11, 19]
    np.testing.assert_allclose(t.feed[1:], [0.025, 0.07 / 60])
    words = [e.word for e in t.events]
    assert words[0] == "J PR[1:home] 100% FINE" and "IF DI[1:clamp]=OFF,CALL ALARM(2)" in words and "ABORT" in words
    with pytest.raises(ReadError, match=r"test\.ls:7: the speed R\[2\] is not known"):
        read(tmp_path, plain("  R[2]=9", "  IF DI[1]=ON,R[2]=5", "L P[1] R[2]mm/sec FINE"))
    with pytest.raises(ReadError, match=r"test\.ls:6: an IF without its ENDIF"):
        read(tmp_path, plain("L P[1] 5mm/sec FINE", "  IF (DI[1]) THEN", "  DO[1]=ON"))


def _outside(*values, where="E1={:10.3f}  mm"):
    """A J move and L moves through positions 1, 2 ... with an external axis at ``values``."""
    head = ",\n\t" if where[0] == "E" else "\n   GP2:\n\tUF : 0, UT : 1,\n\t"
    records = "".join(pose(k, 10 * k, more=head + where.format(v)) for k, v in enumerate(values, 1))
    return ["J P[1] 5% FINE", *[f"L P[{k}] 5mm/sec FINE" for k in range(2, len(values) + 1)]], records


@pytest.mark.parametrize("where", ["E1={:10.3f}  mm", "E1={:10.3f} deg", "J1={:10.3f} deg", "J1={:10.3f}  mm"])
def test_external_axes_pass(tmp_path, where):
    name = f"{'GP2 ' if where[0] == 'J' else ''}{where[:2]}"
    t = read(tmp_path, program(*_outside(600, 600, 600, where=where)))
    assert len(t) == 3 and t.setting.external[name].tolist() == [600] * 3
    lines, records = _outside(600, 600, 600.5, where=where)
    assert read(tmp_path, program(lines, records)).setting.external[name].tolist() == [600, 600, 600.5]
    lines, records = _outside(600, 600, 700, 700, where=where)
    lines = [*lines[:2], "J P[3] 5% FINE", "L P[4] 5mm/sec FINE"]
    t = read(tmp_path, program(lines, records))
    assert dict(unmodelled(t.setting.external, t.kind == 1))[name].startswith("moves between 600 and 700")
    lines, records = _outside(0, 600, 600, where=where)
    t = read(tmp_path, program(["J P[1] 5% FINE", "J PR[1] 5% FINE", "J P[2] 5% FINE", lines[2]], records))
    assert t.setting.external[name].tolist() == [0, 600, 600]


def test_a_position_that_was_never_taught_matters_where_it_is_used(tmp_path):
    empty = pose(7, 1).replace("    1.000", " ********")
    text = plain("L P[1] 5mm/sec FINE", "L P[7] 5mm/sec FINE").replace("/END", empty + "/END")
    with pytest.raises(ReadError, match=r"test\.ls:6: P\[7\] was never taught"):
        read(tmp_path, text)
    assert len(read(tmp_path, text.replace("L P[7]", "L P[2]"))) == 2


def test_many_calls_of_one_program_are_looked_up_once(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(fanuc, "called", lambda folder, name: asked.append(name))
    t = read(tmp_path, plain(*["  CALL GUN_ON", "L P[1] 5mm/sec FINE", "  CALL GUN_OFF", "L P[2] 5mm/sec FINE"] * 9))
    assert len(t) == 18 and asked == ["GUN_ON", "GUN_OFF"]
