"""Names of a KRL program and their values: declared ones, system variables, what the program assigns."""

from __future__ import annotations

from dataclasses import replace

from toolpaths.interpreting.program_text import Declaration
from toolpaths.interpreting.values import Runtime
from toolpaths.interpreting.variables import Variable, first_value
from toolpaths.languages.krl.expressions import NULL, KrlExpression, Value
from toolpaths.languages.krl.program import KrlProgram

WHERE_IT_STANDS = ("$POS_ACT", "$AXIS_ACT", "$POS_FOR", "$AXIS_FOR", "$POS_ACT_MES", "$AXIS_ACT_MES")


class KrlNames:
    """The names of one program as they are at a place of its run, in upper case: ``XP1``, ``TOOL_DATA[2]``, ``$BASE``.

    Attributes:
        module: number of the module whose routine runs: the names of its own .src and .dat hide those of the others.
    """

    def __init__(self, program: KrlProgram) -> None:
        self.program, self.module = program, 0
        self._shared: dict[str, Variable] = {}
        self._modules: list[dict[str, Variable]] = []
        self.enter(0)
        self.put("$NULLFRAME", dict(NULL))

    def enter(self, module: int) -> None:
        """A routine of this module runs."""
        for declared in self.program.declared[len(self._modules) :]:
            known = {name: Variable(None, d) for name, d in declared.items()}
            self._shared |= {name: v for name, v in known.items() if v.declaration and v.declaration.storage}
            self._modules.append({name: v for name, v in known.items() if name not in self._shared})
        self.module = module

    def _home(self, name: str) -> dict[str, Variable]:
        own = self._modules[self.module]
        return own if name in own else self._shared

    def get(self, name: str) -> Variable | None:
        """The variable of this name, if there is one."""
        return self._home(name).get(name)

    def declared(self, name: str) -> Declaration | None:
        """How a name is declared that is known here."""
        return self.program.declared[self.module].get(name) or self.program.shared.get(name)

    def put(self, name: str, value: Value) -> None:
        """The name has this value from here on."""
        self._home(name)[name] = Variable(value, None)

    def drop(self, name: str) -> None:
        """The name has no value of its own from here on."""
        self._home(name).pop(name, None)

    def look_up(self, name: str) -> Value:
        """The value of a name; Runtime where the files do not hold it."""
        variable = self.get(name)
        if variable is None:
            if name in WHERE_IT_STANDS:
                return Runtime(f"{name}, where the arm stands")
            beside = self.program.modules[self.module].beside
            return Runtime(f"{name}, which is not in this file" + (f" or {beside}" if beside else ""))
        if variable.value is None and variable.declaration is not None:
            value = first_value(self.program, known=self._home(name), key=name, name=name, work_out=self.value)
            self._home(name)[name] = replace(variable, value=value)
            return value
        return variable.value

    def value(self, text: str) -> Value:
        """The value of an expression.

        Raises:
            ExpressionError: it is none.
        """
        return KrlExpression(text, self.look_up).whole()
