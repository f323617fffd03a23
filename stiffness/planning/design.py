"""Design: the information that set-ups which could be measured would give on a model's parameters.

A candidate is a set-up as a lab makes it: a posture, its unloaded state, then a pull and a push along one line, read at
one reflector. Its information is worked out from the readings' derivatives by the parameters and from the noise, as
identification weighs them; a free offset per set-up leaves it nothing but displacements.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, Numbers
from stiffness.errors import StiffnessError
from stiffness.identification.arm_loads import ArmLoads, LoadKind
from stiffness.identification.load_history import opened
from stiffness.identification.problem import Problem
from stiffness.identification.readings import ReadingModel
from stiffness.identification.session_data import SessionData
from stiffness.identification.unknowns import Unknowns, unknowns
from stiffness.identification.weighting import Weighting
from stiffness.memory.preload import PreloadState, unknown, walk
from stiffness.planning.postures import PosturePool
from stiffness.session.file import Instruments, Reflector
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

PLANNED = ("load", "approach")  # springs of the joints, and what joints remember of their approach
OFFSET = 0.02  # m, as in identification: absolute positions are not used
FAR = 1.0  # rad: the last move before a set-up is longer than any gap
FARTHEST = 0.1  # rad: no lab bends an arm so far
ROUNDS = 3  # of equilibrium and flanks

_AXES = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
_EDGES = [(1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1)]
_CORNERS = [(1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)]
LINES = np.array([np.array(v) / np.linalg.norm(v) for v in (*_AXES, *_EDGES, *_CORNERS)])
PULLED_AT = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]])  # m from the TCP, axes of the TCP


@dataclass(frozen=True)
class Loading:
    """What a lab can do: largest ``force`` N, its ``levels`` as shares, ``instruments`` and their noise."""

    force: float
    levels: tuple[float, ...]
    instruments: Instruments

    @property
    def steps(self) -> Floats:
        """(T,) signed share of the force in every state: unloaded, pulled, pushed."""
        return np.array([0.0, *self.levels, *(-v for v in self.levels)])


@dataclass(frozen=True, repr=False)
class SetupPool:
    """C set-ups to choose from.

    Attributes:
        posture: (C,) row of the postures. reflector: (C,) number of the reflector.
        wrench: (C, 6) N and N*m of a full pull, base axes, about the TCP. pulled_at: (C, 3) m from the TCP, axes of
            the TCP.
        information: (C, P, P) of the parameters in units of ``Planner.scale``.
    """

    posture: Index
    reflector: Index
    wrench: Floats
    pulled_at: Floats
    information: Floats

    def __repr__(self) -> str:
        return f"SetupPool({len(self.posture)} set-ups)"


class Design:
    """What a plan is made for: one robot with one tool, its reflectors, and a model that is roughly right.

    Args:
        model: with the layout of ``planned_layout``.
        values: of all effects of the model.
        reference_sd: standard deviations of the model by effect and parameter, where it stands for readings already
            made; empty: nothing is known.
    """

    def __init__(
        self,
        model: ReadingModel,
        values: Mapping[str, Numbers],
        reflectors: Sequence[Reflector],
        reference_sd: Mapping[str, Mapping[str, Floats]] | None = None,
    ) -> None:
        self.model, self.values, self.reflectors = model, values, tuple(reflectors)
        self.layout = model.unknowns
        self.vector = self.layout.start(values)
        size = np.abs(self.vector)
        # a stiffness is judged by its own size; a gap may be zero and still have to be known
        self.scale = np.where(self.layout.inverse, size, np.maximum(size, self.layout.scale))
        self.known = self._of_model(reference_sd or {})

    def __repr__(self) -> str:
        return f"Design({self.model.robot.name}, {len(self.layout)} numbers, {len(self.reflectors)} reflectors)"

    @property
    def remembers(self) -> bool:
        """Whether flanks have a say: then both approaches and two load levels are needed."""
        return self.model.statics.n_state > 0

    def _of_model(self, sd: Mapping[str, Mapping[str, Floats]]) -> Floats:
        """(P, P) information that standard deviations of a model stand for."""
        out = np.zeros(len(self.layout))
        for k, u in enumerate(self.layout.free):
            given = sd.get(u.effect, {}).get(u.parameter.name)
            if given is not None and given[u.index] > 0:
                own = given[u.index] * (self.vector[k] ** 2 if u.inverse else 1.0)
                out[k] = (self.scale[k] / own) ** 2
        return np.diag(out)

    def measured(self, session: Session) -> Floats:
        """(P, P) information of a session, what belongs to its own set-up taken out."""
        problem = Problem.of_sessions(
            [SessionData.of(session)], [Weighting(session, OFFSET)], self.layout, self.values
        )
        count, width = len(self.layout), len(problem.start)
        vector = np.concatenate([self.vector, problem.start[count:]])
        blocks, _ = problem.blocks(vector, problem.first_states())
        full = sum((b.jacobian.T @ b.jacobian for b in blocks), np.zeros((width, width)))
        a, b = full[:count, :count], full[:count, count:]
        if width > count:
            c = full[count:, count:] + np.diag(problem.sd[count:] ** -2.0)
            a = a - b @ np.linalg.solve(c, b.T)
        return np.asarray(0.5 * (a + a.T) * np.outer(self.scale, self.scale))

    def candidates(self, postures: PosturePool, loading: Loading) -> SetupPool:
        """Every posture x line x point of pull x reflector, with its information."""
        many, lines, points = len(postures), len(LINES), len(PULLED_AT)
        arm = np.einsum("mij,kj->mki", postures.rotation, PULLED_AT)
        force = np.broadcast_to(loading.force * LINES, (many, points, lines, 3))
        moment = np.cross(np.broadcast_to(arm[:, :, None], force.shape), force)
        wrench = np.concatenate([force, moment], axis=3).reshape(-1, 6)
        place = np.broadcast_to(PULLED_AT[None, :, None], force.shape).reshape(-1, 3)
        posture = np.repeat(np.arange(many), points * lines)
        q, approach = postures.q[posture], postures.approach[posture]
        parts = [
            self._information(q=q, approach=approach, wrench=wrench, target=r, loading=loading)
            for r in self.reflectors
        ]
        count = len(self.reflectors)
        return SetupPool(
            posture=np.tile(posture, count),
            reflector=np.repeat(np.arange(count), len(posture)),
            wrench=np.tile(wrench, (count, 1)),
            pulled_at=np.tile(place, (count, 1)),
            information=np.concatenate(parts),
        )

    def _information(self, q: Floats, approach: Floats, wrench: Floats, target: Reflector, loading: Loading) -> Floats:
        """(C, P, P) of set-ups that read one reflector."""
        by_p, by_w = self._derivatives(q=q, approach=approach, wrench=wrench, target=target, loading=loading)
        c, t = by_p.shape[:2]
        sensor = loading.instruments
        d = by_w * np.array([sensor.force] * 3 + [sensor.torque] * 3)
        noise = np.tile(OFFSET**2 * np.kron(np.ones((t, t)), np.eye(3)), (c, 1, 1))
        noise += sensor.tracker**2 * np.eye(3 * t)
        for k in range(t):
            noise[:, 3 * k : 3 * k + 3, 3 * k : 3 * k + 3] += d[:, k] @ np.swapaxes(d[:, k], 1, 2)
        jacobian = by_p.reshape(c, 3 * t, -1) * self.scale
        return np.asarray(np.swapaxes(jacobian, 1, 2) @ np.linalg.solve(noise, jacobian))

    def _derivatives(
        self, q: Floats, approach: Floats, wrench: Floats, target: Reflector, loading: Loading
    ) -> tuple[Floats, Floats]:
        """(C, T, 3, P) and (C, T, 3, 6) of a reflector's position by parameters and by wrench, state by state."""
        model, (c, n), t = self.model, q.shape, len(loading.steps)
        count = c * t
        loads = ArmLoads(
            q=np.repeat(q, t, axis=0),
            wrench=(wrench[:, None] * loading.steps[:, None]).reshape(-1, 6),
            point=np.tile(model.tool.position, (count, 1)),
            state=np.zeros((count, 0)),
            payload=np.zeros((count, 1)),
            warm=np.zeros((count, 1)),
        )
        x, torque = np.zeros((count, model.n_x)), np.zeros((count, n))
        for _ in range(ROUNDS if self.remembers else 2):
            state = self._flanks(approach, torque.reshape(c, t, n)).reshape(count, -1)
            arms = model.equilibria(LoadKind(n, n, False), self.vector, replace(loads, state=state), x)
            x, torque = arms.x, arms.torque
        give = float(np.max(np.where(np.isfinite(x[:, :n]), np.abs(x[:, :n]), np.inf)))
        if give > FARTHEST:
            raise StiffnessError(
                f"under {loading.force:g} N a joint of the model would give way by {give:.2g} rad, above {FARTHEST:g}: "
                "give a smaller --force, or check the stiffnesses of the model (N*m/rad)"
            )
        read = model.positions(arms, target.link, np.tile(target.position, (count, 1)))
        return read.by_parameter.reshape(c, t, 3, -1), read.by_wrench.reshape(c, t, 3, 6)

    def _flanks(self, approach: Floats, torque: Floats) -> Floats:
        """(C, T, m) memory as a share of its half range, state by state."""
        effects = self.layout.effects
        values = {e.name: opened(e, self.values[e.name]) for e in effects}
        begin = unknown(effects, values)
        c, t, _ = torque.shape
        if not len(begin.low):
            return np.zeros((c, t, 0))
        moves = np.concatenate([FAR * approach[None], np.zeros((t, *approach.shape))])
        torques = np.concatenate([np.zeros_like(approach)[None], np.swapaxes(torque, 0, 1)])
        wide = (c, len(begin.low))
        start = PreloadState(np.broadcast_to(begin.low, wide), np.broadcast_to(begin.high, wide))
        walked = walk(effects=effects, values=values, move=moves, torque=torques, start=start).middle[1:]
        return np.asarray(np.swapaxes(walked / begin.high, 0, 1))

    def of_path(self, q: Floats, wrench: Floats, state: Floats) -> Floats:
        """(P, P) mean of J'J over poses: the trace of its product with a covariance is the mean variance, m2, of the
        deflection at these poses.

        Args:
            q: (N, n) rad. wrench: (N, 6), base axes, about the TCP. state: (N, m) memory as a share of its half range.
        """
        n, count = self.model.robot.n, len(q)
        at = np.tile(self.model.tool.position, (count, 1))
        none, x = np.zeros((count, 1)), np.zeros((count, self.model.n_x))
        loads = ArmLoads(q=q, wrench=wrench, point=at, state=state, payload=none, warm=none)
        for _ in range(2):
            arms = self.model.equilibria(LoadKind(n, n, False), self.vector, loads, x)
            x = arms.x
        j = self.model.positions(arms, n, at).by_parameter * self.scale
        return np.asarray(np.einsum("nip,niq->pq", j, j) / count)


def planned_layout(effects: Sequence[Effect], joints: int) -> Unknowns:
    """The numbers that a plan is for: joint stiffness and what joints remember; the others are taken as known."""
    return unknowns(effects, joints, [e.name for e in effects if e.fitted_where not in PLANNED])
