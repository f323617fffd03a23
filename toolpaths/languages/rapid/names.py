"""Names of a RAPID module and their values: those of the routine that runs, then those of the module."""

from __future__ import annotations

from dataclasses import replace

from toolpaths.interpreting.values import ExpressionError, Runtime
from toolpaths.interpreting.variables import Variable, first_value
from toolpaths.languages.rapid.expressions import RapidExpression, component, item
from toolpaths.languages.rapid.scan import RapidModule
from toolpaths.languages.rapid.values import PREDEFINED, RECORDS, Value, fits


class RapidNames:
    """The names of one module as they are at a place of its run; keys are in lower case.

    Attributes:
        local: of the routine that runs.
    """

    def __init__(self, module: RapidModule) -> None:
        self.module = module
        self._global = {key: Variable(None, d, d.type) for key, d in module.data.items()}
        self.local: dict[str, Variable] = {}

    def variable(self, name: str) -> Variable | None:
        """A declared name: of the routine, else of the module."""
        lower = name.lower()
        return self.local.get(lower) or self._global.get(lower)

    def _home(self, name: str) -> dict[str, Variable]:
        return self.local if name.lower() in self.local else self._global

    def enter(self, local: dict[str, Variable]) -> None:
        """Another routine runs: these are its names."""
        self.local = local

    def declare(self, name: str, variable: Variable | None) -> None:
        """A name of the routine that runs; None: it has no such name any more."""
        self.local.pop(name.lower(), None)
        if variable is not None:
            self.local[name.lower()] = variable

    def look_up(self, name: str) -> tuple[str, Value]:
        """Type and value of a name; Runtime where it is not declared here."""
        variable = self.variable(name)
        if variable is None:
            if name.lower() in PREDEFINED:
                return PREDEFINED[name.lower()]
            return "", Runtime(f"{name}, which is not declared in this file")
        if variable.value is None:
            variable = replace(variable, value=self._first_value(name, variable))
            self._home(name)[name.lower()] = variable
        return variable.type, variable.value

    def value(self, text: str) -> Value:
        """The value of an expression.

        Raises:
            ExpressionError: it is none.
        """
        return RapidExpression(text, self.look_up).whole()

    def put(self, name: str, value: Value) -> None:
        """A declared name has this value from here on."""
        variable = self.variable(name)
        if variable:
            self._home(name)[name.lower()] = Variable(value, None, variable.type)

    def put_part(self, name: str, path: list[str | float], value: Value) -> None:
        """The same for a component or element of it; with an empty path for all of it.

        Raises:
            ExpressionError: the value is not of the right type, or there is no such part.
        """
        kind, old = self.look_up(name)
        if not path:
            if not isinstance(value, Runtime) and not fits(kind, value) and not isinstance(old, list):
                raise ExpressionError(f"the value is no {kind}")
            self.put(name, value)
        elif isinstance(old, Runtime) or isinstance(value, Runtime):
            self.put(name, value if isinstance(value, Runtime) else old)
        else:
            self.put(name, _changed(kind, old=old, path=path, value=value, name=name))

    def _first_value(self, name: str, variable: Variable) -> Value:
        value = first_value(self.module, known=self._home(name), key=name.lower(), name=name, work_out=self.value)
        d = variable.declaration
        if d is not None and not d.array and not isinstance(value, Runtime) and not fits(d.type, value):
            shape = ", ".join(n for n, _ in RECORDS.get(d.type, ())) or d.type
            self.module.refuse(d.start, f"{d.name} is no {d.type}", f"Its parts are {shape}.")
        return value


def _changed(kind: str, old: Value, path: list[str | float], value: Value, name: str) -> Value:
    """``old`` with the part at ``path`` replaced; a new list, others may share the old one."""
    if not path:
        if not fits(kind, value) and not isinstance(old, list):
            raise ExpressionError(f"the value is no {kind}")
        return value
    first = path[0]
    if isinstance(first, float):
        item(old, first, name)
        place, inner = int(first) - 1, kind
    else:
        place, inner = component(kind, str(first))
    out = list(old)
    out[place] = _changed(inner, old=old[place], path=path[1:], value=value, name=name)
    return out
