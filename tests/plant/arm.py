"""The arm as the plant sees it: read from a robot TOML or a URDF by the plant's own readers."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from .geometry import Array, placement
from .robot_toml import read_toml
from .urdf import read_urdf

STANDARD_GRAVITY = 9.80665  # m/s2


def _zeros() -> Array:
    return np.zeros(3)


@dataclass(frozen=True)
class Tool:
    """What hangs on the flange: TCP (m, rad) and mass (kg) with its centre (m), in the flange frame."""

    xyz: ArrayLike = (0.0, 0.0, 0.0)
    rpy: ArrayLike = (0.0, 0.0, 0.0)
    mass: float = 0.0
    com: ArrayLike = (0.0, 0.0, 0.0)

    @property
    def pose(self) -> Array:
        """(4,4) flange -> TCP."""
        return placement(self.xyz, self.rpy)


@dataclass(frozen=True)
class Arm:
    """L_0 = base, L_k = L_{k-1} before[k-1] Turn(axis[k-1], q_k) after[k-1]; L_n is the flange."""

    name: str
    joint_names: tuple[str, ...]
    before: Array  # (n,4,4)
    axis: Array  # (n,3)
    after: Array  # (n,4,4)
    lower: Array  # (n,) rad
    upper: Array  # (n,) rad
    mass: Array | None  # (n,) kg, None: not known
    com: Array | None  # (n,3) m, in L_k
    tool: Tool = field(default_factory=Tool)
    mount_rpy: Array = field(default_factory=_zeros)  # base in the world, rad

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.axis)

    @property
    def gravity(self) -> Array:
        """(3,) m/s2 in base axes."""
        out: Array = placement(rpy=self.mount_rpy)[:3, :3].T @ np.array([0.0, 0.0, -STANDARD_GRAVITY])
        return out

    def with_masses(self, mass: ArrayLike, com: ArrayLike) -> Arm:
        """The same arm with link masses (n,) kg at com (n,3) m in the link frames."""
        return replace(self, mass=np.array(mass, dtype=float), com=np.array(com, dtype=float))

    @classmethod
    def load(
        cls,
        path: str | Path,
        *,
        tool: Tool | None = None,
        mount_rpy: ArrayLike = (0.0, 0.0, 0.0),
        base: str | None = None,
        tip: str | None = None,
    ) -> Arm:
        """From a robot .toml (tip: one of its own) or a .urdf (base, tip: its links)."""
        path = Path(path)
        fields = read_toml(path, tip) if path.suffix == ".toml" else read_urdf(path, base, tip)
        return cls(**fields, tool=tool or Tool(), mount_rpy=np.array(mount_rpy, dtype=float))
