"""What every effect does, in plain numpy, written from the physics page and not from the package."""

from __future__ import annotations

from tests.oracles.effects_instruments import INSTRUMENTS
from tests.oracles.effects_joints import JOINTS
from tests.oracles.effects_places import PLACES, compliance
from tests.oracles.effects_process import PROCESS
from tests.oracles.oracle import Joints, Oracle, Place, Step

__all__ = ["ORACLES", "Joints", "Oracle", "Place", "Step", "compliance"]

ORACLES: dict[str, Oracle] = {**JOINTS, **PLACES, **INSTRUMENTS, **PROCESS}
