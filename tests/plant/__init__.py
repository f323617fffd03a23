"""An elastic robot on MuJoCo that shares no code and no formula with the packages under test."""

from .arm import Arm, Tool
from .joints import Joints, Memory, Pieces, Stiffening
from .plant import Plant
from .scene import Load, Scene
from .walk import Walk

__all__ = ["Arm", "Joints", "Load", "Memory", "Pieces", "Plant", "Scene", "Stiffening", "Tool", "Walk"]
