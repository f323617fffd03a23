"""What is assumed of a robot and its model, as notes for every summary."""

from __future__ import annotations

from stiffness.model.model import ComplianceModel
from stiffness.robot.robot import Robot
from toolpaths.finding import NOTE, Finding


def assumptions(robot: Robot, model: ComplianceModel) -> list[Finding]:
    """Figures of the robot that no source gives, and stiffness values that nobody measured."""
    notes = [Finding(NOTE, robot.name, text) for text in robot.assumptions]
    if model.provenance.get("kind") == "assumption":
        what = f"the stiffness values are an assumption: {model.provenance.get('source', '')}"
        notes.append(Finding(NOTE, model.source, what))
    return notes
