"""URScript in: real programs, what is read, and what is refused in which line."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.read_text import read_text
from tests.oracles.robot_programs import script
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.interpreting.arcs import with_arcs

A, B, C = "p[0.1, 0, 0, 3.14159265, 0, 0]", "p[0.2, 0.05, 0, 0, 3, 0]", "p[.3,0,0,1e-1,0,0]"
Q = "[0, -1.57, 1.57, 0, 0.5, -0.1]"

read = partial(read_text, "test.script")


def test_moves_and_what_they_carry(tmp_path):
    lines = [
        f"movej({Q}, a=1.4, v=0.35)",
        f"movej({A})  # near # it",
        f"movel({B}, a=1.2, v=0.02, r=0.001)",
        "v_cut = 0.01",
        "global r = v_cut / 2 + 2 * (0.0005 - 0.0005)",
        f"movep({C}, 1.2, v_cut, r)",
        "set_standard_digital_out(1, True)",
        "movel(p[0.1,0,0,0,0,0],1.2,-(-v_cut),0,.003)",
        f"movel({B}, t=2)",
        f"v_rapid = 1\n  movel({A}, v=v_rapid)",
        f"movel({Q}, v=0.5)",
    ]
    t = read(tmp_path, script(*lines))
    assert t.language == "urscript" and t.line.tolist() == [2, 3, 4, 7, 9, 10, 12, 13]
    np.testing.assert_allclose(t.position[1:-1, 0], [0.1, 0.2, 0.3, 0.1, 0.2, 0.1])
    assert np.isnan(t.position[[0, -1]]).all() and t.kind.tolist() == [0, 0, 1, 1, 1, 1, 0, 1]
    np.testing.assert_allclose(t.feed, [np.nan, np.nan, 0.02, 0.01, 0.01, np.nan, np.nan, 0.5])
    np.testing.assert_allclose(t.setting.zones, [0, 0, 0.001, 0.005, 0.003, 0, 0, 0])
    np.testing.assert_allclose(t.setting.joints[0], [0, -1.57, 1.57, 0, 0.5, -0.1])
    np.testing.assert_array_equal(t.setting.workobject.matrix, np.eye(4))
    assert t.setting.tools == {} and not t.tool.any() and set(t.setting.joints) == {0, 7}
    expected = Rotation.from_rotvec([0, 3, 0])
    assert (expected.inv() * Rotation.from_quat(t.quaternion[2], scalar_first=True)).magnitude() < 1e-12
    np.testing.assert_allclose(t.axis[2], -expected.as_matrix()[:, 2], atol=1e-12)
    assert [(e.word, e.pose, e.line) for e in t.events] == [("set_standard_digital_out(1, True)", 4, 8)]


def test_frames_and_tools(tmp_path):
    lines = [
        "f = p[1, 0, 0, 0, 0, 1.5707963267948966]",
        "set_payload(2.5, [0, 0, 0.05])",
        "set_tcp(p[0,0,0.1,0,0,0.5])",
        f"movel(pose_trans(f, {A}), v=0.02)",
        f"w = pose_trans(f, {B})",
        "movel(w, v=0.02)",
        "set_tcp(p[0,0,0.2,0,0,0])",
        "movel(pose_trans(f, pose_trans(p[0,0,1,0,0,0], p[0,1,0,0,0,0])), v=0.02)",
        f"movel({B}, v=0.02)",
    ]
    t = read(tmp_path, script(*lines))
    np.testing.assert_allclose(t.setting.workobject.origin, [1, 0, 0])
    np.testing.assert_allclose(t.position[:2], [[0.1, 0, 0], [0.2, 0.05, 0]], atol=1e-12)
    # computed in the base: (1, 0, 0) + Rz(90) (0, 1, 1) = (0, 0, 1), in the frame (0, 1, 1)
    np.testing.assert_allclose(t.position[2], [0, 1, 1], atol=1e-12)
    np.testing.assert_allclose(t.position[3], [0.05, 0.8, 0], atol=1e-12)
    assert t.tool.tolist() == [1, 1, 2, 2]
    first, second = t.setting.tools[1], t.setting.tools[2]
    np.testing.assert_allclose(first.frame.rotation, Rotation.from_rotvec([0, 0, 0.5]).as_matrix(), atol=1e-12)
    assert second.frame.origin[2] == 0.2 and second.mass == 2.5 and first.com[2] == 0.05


def test_an_arc(tmp_path):
    lines = ["movel(p[0,0,0,0,0,0], v=0.1)", "movec(p[0.01,0.01,0,0,0,0], p[0.02,0,0,0,0,0.4], a=1, v=0.02, r=0.001)"]
    t = read(tmp_path, script(*lines))
    np.testing.assert_allclose(np.hypot(t.position[:, 0] - 0.01, t.position[:, 1]), 0.01, atol=1e-12)
    assert len(t) > 20 and t.row[-1] == 1 and set(t.line.tolist()) == {2, 3}
    turn = Rotation.from_quat(t.quaternion, scalar_first=True).as_rotvec()[:, 2]
    np.testing.assert_allclose(np.diff(turn), np.diff(turn)[0], atol=1e-9)


def test_poses_that_are_worked_out_from_constants(tmp_path):
    """pose_add adds positions and multiplies rotations, pose_inv inverts, pose_trans composes: by scipy."""
    a, b = [0.1, 0.2, -0.3, 0.4, -1.0, 2.0], [0.05, 0, 0.02, 0.3, 0.1, -0.2]
    u, v = "p" + str(a), "p" + str(b)
    t = read(tmp_path, script(*(f"movel({x}, v=0.1)" for x in (f"pose_add({u}, {v})", f"pose_inv({u})"))))
    ra, rb = (Rotation.from_rotvec(x[3:]) for x in (a, b))
    np.testing.assert_allclose(t.position, [np.add(a[:3], b[:3]), -ra.inv().apply(a[:3])], atol=1e-12)
    got = Rotation.from_quat(t.quaternion, scalar_first=True).as_matrix()
    np.testing.assert_allclose(got, [(ra * rb).as_matrix(), ra.inv().as_matrix()], atol=1e-12)


def test_an_arc_behind_joint_angles_waits_for_the_robot(tmp_path):
    """One pose until forward kinematics give its start; then as many as behind a pose."""
    start = [0.1, -0.05, 0.02, 0, 3.1, 0]
    arc = f"movec({C}, {B}, v=0.02)"
    t = read(tmp_path, script(f"movej({Q})", arc, f"movel({A})"), 1e-4)
    assert t.row.tolist() == [0, 1, 2] and list(t.setting.arcs) == [1]
    position, quaternion = t.position.copy(), t.quaternion.copy()
    position[0], quaternion[0] = start[:3], Rotation.from_rotvec(start[3:]).as_quat(scalar_first=True)
    done = with_arcs(replace(t, position=position, quaternion=quaternion))
    whole = read(tmp_path, script(f"movel(p{start})", arc, f"movel({A})"), 1e-4)
    assert len(done) == len(whole) > 10
    for name in ("position", "quaternion", "axis", "row", "feed"):
        np.testing.assert_allclose(getattr(done, name)[1:], getattr(whole, name)[1:], atol=1e-12)
    assert done.line.tolist() == whole.line.tolist()


def test_functions_run_where_they_are_called(tmp_path):
    text = "def go(x, v):\n  movel(p[x, 0, 0, 0, 0, 0], v=v)\nend\n"
    text += f"def idle():\n  while (True):\n    movel({A})\n  end\nend\n"
    t = read(tmp_path, text + "go(0.5, 0.1)\ngo(0.6, 2 * 0.1)\n")
    np.testing.assert_allclose(t.position[:, 0], [0.5, 0.6])
    np.testing.assert_allclose(t.feed, [0.1, 0.2])
    assert t.line.tolist() == [2, 2]
    assert len(read(tmp_path, f"def only():\n  movel({A}, v=0.1)\nend\n")) == 1  # as sent through a socket


def test_what_decides_about_no_move_is_let_pass(tmp_path):
    lines = [
        "while (get_standard_digital_in(5) != True):\n    sync()\n  end",
        "x = get_actual_tcp_pose()",
        "y = x",
        "if read_input_integer_register(0) == 1:\n    set_digital_out(1, True)\n  else:\n    z = 1\n  end",
        "thread blink():\n    while True:\n      sync()\n    end\n  end",
        f"movel({A}, v=0.1)",
    ]
    t = read(tmp_path, script(*lines))
    assert len(t) == 1 and [e.word[:5] for e in t.events] == ["while", "if re"]


def test_what_polyscope_writes(tmp_path):
    """Its header, its step counter in a thread, its program tree, waypoints as pose and joints."""
    text = """def Finish():
  set_gravity([0.0, 0.0, 9.82])
  set_tcp(p[0.0,0.0,0.1,0.0,0.0,0.0])
  set_payload(2.5, [0.0, 0.0, 0.05])
  set_standard_analog_input_domain(0, 1)
  set_tool_analog_input_domain(0, 1)
  set_analog_outputdomain(0, 0)
  set_tool_voltage(0)
  set_input_actions_to_default()
  set_tool_communication(False, 115200, 0, 1, 1.5, 3.5)
  set_tool_output_mode(0)
  set_runstate_configurable_digital_output_to_value(0, 0)
  set_safety_mode_transition_hardness(1)
  modbus_add_signal("192.168.0.10", 255, 0, 0, "MODBUS_1", False)
  modbus_set_runstate_dependent_choice("MODBUS_1", 0)
  step_count_9e0b = 0.0
  thread Step_Counter_Thread_9e0b():
    while (True):
      step_count_9e0b = step_count_9e0b + 1.0
      sync()
    end
  end
  run Step_Counter_Thread_9e0b()
  global Waypoint_1_p=p[.600000000000, -.2, .3, 0.0, 3.141592653590, 0.0]
  global Waypoint_1_q=[-0.3, -1.6, 2.0, -1.97, -1.57, -0.3]
  global Waypoint_2_p=p[.600000000000, -.2, .25, 0.0, 3.141592653590, 0.0]
  $ 1 "Robot Program"
  $ 2 "MoveJ"
  $ 3 "Waypoint_1" "breakAfter"
  movej(get_inverse_kin(Waypoint_1_p, qnear=Waypoint_1_q), a=1.3962634015954636, v=1.0471975511965976)
  $ 5 "Waypoint_2" "breakAfter"
  movel(Waypoint_2_p, a=1.2, v=0.25)
  watch = run Step_Counter_Thread_9e0b()
  kill watch
  $ 6 "Halt"
  halt
end
"""
    t = read(tmp_path, text)
    assert t.line.tolist() == [30, 32] and t.kind.tolist() == [0, 1] and t.setting.tools[1].mass == 2.5
    np.testing.assert_allclose(t.position, [[0.6, -0.2, 0.3], [0.6, -0.2, 0.25]])
    with pytest.raises(ReadError, match=r"test\.script:37: 'movel.*step_count_9e0b: set in line 19"):
        read(
            tmp_path, text.replace("  halt", "  movel(Waypoint_2_p, v=0.02)\n  movel(Waypoint_2_p, v=step_count_9e0b)")
        )


def test_real_programs(shared, tmp_path):
    folder = shared / "data" / "cam" / "robodk"
    t = read_toolpath(folder / "UniveralRobots.script")
    assert len(t) == 12 and t.kind.sum() == 8 and t.tool.tolist() == [1] * 12
    np.testing.assert_allclose(t.position[3], [-1.1552, 0.474185, 0.13615])
    np.testing.assert_allclose(t.feed[3:11], 0.05)
    np.testing.assert_allclose(t.setting.zones[3:11], 0.001)
    np.testing.assert_allclose(t.setting.joints[2], [-3.831622, -2.007013, -1.342957, -1.224118, 2.230783, 1.418370])
    np.testing.assert_allclose(t.setting.tools[1].frame.origin, [0.05, 0, 0.45])
    t = read_toolpath(folder / "Prog1.script")
    assert len(t) == 5 and t.kind.tolist() == [0, 0, 1, 0, 1] and sorted(t.setting.joints) == [0, 1, 3]
    np.testing.assert_allclose(t.setting.arcs[4][0], [0.768367, -0.048527, 0.8564])
