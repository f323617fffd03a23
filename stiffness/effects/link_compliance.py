"""Link compliance: bending and torsion of a link, as one lumped hinge in three directions.

    phi = diag(a) (m - c x f)        d = c x phi        c = inner + s (outer - inner)

in the axes of the link's frame: m - c x f is the moment about the hinge c, at the share s of the way from the link's
joint to the next one. A cantilever under an end force has its lumped hinge at s = 1/3, under an end moment at 1/2
(beam tables: F L^2 / 2EI and F L^3 / 3EI, M L / EI and M L^2 / 2EI). The last link is the place of tool-compliance.
"""

from __future__ import annotations

import casadi as ca

from stiffness.effects.effect import Effect, Parameter, PlaceInput, Values

_AXES = ("rx_rad_per_nm", "ry_rad_per_nm", "rz_rad_per_nm")


def _displacement(given: PlaceInput, p: Values) -> ca.SX:
    k = given.place - 1
    inner, outer = ca.DM(given.inner), ca.DM(given.outer)
    hinge = inner + p["at"][k] * (outer - inner)
    moment = given.wrench[3:] - ca.cross(hinge, given.wrench[:3])
    phi = ca.vertcat(*(p[axis][k] for axis in _AXES)) * moment
    return ca.vertcat(ca.cross(hinge, phi), phi)


EFFECT = Effect(
    name="link-compliance",
    cause="a link bends or twists: motion across the joint axes that no joint can make",
    scope="robot",
    site_kind="inner-link",
    parameters=(
        *(
            Parameter(
                name=a,
                unit="rad/(N*m)",
                size="joint",
                start=1e-8,
                low=0.0,
                high=1e-3,
                scale=1e-7,
                meaning=f"rotation per moment about {a[1]} of its frame",
                neutral=0.0,
            )
            for a in _AXES
        ),
        Parameter(
            name="at",
            unit="1",
            size="joint",
            start=0.4,
            low=0.0,
            high=1.0,
            scale=0.5,
            meaning="share of the link's length at which it bends",
            default=0.4,
            trials=(0.0, 1.0),
        ),
    ),
    place=_displacement,
    places=lambda n: tuple(range(1, n)),
)
