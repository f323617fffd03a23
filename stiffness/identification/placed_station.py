"""Placed station: tracker poses and reflectors as a fit has estimated them, with standard deviations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from stiffness.identification.fit import Fit

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class PlacedTracker:
    """A tracker pose in the base: ``origin`` (3,) m, ``rotation`` (3, 3), and standard deviations (3,) m and rad, the
    latter about the axes of the base."""

    session: str
    block: int
    origin: Floats
    rotation: Floats
    origin_sd: Floats
    rotation_sd: Floats

    def __repr__(self) -> str:
        return f"PlacedTracker({self.session!r}, block {self.block})"

    @property
    def rpy(self) -> Floats:
        """(3,) rad, about the fixed axes x, y, z of the base in turn."""
        return np.asarray(Rotation.from_matrix(self.rotation).as_euler("xyz"))


@dataclass(frozen=True, repr=False, eq=False)
class PlacedReflector:
    """A reflector in the frame of its link: ``position`` and ``sd`` (3,) m."""

    session: str
    name: str
    link: int
    position: Floats
    sd: Floats

    def __repr__(self) -> str:
        return f"PlacedReflector({self.session!r}, {self.name!r})"


def placed_trackers(fit: Fit) -> list[PlacedTracker]:
    """Every tracker pose that the fit has estimated; a registration that stays as it was declared is none."""
    out = []
    for s, sd in zip(fit.sessions, _spreads(fit), strict=True):
        poses, blocks = s.predicted.state.poses, s.observations.data.station.blocks
        if poses is None or s.observations.exact:
            continue
        for k, block in enumerate(blocks):
            six, wide = s.own[6 * k : 6 * k + 6], np.sqrt(np.diag(sd))[6 * k : 6 * k + 6]
            turned = Rotation.from_rotvec(six[3:]).as_matrix() @ poses.rotation[k]
            at = poses.origin[k] + six[:3]
            out.append(
                PlacedTracker(
                    session=s.session.source,
                    block=int(block),
                    origin=at,
                    rotation=turned,
                    origin_sd=wide[:3],
                    rotation_sd=wide[3:],
                )
            )
    return out


def placed_reflectors(fit: Fit) -> list[PlacedReflector]:
    """Every reflector whose place the fit has estimated, those of probes included."""
    out = []
    for s, covariance in zip(fit.sessions, _spreads(fit), strict=True):
        slopes = s.observations.data.station.reflector_derivative(s.own)
        for k, r in enumerate(s.session.reflectors):
            if not r.exact:
                sd = np.sqrt(np.maximum(np.diag(slopes[k] @ covariance @ slopes[k].T), 0.0))
                out.append(
                    PlacedReflector(
                        session=s.session.source, name=r.name, link=int(r.link), position=s.reflectors[k], sd=sd
                    )
                )
    return out


def _spreads(fit: Fit) -> list[Floats]:
    """Covariance (S, S) of every session's own numbers."""
    every = fit.solution.covariance * fit.solution.misfit**2
    return [every[s.columns, s.columns] for s in fit.sessions]
