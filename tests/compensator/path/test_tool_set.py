"""Tools by number: which one a pose calls, and the flange that carries it."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from compensator.path.tool_set import ONE_TOOL, ToolSet
from stiffness.statics.tool import Tool
from tests.compensator.handmade_toolpaths import toolpath
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

SHORT = Tool(Rotation.from_euler("y", 25, degrees=True).as_matrix(), np.array([0.03, -0.02, 0.24]), name="short")
LONG = Tool(Rotation.from_euler("xz", [10, 70], degrees=True).as_matrix(), np.array([0.0, 0.1, 0.4]), name="long")


def poses(numbers: list[int]) -> tuple[Toolpath, Frame]:
    n = len(numbers)
    g = np.random.default_rng(2)
    path = toolpath(g.normal(size=(n, 3)), tool=np.array(numbers, dtype=np.int32))
    return path, Frame(Rotation.random(n, rng=g).as_matrix(), g.normal(size=(n, 3)))


def test_every_pose_hangs_on_the_flange_by_its_own_tool() -> None:
    """The flange, and the tool on it, is the TCP."""
    path, tcp = poses([2, 1, 1, 2, 2])
    flange = ToolSet({1: SHORT, 2: LONG}).flange(path, tcp)
    for k, tool in enumerate([LONG, SHORT, SHORT, LONG, LONG]):
        back = flange.take(k).then(Frame(tool.rotation, tool.position))
        np.testing.assert_allclose(back.matrix, tcp.take(k).matrix, atol=1e-14)


def test_one_tool_for_every_number() -> None:
    """Whatever the file calls; its own number is the one that programs are written with."""
    path, tcp = poses([0, 7, 3])
    tools = ToolSet.of_one(SHORT)
    assert tools.any_number and list(tools.by_number) == [ONE_TOOL] and tools.tool(7) is SHORT and tools.first is SHORT
    assert tools.rows(path) == [(ONE_TOOL, slice(None))]
    back = tools.flange(path, tcp).then(Frame(SHORT.rotation, SHORT.position))
    np.testing.assert_allclose(back.matrix, tcp.matrix, atol=1e-14)


def test_only_tools_in_use_are_asked() -> None:
    """A tool that no pose calls has no rows."""
    path, _ = poses([2, 2])
    ((number, rows),) = ToolSet({1: SHORT, 2: LONG, 3: SHORT}).rows(path)
    assert number == 2 and np.array_equal(rows, [0, 1])
    assert repr(ToolSet({1: SHORT, 2: LONG})) == "ToolSet(short, long)"
