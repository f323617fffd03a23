"""Where the arm stands while another tool is mounted, and how it goes on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from compensator.path.pose_text import place
from compensator.path.rapid_checks import box_of_cuts
from compensator.solve.compensation import Compensation
from toolpaths.finding import WARNING, Finding
from toolpaths.frame import Frame
from toolpaths.toolpath import Floats
from toolpaths.writing.lines import MOUNT
from toolpaths.writing.program import Order

SPINDLE = 0.05  # m: a tool that stands beside what is cut by less may touch it


def change_findings(c: Compensation, joints: Floats, ordered: Sequence[Order]) -> Iterator[Finding]:
    """Warnings: a tool whose tip stands in what is cut as soon as it is mounted, an arm that turns over for the next.

    Args:
        joints: (N, n) rad, of the program.
        ordered: a tool that lines of the program mount is mounted where they say.
    """
    toolpath, tools = c.path.toolpath, c.job.arm.tools
    elsewhere = {order.pose for order in ordered if order.command.word == MOUNT and order.lines}
    changes = tools.changes(toolpath)
    box = box_of_cuts(toolpath) if changes else None
    for k in changes:
        number = int(toolpath.tool[k])
        if box is not None and k not in elsewhere:
            tool = tools.tool(number)
            flange = Frame.of(c.job.arm.robot.pose(joints[k - 1]))
            tip = flange.then(Frame(tool.rotation, tool.position)).relative_to(c.job.placement.workobject)
            if (depth := box.depth(tip.origin, SPINDLE)) > 0.0:
                what = (
                    f"tool {number} is mounted where the arm stands then: its tip would be {depth * 1e3:.0f} mm below "
                    "the top of what is cut"
                )
                remedy = "Retract further before the change, or let M6 of [program.events] drive to the changer first"
                yield Finding(WARNING, place(toolpath, k), what, remedy)
        if c.job.planner.inverse.labelled and c.path.branch[k] != c.path.branch[k - 1]:
            what = f"the arm goes to another configuration for tool {number}"
            yield Finding(WARNING, place(toolpath, k), what, "See that the joint move to it is free")
