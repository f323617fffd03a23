"""Local fit: the result of the local method, a record per joint, and the model that it makes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.effects import BASE, preload_softening
from stiffness.errors import ModelError
from stiffness.local_method.printed import Printed
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

RIGID = 1e12  # N*m/rad written for a joint that is not identified, beside identified = false


@dataclass(frozen=True, repr=False, eq=False)
class LoadedState:
    """What the readings of one loaded state give for the joint.

    Attributes:
        source, setup, state: where it was read.
        side: pre-loaded, non-loaded, unknown: the flank that carried the load.
        readings: point -> (reflector, readings under load, readings of state 0).
        force: N. load_lever: m. torque: N*m, their product, J^T W.
        balance: N*m, torque at the deflected posture with the change of gravity: what the stiffness is made of.
        reading_lever: m from the axis to the reflector (L2k, R4); for joint 5 angle per angle.
        turn: rad, deflection of the joint.
        taken_off: other joint (from 1) -> rad that it turned. taken_off_sides: the same -> its flank.
        stiffness: N*m/rad, of this state alone.
        printed: what the paper's print would have given.
    """

    source: str
    setup: int
    state: int
    side: str
    readings: Mapping[str, tuple[str, int, int]]
    force: float
    load_lever: float
    torque: float
    balance: float
    reading_lever: float
    turn: float
    taken_off: Mapping[int, float]
    taken_off_sides: Mapping[int, str]
    stiffness: float
    printed: tuple[Printed, ...]


@dataclass(frozen=True)
class MeasuredValue:
    """A number and its standard deviation, ``sd``."""

    value: float
    sd: float


@dataclass(frozen=True, repr=False, eq=False)
class JointRecord:
    """One joint: ``equation`` of the paper; ``problem`` why it is not identified, empty when it is; ``side`` that its
    stiffness holds for; ``states``; the ``non_loaded`` stiffness and ``ratio`` to the pre-loaded one, where the
    approaches show both; ``notes``."""

    joint: int
    equation: str
    problem: str
    side: str
    states: tuple[LoadedState, ...]
    non_loaded: MeasuredValue | None
    ratio: MeasuredValue | None
    notes: tuple[str, ...]


@dataclass(frozen=True, repr=False, eq=False)
class LocalFit:
    """Joint stiffness by the local method.

    Attributes:
        sessions: it is made of.
        stiffness: (n,) N*m/rad, NaN where not identified. sd: (n,). covariance: (n, n).
        joints: a record per joint.
    """

    sessions: tuple[Session, ...]
    stiffness: Floats
    covariance: Floats
    joints: tuple[JointRecord, ...]

    def __post_init__(self) -> None:
        self.stiffness.setflags(write=False)
        self.covariance.setflags(write=False)

    def __repr__(self) -> str:
        return f"LocalFit({self.sessions[0].robot.name}, {int(self.identified.sum())} joints identified)"

    @property
    def sd(self) -> Floats:
        """(n,) N*m/rad, NaN where not identified."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def identified(self) -> Bools:
        """(n,)."""
        return ~np.isnan(self.stiffness)

    def model(self, robot: str, provenance: Mapping[str, object] | None = None) -> ComplianceModel:
        """As a model of ``robot`` (name or path, as it shall stand in the model file).

        A joint that is not identified is written as rigid, 1e12 N*m/rad with sd 0, and identified = false.

        Raises:
            ModelError: no joint was identified.
        """
        if not self.identified.any():
            why = "; ".join(f"joint {r.joint}: {r.problem}" for r in self.joints)
            raise ModelError(f"{self.sessions[0].source}: no joint is identified: {why}")
        first, known = self.sessions[0], self.identified
        values = {BASE.name: {"k_nm_per_rad": np.where(known, self.stiffness, RIGID)}}
        sd = {BASE.name: {"k_nm_per_rad": np.where(known, self.sd, 0.0)}}
        flags = {BASE.name: known} if not known.all() else {}
        paired = np.array([r.ratio is not None for r in self.joints])
        if paired.any():
            softening = preload_softening.EFFECT.name
            ratio = [MeasuredValue(1.0, 0.0) if r.ratio is None else r.ratio for r in self.joints]
            values[softening] = {"ratio": np.clip([r.value for r in ratio], 0.05, 1.0)}
            sd[softening] = {"ratio": np.array([r.sd for r in ratio])}
        reference = first.reference_temperature
        return ComplianceModel(
            source="",
            robot=robot,
            gravity=first.gravity,
            reference_temperature=20.0 if reference is None else reference,
            base=first.robot.base,
            tip=first.robot.tip,
            values=values,
            sd=sd,
            identified=flags,
            provenance={**self.provenance(), **(provenance or {})},
        )

    def provenance(self) -> dict[str, object]:
        """Where the numbers come from, for the model file."""
        states = [p for r in self.joints for p in r.states]
        forces, torques = [p.force for p in states], [abs(p.torque) for p in states]
        said: dict[str, object] = {
            "kind": "static",
            "method": "local",
            "source": ", ".join(s.source for s in self.sessions),
            "session_sha256": [s.sha256["session"] for s in self.sessions],
            "samples_sha256": [s.sha256["samples"] for s in self.sessions],
            "load_range": f"{_span(forces)} N, {_span(torques)} N*m on the joint",
            "preload_side": "; ".join(f"joint {r.joint}: {r.side}" for r in self.joints if not r.problem),
        }
        missing = [f"joint {r.joint}: {r.problem}" for r in self.joints if r.problem]
        return said | {"not_identified": missing} if missing else said


def _span(numbers: Sequence[float]) -> str:
    low, high = f"{min(numbers):.4g}", f"{max(numbers):.4g}"
    return low if low == high else f"{low} ... {high}"
