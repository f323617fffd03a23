"""Effect: the contract for one physical cause of deflection.

    X_link_k = X_base D_0 (A_1 R(q_1 + dq_1) D_1) ... (A_k R(q_k + dq_k) D_k)

A_k are the constant placements of the arm, dq_k is the deflection of joint k, D_k = D(d, phi) the small displacement of
place k (0 base, k the end of link k, n flange): it moves what lies outward by d, then turns it by the rotation
vector phi.

An effect fills slots of this equation and nothing else. Every slot is a CasADi expression of its
arguments and of the effect's parameters, so that prediction, compensation and identification read
the same text and take derivatives from it.

    slot     given                                             returns
    joint    JointInput: torque, angle, state, temperature      dq (n,) rad
    angle    commanded angle (n,) rad                           dq (n,) rad, whatever the load
    torque   angle (n,) rad of the links                        tau (n,) N*m of an internal spring
    mass     number of joints                                  point masses on links
    place    PlaceInput: wrench that crosses the place          [d; phi] (6,) m and rad, in its axes
    wrench_reading    ShownWrench: what the sensor shows        the wrench (6,) that acts, same axes
    position_reading  a position (3,) in the tracker's frame, time s   the position (3,) that it shows
    process_wrench    ProgrammedWrench: what a process says     the wrench (6,) that acts, base axes
    surface_reading   deviation of a cut surface, m             the deviation that the part shows

The two readings belong to instruments: they judge data and never act on a planned path. The last two belong to a
process: they hold for one material and one cutter. The wrench of a place is the
generalised force of its six coordinates, so that a symmetric compliance has a potential.

A joint law with memory declares it as a clamp,

    state' = min(max(state + shift, low), high),

one or several per joint, with shift, low and high functions of the commanded moves and torques so far: clamps are
closed under composition, which is what lets a path of a million poses be walked without a Python loop.

Numbers of an effect belong to sites (a joint, a link, a pair of joints, or one place): diagnosis asks of every site
whether it is there. ``neutral`` values are those without effect; ``trials`` are where a search for the others begins.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.memory import Memory

Floats = npt.NDArray[np.float64]
Values = Mapping[str, ca.SX]  # parameter name -> column vector
Numbers = Mapping[str, Floats]
REVERSAL = 1e-6  # rad of travel that counts as a change of direction: 2 um at 2 m
Scope = Literal["robot", "tool", "instruments", "process"]
Size = Literal["joint", "pair", "place"]


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter of an effect, as it stands in the model file.

    Attributes:
        name: key in the model file; its unit is the suffix.
        unit: unit in words.
        size: ``"joint"`` for one number per joint (or per link), ``"pair"`` for one per pair of joints, in the order
            (2,1), (3,1), (3,2), ..., ``"place"`` for one per place, 0 base ... n flange, else the count of numbers.
        start: value to begin an identification with.
        low, high: bounds, both included; a value outside is refused.
        scale: a typical size, to condition solvers with.
        meaning: one line for docs and reports.
        default: value where the model file has no such key; None when it must be there.
        fit: how identification treats it: ``direct``; ``inverse``, because readings are about linear in its
            inverse; ``given``, because no derivative leads to it.
        neutral: the value with which the effect vanishes; None where it only shapes what other parameters scale.
        trials: start values of a search, where the derivative at one value is not enough.
        trials_of: ``"torque"``: the trials are shares of the largest torque of the joint.
        extra: freed only where the data ask for it.
        site: the kind of site it belongs to, where the effect has several kinds.
        each: how many numbers every site has, where it is more than one: a table.
        prior_sd: how far it is from its start on real robots, one standard deviation, as the solver sees it; None: a
            few typical sizes.
        common: one cause makes its numbers alike: one for all where the readings do not tell them apart.
    """

    name: str
    unit: str
    size: Size | int
    start: float
    low: float
    high: float
    scale: float
    meaning: str
    default: float | None = None
    fit: Literal["direct", "inverse", "given"] = "direct"
    neutral: float | None = None
    trials: tuple[float, ...] = ()
    trials_of: Literal["", "torque"] = ""
    extra: bool = False
    site: str = ""
    each: int = 1
    prior_sd: float | None = None
    common: bool = False

    def count(self, joints: int) -> int:
        """How many numbers the parameter has on a robot with so many joints."""
        counts = {"joint": joints, "pair": joints * (joints - 1) // 2, "place": joints + 1}
        return self.size if isinstance(self.size, int) else counts[self.size] * self.each

    @property
    def yields(self) -> bool:
        """Whether it is motion per load, as of a spring that is not seen inverted."""
        return self.fit != "inverse" and ("/N" in self.unit or "/(N" in self.unit)

    def of_site(self, index: int | None) -> slice:
        """Its numbers at a site; all where there is one site."""
        if index is None or isinstance(self.size, int):
            return slice(None)
        return slice(index * self.each, (index + 1) * self.each)


@dataclass(frozen=True)
class Site:
    """Where an effect can sit: ``where`` in the words of reports, ``index`` of its numbers in parameters of one
    number per site; None where all numbers belong to the one site. ``kind``: as in ``Effect.site_kind``."""

    where: tuple[str, ...]
    index: int | None = None
    kind: str = ""


@dataclass(frozen=True)
class JointInput:
    """What a joint law is given: columns (n,), one row per joint."""

    torque: ca.SX  # generalised force of gravity and environment, N*m
    elastic: ca.SX  # deflection of the base model (joint-stiffness) under it, rad
    compliance: ca.SX  # of the base model, rad/(N*m)
    angle: ca.SX  # commanded, rad
    state: ca.SX  # (n * states,) the effect's own memory, state after state; zeros when it has none
    temperature: ca.SX  # (1,) K above the model's reference temperature


@dataclass(frozen=True)
class PlaceInput:
    """What a place that yields is given."""

    place: int  # 0 base ... n flange
    wrench: ca.SX  # (6,) N and N*m, in the axes of the place, about its displaced origin
    temperature: ca.SX  # (1,) K above the model's reference temperature
    inner: Floats  # (3,) m: where the link begins (its joint), in the axes of the place, from its origin
    outer: Floats  # (3,) m: where it ends (the next joint), the same


@dataclass(frozen=True)
class ShownWrench:
    """What a wrench sensor shows."""

    wrench: ca.SX  # (6,) N and N*m, in the axes and about the point of the session
    to_tool: ca.SX  # (3, 3) from these axes to those of the tool


@dataclass(frozen=True)
class ProgrammedWrench:
    """What a process says that the cut does to the robot."""

    wrench: ca.SX  # (6,) N and N*m on the robot, base axes, about the TCP
    to_path: ca.SX  # (3, 3) from base axes to those of the path: along the feed, across it, along the tool


@dataclass(frozen=True)
class PointMass:
    """A mass that the robot model does not contain."""

    link: int  # 0 base ... n flange
    mass: ca.SX  # kg
    com: ca.SX  # (3,) m in the frame of the link


def _nothing_wrong(values: Numbers) -> str:
    return ""


@dataclass(frozen=True, kw_only=True)
class Effect:
    """A physical cause of deflection: parameters, and the slots of the equation that it fills.

    Attributes:
        name: as files and reports write it.
        cause: one sentence for the report.
        scope: ``robot`` goes where the robot goes, ``tool`` with the tool it was measured with,
            ``instruments`` concerns readings only and never a path, ``process`` goes with one material and one cutter.
        parameters: in the order of the model file.
        site_kind: what its numbers belong to: ``joint``, ``link``, ``inner-link`` (1 ... n - 1), ``pair`` (of joints),
            ``place`` (0 ... n), two of them with ``|`` between, or the name of its one place.
        joint, angle, torque, mass, place, wrench_reading, position_reading, process_wrench, surface_reading: the slots,
            None where not filled.
        missing_radius: values -> m by which the cutter is too small: it is moved so much towards the wall that it cuts.
        places: joints -> the places that ``place`` acts at (0 base ... n flange).
        memory: the state of a joint law that has one.
        unloaded: it acts without load too, so that absolute positions show it.
        thermal: it follows the temperature: readings at one temperature do not show it.
        needs_torque_sign: the law is not linear in torque, so gravity matters to it even where the
            controller takes the sag off.
        angle_sd: angles (N, n), values, standard deviations -> standard deviation (N, n) rad of the law, where it was
            identified over part of the range of a joint only.
        nearest: the allowed values nearest to values that ``check`` refuses; a second argument, if any, is the
            precision matrix of all their numbers in the order of the parameters: what is known well moves least.
        as_table: () -> (each, k) the k other numbers of a site as the table that its extras are, freed in their place.
        restarts: values -> others of about the same law, all extras away from their bounds, which can hold a fit.
        check: what is wrong with values that are within their bounds one by one; "" when nothing is.
        twins: names of effects that no readings at rest tell from it where both sit in one place.
        is_base: the springs of the joints, which every model has and all other effects are added to; there is one.
        stiffness: of the base model alone: values -> (n,) N*m/rad.
        fitted_where: what readings make identification fit it without being asked: ``load`` (anything that bends the
            arm), ``position`` (absolute positions), ``approach`` (known approaches and two levels of load, and only
            if the data ask for it); "" never.
    """

    name: str
    cause: str
    scope: Scope
    parameters: tuple[Parameter, ...]
    site_kind: str
    joint: Callable[[JointInput, Values], ca.SX] | None = None
    angle: Callable[[ca.SX, Values], ca.SX] | None = None
    torque: Callable[[ca.SX, Values], ca.SX] | None = None
    mass: Callable[[int, Values], tuple[PointMass, ...]] | None = None
    place: Callable[[PlaceInput, Values], ca.SX] | None = None
    places: Callable[[int], tuple[int, ...]] = lambda n: ()
    wrench_reading: Callable[[ShownWrench, Values], ca.SX] | None = None
    position_reading: Callable[[ca.SX, ca.SX, Values], ca.SX] | None = None
    process_wrench: Callable[[ProgrammedWrench, Values], ca.SX] | None = None
    surface_reading: Callable[[ca.SX, Values], ca.SX] | None = None
    missing_radius: Callable[[Numbers], float] | None = None
    memory: Memory | None = None
    unloaded: bool = False
    thermal: bool = False
    needs_torque_sign: bool = False
    angle_sd: Callable[[Floats, Numbers, Numbers], Floats] | None = None
    nearest: Callable[..., dict[str, Floats]] | None = None
    as_table: Callable[[], Floats] | None = None
    restarts: Callable[[Numbers], tuple[dict[str, Floats], ...]] = lambda values: ()
    check: Callable[[Numbers], str] = _nothing_wrong
    twins: tuple[str, ...] = ()
    is_base: bool = False
    stiffness: Callable[[Numbers], Floats] | None = None
    fitted_where: Literal["", "load", "position", "approach"] = ""

    def __repr__(self) -> str:
        return f"Effect({self.name})"

    @property
    def fitted_unasked(self) -> bool:
        """Whether every identification fits it where the readings can tell: what all other effects are added to."""
        return self.is_base or self.fitted_where in ("load", "position")

    def sites(self, joints: int) -> tuple[Site, ...]:
        """Where it can sit on a robot with so many joints."""
        kinds = self.site_kind.split("|")
        return tuple(site for kind in kinds for site in _sites(kind, joints, kind if len(kinds) > 1 else ""))

    def neutral(self, joints: int) -> dict[str, Floats]:
        """Values without effect, the rest at their start; for effects that have such values."""
        return {p.name: np.full(p.count(joints), p.start if p.neutral is None else p.neutral) for p in self.parameters}


def acting_wrench(
    effects: Sequence[Effect], given: ProgrammedWrench, values: Mapping[str, Values]
) -> ca.SX:
    """(6,) N and N*m, base axes: a programmed wrench as effects of the process leave it."""
    for e in effects:
        if e.process_wrench:
            given = replace(given, wrench=e.process_wrench(given, values[e.name]))
    return given.wrench


def place_name(place: int, joints: int) -> str:
    """0 base ... n flange, in the words of reports."""
    return "base" if place == 0 else "tool" if place == joints else f"link-{place}"


def part_of(place: str, joints: int) -> int:
    """Which part of the arm a place of a report belongs to, 0 base ... n tool; -1 for instruments."""
    _, _, number = place.partition("-")
    return int(number) if number.isdigit() else {"base": 0, "tool": joints}.get(place, -1)


def _sites(kind: str, joints: int, named: str) -> list[Site]:
    if kind == "joint":
        return [Site((f"joint-{k + 1}",), k, named) for k in range(joints)]
    if kind in ("link", "inner-link"):  # the last link is the tool's place
        return [Site((f"link-{k + 1}",), k, named) for k in range(joints - (kind == "inner-link"))]
    if kind == "pair":
        pairs = [(a, b) for a in range(joints) for b in range(a)]
        return [Site((f"joint-{b + 1}", f"joint-{a + 1}"), k, named) for k, (a, b) in enumerate(pairs)]
    if kind == "place":
        return [Site((place_name(k, joints),), k, named) for k in range(joints + 1)]
    return [Site((kind,), None, named)]
