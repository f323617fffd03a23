"""Cutting force: the cut pushes harder, or less, than the process says: coefficients of the material, wear of the edge.

    w = R [s_t f_t, s_n f_n, s_a f_a] R'    s = 1 + change

in path axes R: t along the feed, n across it, a along the tool. A moment goes with the force that it belongs to: force
and moment about one axis have one factor. Altintas, Manufacturing Automation (2012), ch. 2: forces are linear in the
coefficients, which an edge raises by half and more as it wears.
"""

from __future__ import annotations

import casadi as ca

from stiffness.effects.effect import Effect, Parameter, ProgrammedWrench, Values


def _acting(given: ProgrammedWrench, p: Values) -> ca.SX:
    factor = 1 + p["change"]
    force, moment = (ca.mtimes(given.to_path, part) for part in (given.wrench[:3], given.wrench[3:]))
    back = given.to_path.T
    return ca.vertcat(ca.mtimes(back, factor * force), ca.mtimes(back, factor * moment))


EFFECT = Effect(
    name="cutting-force",
    cause="the cut pushes harder or less than the process says: coefficients of the material, or a worn edge",
    scope="process",
    site_kind="process",
    parameters=(
        Parameter(
            name="change",
            unit="1",
            size=3,
            start=0.0,
            low=-0.95,
            high=10.0,
            scale=0.2,
            meaning="relative change of the force along the feed, across it, and along the tool",
            default=0.0,
            neutral=0.0,
            common=True,
        ),
    ),
    process_wrench=_acting,
)
