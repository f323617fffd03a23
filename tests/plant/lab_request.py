"""What a lab is asked to do: targets, set-ups, loads, instruments, and the form of the session file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Target:
    """A reflector where it really sits: m, in the frame of its link."""

    name: str
    link: int
    at: ArrayLike
    exact: bool = True
    group: str | None = None


@dataclass(frozen=True)
class Step:
    """A load: force (3,) N and moment (3,) N*m in base axes, on the flange about the TCP, or at and about the
    target `pull`, on the link that it sits on; payload: kg, hung at the tool's com."""

    force: ArrayLike = (0.0, 0.0, 0.0)
    moment: ArrayLike = (0.0, 0.0, 0.0)
    pull: str | None = None
    payload: float = 0.0


@dataclass(frozen=True)
class Setup:
    """A configuration q (n,) rad, reached by a last move (n,) rad; state 0 and the load steps after it."""

    q: ArrayLike
    move: ArrayLike
    steps: Sequence[Step] = (Step(),)


@dataclass(frozen=True)
class Noise:
    """One sigma of one reading, per axis: m, rad, N, N*m."""

    tracker: float = 2e-5
    tracker_angle: float = 0.0
    force: float = 0.3
    torque: float = 0.1


@dataclass(frozen=True)
class Form:
    """How the session is written down.

    blocks: tracker stations, one after the other; unregistered, each stands somewhere at random.
    rough: m, how far the file's position of a target that is not exact is from the truth, one sigma.
    wrong: rows that are wrong: a jump (1 to 10 mm), or two targets mixed up.
    wrench: written at all; False only for sessions without loads. sensed: the sensor is read anew for
    every row, or once per state. load_columns: write load_link and load_at for pulls elsewhere.
    again: in so many set-ups, from the first, state 0 is read twice. climate: deg C from seconds, read with each
    state. What is in `extra` acts on plants that feel it.
    """

    length: Literal["mm", "m"] = "mm"
    angle: Literal["deg", "rad"] = "deg"
    frame: Literal["base", "tool"] = "base"
    about: Literal["tcp", "flange", "base"] = "tcp"
    registered: bool = True
    blocks: int = 1
    repeats: int = 1
    rough: float = 0.0
    wrong: int = 0
    wrench: bool = True
    sensed: Literal["row", "state"] = "row"
    load_columns: bool = True
    approach: bool = True
    step: bool = False
    sd: bool = False
    seconds: float | None = None  # between two readings; None: no column time
    again: int = 0
    climate: Callable[[float], float] | None = None
    reference_temperature: float | None = None  # deg C
    extra: Mapping[str, Sequence[float | str]] = field(default_factory=dict)  # column -> a value per set-up
    purposes: Mapping[int, Mapping[str, Any]] = field(default_factory=dict)  # [setups.N]

    def readings(self, setup: int, state: int) -> int:
        """How often the state of the set-up (both counted from 0) is read."""
        return max(self.repeats, 2) if setup < self.again and state == 0 else self.repeats
