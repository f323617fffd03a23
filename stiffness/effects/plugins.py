"""Effects of other packages: each names an ``Effect`` under the entry point ``compensator.effects``."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import entry_points

from stiffness.effects.effect import Effect
from stiffness.errors import StiffnessError

GROUP = "compensator.effects"


def with_plugins(built_in: Sequence[Effect]) -> tuple[Effect, ...]:
    """The catalogue with what installed packages add, in the order of their names.

    Raises:
        StiffnessError: a package's effect cannot be loaded, is none, or takes a name that is taken.
    """
    out = list(built_in)
    for entry in sorted(entry_points(group=GROUP), key=lambda e: e.name):
        whose = f"effect {entry.value!r} of package {entry.dist.name if entry.dist else '?'}"
        try:
            effect = entry.load()
        except Exception as error:  # whatever a foreign module raises
            raise StiffnessError(f"{whose} cannot be loaded: {error!r}; repair or uninstall the package") from error
        if not isinstance(effect, Effect):
            raise StiffnessError(f"{whose} is a {type(effect).__name__}; expected a stiffness.effects.effect.Effect")
        if effect.name in {e.name for e in out}:
            raise StiffnessError(f"{whose} is named {effect.name!r}, as another effect already is; rename it")
        if effect.is_base:
            raise StiffnessError(f"{whose} declares is_base: there is one base model, and this program has it")
        out.append(effect)
    return tuple(out)
