"""Names of a RAPID program and their values: those of the routine that runs, of its module, of all modules."""

from __future__ import annotations

from dataclasses import replace

from toolpaths.interpreting.values import ExpressionError, Runtime
from toolpaths.interpreting.variables import Variable, first_value
from toolpaths.languages.rapid.expressions import RapidExpression, component, item
from toolpaths.languages.rapid.program import RapidProgram
from toolpaths.languages.rapid.values import PREDEFINED, RECORDS, Value, fits


class RapidNames:
    """The names of one program as they are at a place of its run; keys are in lower case.

    Attributes:
        local: of the routine that runs.
        module: number of its module.
    """

    def __init__(self, program: RapidProgram) -> None:
        self.program, self.module = program, 0
        self._global: dict[str, Variable] = {}
        self._modules: list[dict[str, Variable]] = []  # what is LOCAL in a module
        self.local: dict[str, Variable] = {}
        self._joined()

    def _joined(self) -> None:
        """Take over the names of modules that joined the program."""
        for key, d in self.program.data.items():
            self._global.setdefault(key, Variable(None, d, d.type))
        for local in self.program.local[len(self._modules) :]:
            self._modules.append({key: Variable(None, d, d.type) for key, d in local.items()})

    def variable(self, name: str) -> Variable | None:
        """A declared name: of the routine, else of its module, else of all modules, also of those beside."""
        lower = name.lower()
        found = self.local.get(lower) or self._modules[self.module].get(lower) or self._global.get(lower)
        if found is None and lower not in PREDEFINED and self.program.find(lower):
            self._joined()
            found = self._global.get(lower)
        return found

    def _home(self, name: str) -> dict[str, Variable]:
        inner = (self.local, self._modules[self.module])
        return next((names for names in inner if name.lower() in names), self._global)

    def enter(self, local: dict[str, Variable], module: int) -> None:
        """Another routine runs: these are its names, that is its module."""
        self._joined()
        self.local, self.module = local, module

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
            return "", Runtime(f"{name}, which is declared in no file that was read")
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
        value = first_value(self.program, known=self._home(name), key=name.lower(), name=name, work_out=self.value)
        d = variable.declaration
        if d is not None and not d.array and not isinstance(value, Runtime) and not fits(d.type, value):
            shape = ", ".join(n for n, _ in RECORDS.get(d.type, ())) or d.type
            self.program.refuse(d.start, f"{d.name} is no {d.type}", f"Its parts are {shape}.")
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
