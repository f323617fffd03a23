"""An elastic robot on MuJoCo that shares no code and no formula with the packages under test."""

from .arm import Arm, Tool
from .joints import Friction, Joints, Memory, Pieces, Stiffening
from .moment import Moment
from .plant import Plant
from .scene import Load, Scene
from .walk import Walk
from .wear import Wear
from .worn_plant import WornPlant

__all__ = [
    "Arm",
    "Friction",
    "Joints",
    "Load",
    "Memory",
    "Moment",
    "Pieces",
    "Plant",
    "Scene",
    "Stiffening",
    "Tool",
    "Walk",
    "Wear",
    "WornPlant",
]
