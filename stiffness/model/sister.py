"""A first model of an arm that nobody measured: its own published set, its reducers, or the sets of sister robots.

Stiffness of joints grows with what they carry: K_j = c_j * m g L, with the moving mass m and the reach L. The built-in
sets give c_j, their geometric mean is taken; how far they lie apart (standard deviation s of ln c_j, over the sets) is
the band: the standard deviation of K_j is K_j (1 - exp(-s)), which ends at the low end of one s.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stiffness.effects import BASE, joint_stiffness
from stiffness.model.datasheet import datasheet_model
from stiffness.model.model import ComplianceModel, builtin_model, builtin_models, load_model
from stiffness.robot.load import load_robot
from stiffness.robot.robot import STANDARD_GRAVITY, Robot

Floats = npt.NDArray[np.float64]


def starting_model(robot: Robot, named: str) -> ComplianceModel:
    """A model with a wide band, for a robot whose stiffness is not known.

    Args:
        named: the robot as the model file shall name it.
    """
    if named == robot.name and builtin_model(named) is not None:
        return _with_band(load_model(named, robot.n))
    if robot.reducers is not None and all(r is not None for r in robot.reducers):
        return datasheet_model(robot, named)
    return _of_sisters(robot, named)


def _with_band(known: ComplianceModel) -> ComplianceModel:
    """A published set, which is that of another robot of the type, with the band of the sisters."""
    k = known.values[BASE.name]["k_nm_per_rad"]
    kept = {e: v for e, v in known.sd.items() if e != BASE.name}
    told = {**known.provenance, "band": "assumed as wide as the built-in sets lie apart"}
    sd = {**kept, BASE.name: joint_stiffness.values_of(k * _band(sets()))}
    return replace(known, sd=sd, provenance=told)


def _of_sisters(robot: Robot, named: str) -> ComplianceModel:
    known = sets()
    stiffness = np.exp(np.log(known).mean(axis=0)) * carried(robot)
    return ComplianceModel(
        source="",
        robot=named,
        gravity="uncompensated" if robot.mass is not None else "calibrated-out",
        reference_temperature=20.0,
        base=robot.base,
        tip=robot.tip,
        values={BASE.name: joint_stiffness.values_of(stiffness)},
        sd={BASE.name: joint_stiffness.values_of(stiffness * _band(known))},
        provenance={
            "kind": "assumption",
            "source": f"scaled by moving mass and reach from the sets of {', '.join(builtin_models())}",
            "load_range": "not measured",
            "preload_side": "not known",
            "temperature": "not given",
        },
    )


def sets() -> Floats:
    """(sets, n) stiffness of the joints of the built-in sets, in units of moving mass times g times reach."""
    rows = []
    for name in builtin_models():
        robot = load_robot(name)
        rows.append(load_model(name, robot.n).values[BASE.name]["k_nm_per_rad"] / carried(robot))
    return np.array(rows)


def _band(known: Floats) -> Floats:
    """(n,) standard deviation as a share of the stiffness, below 1."""
    return np.asarray(1.0 - np.exp(-np.log(known).std(axis=0, ddof=1)))


def carried(robot: Robot) -> float:
    """Moving mass times g times reach, N*m; a mass that is not known grows with the cube of the reach."""
    reach = _reach(robot)
    mass = robot.mass
    if mass is None:
        arms = [load_robot(name) for name in builtin_models()]
        dense = [float(a.mass.sum()) / _reach(a) ** 3 for a in arms if a.mass is not None]
        total = float(np.mean(dense)) * reach**3
    else:
        total = float(mass.sum())
    return total * float(np.linalg.norm(STANDARD_GRAVITY)) * reach


def _reach(robot: Robot) -> float:
    """m, as the maker gives it, else the length of the arm stretched out."""
    if robot.reach is not None:
        return robot.reach
    steps = [*robot.before[1:, :3, 3], *robot.after[1:, :3, 3]]
    return float(sum(np.linalg.norm(step) for step in steps))
