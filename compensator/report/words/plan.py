"""A plan in words."""

from __future__ import annotations

import numpy as np

from stiffness.planning.plan import Plan


def plan_sentence(plan: Plan) -> str:
    """What the plan will bring, for people."""
    some = "1 set-up" if len(plan.chosen) == 1 else f"{len(plan.chosen)} set-ups"
    begin = f"{some}, {plan.readings} readings up to {plan.loading.force:.0f} N"
    open_ = plan.undetermined(plan.after)
    if open_:
        remedy = "allow more force, more set-ups or other reflectors"
        return f"{begin}: these stay undetermined: {', '.join(open_)}; {remedy}"
    sd = plan.sd(plan.after)
    worst = int(np.argmax(sd))
    u = plan.design.layout.free[worst]
    what = f"{u.parameter.meaning} of joint {u.index + 1}"
    return f"{begin}: every parameter is determined; known least is the {what}, to {100 * sd[worst]:.2g} %"
