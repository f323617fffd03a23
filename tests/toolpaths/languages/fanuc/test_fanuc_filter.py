"""Fanuc .ls in place: a diff shows only poses; what is split, put in or straightened is listed."""

from __future__ import annotations

import difflib
import re
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from tests.oracles.commanded import changed_lines, commanded, read_again
from tests.oracles.commanded import run as run_filter
from tests.oracles.tp_programs import ARC, JOINTS, SOURCE, program, record

run, again = partial(run_filter, "test.ls"), partial(read_again, "test.ls")


def test_positions_of_other_moves_are_split(tmp_path):
    """P[1] (also of a joint move) and P[2] (used twice) stay; the columns stay as well."""
    shift = np.array([1.25e-4, -3.1e-5, 7.7e-5])
    _, _, done = run(tmp_path, SOURCE, lambda t: commanded(t, None, shift, (1e-4, 2e-4, 0)))
    _, came = changed_lines(SOURCE.encode(), done.text)
    assert [x for x in came if x.startswith("    :")] == ["    :  !compensated by ;", "    :  !toolpath-compensator ;"]
    assert [x.split(":", 1)[1] for x in came if "L P" in x] == [
        "L P[6] 20mm/sec CNT10 ;",
        "L P[7] 20mm/sec CNT100 ;",
        "L P[8] 20mm/sec CNT100 ;",
    ]
    # but where five decimals need one more: a space remains between = and the number
    assert [len(x) for x in came if x[0] == "\t"][:4] == [57, 57, 57, 57] and "W = -179.9" in done.text.decode()
    assert [(f.what.split(",")[0], f.count) for f in done.changes] == [("a position that other moves use", 3)]
    assert done.changes[0].level == "note" and str(done.changes[0]).startswith("test.ls:7")


def test_poses_put_in(tmp_path):
    """Two poses between P[2] and P[3]; only they are new, in a line like P[3]'s without a stop."""

    def make(t):
        at = np.arange(len(t))
        made, row = commanded(t, [*at[:4], 4 - 1, 4 - 1, *at[4:]], 0.0)
        position = made.position.copy()
        k = int(np.flatnonzero(row == 3)[0])
        position[k : k + 2] = position[k - 1] + np.array([[0.0, 0.01, 0.0], [1e-5, 0.02, 0.0]])
        rows = row.copy()
        rows[k : k + 2] = [2.25, 2.5]
        return replace(made, position=position), rows

    t, _, done = run(tmp_path, SOURCE, make)
    new = again(tmp_path, done)
    assert len(new) == len(t) + 2
    np.testing.assert_allclose(new.position[3:5], [[0.2, 0.01, 0], [0.20001, 0.02, 0]], atol=1e-9)
    np.testing.assert_allclose(np.delete(new.position, [3, 4], axis=0), t.position)
    text = done.text.decode()
    assert (
        "    :L P[6] 7cm/min CNT100 ACC50 ;\n    :L P[7] 7cm/min CNT100 ACC50 ;\n   6:L P[3] 7cm/min FINE ACC50 ;\n"
        in text
    )
    assert len(text) - len(SOURCE) == len(
        "".join(x[2:] + "\n" for x in difflib.ndiff(SOURCE.splitlines(), text.splitlines()) if x.startswith("+ "))
    )
    assert [(f.what, f.count) for f in done.changes] == [("poses were put in", 2)]


def test_a_via_point_that_others_use_is_split(tmp_path):
    text = ARC.replace("L P[4] 9mm/sec", "L P[2] 9mm/sec")
    t, made, done = run(tmp_path, text, lambda t: commanded(t, None, np.array([0, 0, 1e-4])), 1e-4)
    new = again(tmp_path, done, 1e-4)
    np.testing.assert_allclose(new.position, made.position, atol=2e-7)
    assert "C P[5]\n    :  P[3:end] 20mm/sec" in done.text.decode() and len(new) == len(t)
    assert done.changes[0].what == "a position that other moves use, too, was split"


def test_an_arc_with_a_pose_put_in_becomes_lines(tmp_path):
    """Where a joint turns around; they pass the new positions and end as the arc did."""

    def make(t):
        made, row = commanded(t, np.sort([*np.arange(len(t)), 2]), np.array([0.0, 0.0, 1e-4]))
        row = row.copy()
        row[2] -= 0.01
        return made, row

    t, made, done = run(tmp_path, ARC, make, 1e-4)
    new = again(tmp_path, done, 1e-4)
    np.testing.assert_allclose(new.position, made.position, atol=0.51e-7)
    out = done.text.decode()
    assert "C P" not in out and "\n   2:L P[3:end] 20mm/sec CNT50 ;\n" in out
    assert "    :L P[5] 20mm/sec CNT100 ;" in out
    assert [f.what for f in done.changes] == ["an arc became straight lines"] and len(new) == len(t) + 1 > 5


def test_a_straight_move_to_joint_angles(tmp_path):
    joints = JOINTS.replace("J6=     5.000", "J6=   179.900")
    text = program(["L P[1] 20mm/sec FINE", "L P[3:home] 20mm/sec CNT50"], record(1, 0, 0) + joints)

    def make(t):
        made, row = commanded(
            replace(
                t,
                position=np.nan_to_num(t.position, nan=0.3),
                quaternion=np.where(np.isnan(t.quaternion), [1, 0, 0, 0], t.quaternion),
            ),
            [0, 1],
            0.0,
        )
        turned = np.radians([[0] * 6, [0, 0, 0, 0, 5, -179.8]])  # a whole turn off the file's
        nominal = np.radians([[0] * 6, [0, 0, 0, 0, 5, -180.1]])
        return replace(made, joints=turned, nominal_joints=nominal), row

    _, _, done = run(tmp_path, text, make)
    new = again(tmp_path, done)
    np.testing.assert_allclose(new.position[1], 0.3)
    assert "CONFIG : 'F U T, 0, 0, 1'" in done.text.decode() and new.setting.joints == {}


def test_lines_put_in_do_not_repeat_what_a_move_sets_off(tmp_path):
    text = program(
        ["L P[1] 20mm/sec FINE", "L P[3] 7cm/min FINE ACC50 TB   .10sec,DO[3]=ON"],
        "".join([record(1, 100, 0), record(3, 200, 50)]),
    )

    def make(t):
        made, _ = commanded(t, [0, 1, 1], 0.0)
        position = made.position.copy()
        position[1] = [0.15, 0.02, 0.0]
        return replace(made, position=position), np.array([0.0, 0.5, 1.0])

    _, _, done = run(tmp_path, text, make)
    assert "    :L P[4] 7cm/min CNT100 ACC50 ;\n" in done.text.decode()
    assert done.text.count(b"DO[3]=ON") == 1


def test_external_axes_stay_and_come_along(tmp_path):
    """A rail in group 1 and a table in group 2, untouched; poses that are put in stand there, too."""
    table = "\n   GP2:\n\tUF : 0, UT : 1,\n\tJ1=   -30.000 deg,\tJ2=    90.000 deg"
    more = ",\n\tE1=   600.000  mm,\tE2=    10.000 deg" + table
    records = "".join(record(n, x, 0).replace(" deg\n}", f" deg{more}\n}}") for n, x in ((1, 100), (2, 200), (3, 300)))
    text = program(["J P[1] 20% FINE", "L P[2] 20mm/sec FINE", "L P[3] 7cm/min FINE"], records)

    def make(t):
        made, _ = commanded(t, [0, 1, 1, 2], np.array([0, 0, 1e-4]))
        position = made.position.copy()
        position[1] = [0.15, 0.02, 0.0]
        return replace(made, position=position), np.array([0.0, 0.5, 1.0, 2.0])

    t, _, done = run(tmp_path, text, make)
    assert t.setting.external["E1"].tolist() == [600] * 3 and t.setting.external["GP2 J2"].tolist() == [90] * 3
    assert done.text.decode().count(more) == 4 and b"P[4]{" in done.text
    new = again(tmp_path, done)
    assert [v.tolist() for v in new.setting.external.values()] == [[600] * 4, [10] * 4, [-30] * 4, [90] * 4]


def test_several_frames_and_tools(tmp_path):
    """Every position is corrected in its own user frame; the frames and tools stay."""
    frames = {1: (100, 200, 300, 0, 0, 90), 3: (-50, 20, 10, 10, -20, 30)}
    tools = {2: (0, 0, 150, 0, 30, 0), 4: (10, -5, 220, 0, 0, 45)}
    lines = []
    for word, table in (("UFRAME", frames), ("UTOOL", tools)):
        for number, values in table.items():
            lines += [f"  PR[5,{k}]=" + (f"({v})" if v < 0 else f"{v}") for k, v in enumerate(values, 1)]
            lines.append(f"  {word}[{number}]=PR[5]")
    lines += ["  UFRAME_NUM=1", "  UTOOL_NUM=2", "L P[1] 20mm/sec FINE", "L P[2] 20mm/sec FINE"]
    lines += ["  UFRAME_NUM=3", "  UTOOL_NUM=4", "J P[3] 20% FINE", "L P[4] 20mm/sec FINE"]
    records = [record(1, 10, 0), record(2, 20, 5), record(3, 0, 7), record(4, 5, 9)]
    records[2:] = [r.replace("UF : 1, UT : 2", "UF : 3, UT : 4") for r in records[2:]]
    text = program(lines, "".join(records))
    shift, turn = np.array([1e-4, -2e-4, 3e-4]), (1e-4, 2e-4, -1e-4)
    t, made, done = run(tmp_path, text, lambda t: commanded(t, None, shift, turn))
    new = again(tmp_path, done)
    cut = t.kind == 1
    assert t.tool.tolist() == [2, 2, 4, 4] and sorted(t.setting.tools) == [2, 4] and cut.sum() == 3
    np.testing.assert_allclose(new.position[cut], made.position[cut], atol=0.51e-7 * 3**0.5)
    got = Rotation.from_quat(new.quaternion[cut], scalar_first=True).as_matrix()
    np.testing.assert_allclose(got, made.rotation[cut], atol=3e-7)
    # the last one by hand: what has to stand in its record, in frame 3
    turned = Rotation.from_euler("xyz", frames[3][3:], degrees=True).as_matrix()
    main = Rotation.from_euler("xyz", frames[1][3:], degrees=True).as_matrix()
    expected = np.array([5, 9, 0]) + turned.T @ main @ shift * 1e3
    numbers = re.search(r"P\[4\]\{.*?X = *(\S+)  mm,\tY = *(\S+)  mm,\tZ = *(\S+)", done.text.decode(), re.S)
    np.testing.assert_allclose([float(v) for v in numbers.groups()], expected, atol=0.51e-4)


def test_a_real_program_whose_calls_are_beside(shared, tmp_path):
    """They are read and move nothing: no change but X is told or made."""
    name = "Fanuc_R30iA_test_post.ls"
    data = (shared / "data" / "cam" / "robodk_posts" / name).read_bytes()
    for call in ("TCP_On", "TCP_Off"):
        (tmp_path / f"{call}.LS").write_text(program(["  DO[1]=ON"]))
    _, _, done = run(tmp_path, data.decode(), lambda t: commanded(t, np.flatnonzero(t.kind == 1), [1e-4, 0, 0]))
    gone, came = changed_lines(data, done.text)
    assert done.changes == () and len(gone) == 8 and all("X =" in x or "!" in x for x in (*gone, *came))
