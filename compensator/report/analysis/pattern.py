"""A pattern: one number per load state over what it follows, before and after."""

from __future__ import annotations

from dataclasses import dataclass

from compensator.report.analysis.session_residuals import Floats


@dataclass(frozen=True, repr=False, eq=False)
class Pattern:
    """One number per load state (or per reading).

    Attributes:
        x_name, y_name: what is drawn over what, with units.
        x, before, after: (K,) the residual before and after.
        explained: (K,) what an addition explains of it, before minus after; empty where there is no addition.
        titles: of before and after; "" for the second where it is the same.
    """

    x_name: str
    y_name: str
    x: Floats
    before: Floats
    after: Floats
    explained: Floats
    titles: tuple[str, str] = ("without it", "with it")
