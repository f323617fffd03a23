"""What is assumed of a robot and its model, and what cell and model leave open: findings for every summary."""

from __future__ import annotations

from compensator.cell.equipped_arm import EquippedArm
from compensator.cell.placement import Placement
from stiffness.effects import BY_NAME
from stiffness.model.counted_twice import REMEDY, counted_twice
from stiffness.model.model import ComplianceModel
from stiffness.robot.robot import Robot
from toolpaths.finding import NOTE, WARNING, Finding

_KINDS = {"assumption": "an assumption", "modal": "from modal tests", "static": "from static tests"}
_TOLD = ("load_range", "preload_side", "temperature")  # of the provenance, with a note on what the values hold for

SPINDLE = "100 to 600"  # mm, of what is mounted on robots that machine


def assumptions(robot: Robot, model: ComplianceModel) -> list[Finding]:
    """Figures of the robot that no source gives, and where the stiffness values come from."""
    notes = [Finding(NOTE, robot.name, text) for text in robot.assumptions]
    kind = model.provenance.get("kind")
    if kind is not None:
        source = model.provenance.get("source", "no source given")
        of = ", ".join(map(str, source)) if isinstance(source, list) else str(source)
        told = [f"{key.replace('_', ' ')}: {model.provenance[key]}" for key in _TOLD if key in model.provenance]
        what = f"the stiffness values are {_KINDS.get(str(kind), str(kind))}: {of}"
        notes.append(Finding(NOTE, model.source, "; ".join([what, *told])))
    return notes


def job_findings(arm: EquippedArm, placement: Placement, sag: str) -> list[Finding]:
    """What the result of a job does not know, and effects of the model that take no part in it.

    Args:
        sag: whether the controller takes the sag of arm and tool off.
    """
    model = arm.model
    found = [*assumptions(arm.robot, model), *_not_applied(arm)]
    if not any(model.sd.get(e.name) for e in arm.effects):
        what = "no standard deviations: how sure the prediction is cannot be said"
        found.append(Finding(NOTE, model.source, what))
    weightless = [t.name for t in placement.tools.by_number.values() if not t.mass]
    if weightless:
        what = "no mass given, its weight is not modelled"
        level = WARNING if sag == "uncompensated" else NOTE
        found.append(Finding(level, f"tool {', '.join(weightless)}", what, "Give mass and com of the tool"))
    twice = [text for tool in placement.tools.by_number.values() for text in counted_twice(model, tool.name, tool.mass)]
    found += [Finding(WARNING, model.source, text, REMEDY) for text in twice]
    bare = [t.name for t in placement.tools.by_number.values() if not t.position.any()]
    if bare:
        what = f"xyz is 0 0 0, the TCP is the flange (a spindle with its cutter is usually {SPINDLE} mm long)"
        found.append(Finding(WARNING, f"tool {', '.join(bare)}", what, "Is the length of the tool missing?"))
    temperature = placement.conditions.temperature
    warm = temperature is not None and temperature != model.reference_temperature
    if warm and not any(e.thermal for e in arm.effects):
        what = "temperature differs from the model's reference; the model has no thermal effect"
        found.append(Finding(NOTE, "", what))
    if sag == "calibrated-out":
        found.append(Finding(NOTE, "gravity", "the controller is taken to know the sag of arm and tool"))
    return [*found, *_accuracy(placement, sag)]


def _accuracy(placement: Placement, sag: str) -> list[Finding]:
    """The controller's own correction: not told, or at odds with what the cell says of the sag."""
    on, place = placement.absolute_accuracy, "controller"
    if on is None:
        what = "whether absolute accuracy or an elasticity option of the controller is on is not known: "
        what += "the sag may be corrected twice, or not at all"
        remedy = "Look it up on the controller, and give [controller] absolute_accuracy = true or false"
        return [Finding(NOTE if placement.conditions.sag else WARNING, place, what, remedy)]
    if on and sag == "uncompensated":
        what = 'absolute_accuracy = true, but gravity = "uncompensated": the sag would be corrected twice'
        return [Finding(WARNING, place, what, 'Give gravity = "calibrated-out"')]
    if not on and sag == "calibrated-out":
        what = 'absolute_accuracy = false, but gravity = "calibrated-out": what else corrects the sag?'
        return [Finding(WARNING, place, what, 'If not, give gravity = "uncompensated"')]
    return []


def _not_applied(arm: EquippedArm) -> list[Finding]:
    """Effects of another tool are missed; those of instruments never act on a path."""
    found = []
    for name in arm.not_applied:
        if BY_NAME[name].scope == "tool":
            what = f"{name} was measured with tool {arm.model.tools[name]!r}, the tool here is {arm.tools.first.name!r}"
            remedy = "name the tools alike where they are the same"
            found.append(Finding(WARNING, arm.model.source, f"{what}: it is not applied", remedy))
        elif BY_NAME[name].scope == "process":
            names = [f"{key} {value!r}" for key, value in _process_of(arm, name) if value]
            held = f"was measured with {', '.join(names) or 'a process without names'}"
            found.append(Finding(NOTE, arm.model.source, f"{name} {held}: it is not applied to this path"))
        else:
            found.append(Finding(NOTE, arm.model.source, f"{name} is of the instruments: it is not applied"))
    return found


def _process_of(arm: EquippedArm, name: str) -> list[tuple[str, str]]:
    return list(zip(("material", "cutter"), arm.model.processes.get(name, ("", "")), strict=True))
