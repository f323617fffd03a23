"""Names of a KRL program and their values: declared ones, system variables, what the program assigns."""

from __future__ import annotations

from dataclasses import replace

from toolpaths.interpreting.values import Runtime
from toolpaths.interpreting.variables import Variable, first_value
from toolpaths.languages.krl.expressions import NULL, KrlExpression, Value
from toolpaths.languages.krl.scan import KrlProgram

WHERE_IT_STANDS = ("$POS_ACT", "$AXIS_ACT", "$POS_FOR", "$AXIS_FOR", "$POS_ACT_MES", "$AXIS_ACT_MES")


class KrlNames:
    """The names of one program as they are at a place of its run.

    Attributes:
        variables: by name in upper case, as ``XP1``, ``TOOL_DATA[2]``, ``$BASE`` or ``$VEL.CP``.
    """

    def __init__(self, program: KrlProgram) -> None:
        self.program = program
        self.variables = {name: Variable(None, d) for name, d in program.declared.items()}
        self.put("$NULLFRAME", dict(NULL))

    def get(self, name: str) -> Variable | None:
        """The variable of this name, if there is one."""
        return self.variables.get(name)

    def put(self, name: str, value: Value) -> None:
        """The name has this value from here on."""
        self.variables[name] = Variable(value, None)

    def look_up(self, name: str) -> Value:
        """The value of a name; Runtime where the files do not hold it."""
        variable = self.variables.get(name)
        if variable is None:
            if name in WHERE_IT_STANDS:
                return Runtime(f"{name}, where the arm stands")
            beside = self.program.beside
            return Runtime(f"{name}, which is not in this file" + (f" or {beside}" if beside else ""))
        if variable.value is None and variable.declaration is not None:
            value = first_value(self.program, known=self.variables, key=name, name=name, work_out=self.value)
            self.variables[name] = replace(variable, value=value)
            return value
        return variable.value

    def value(self, text: str) -> Value:
        """The value of an expression.

        Raises:
            ExpressionError: it is none.
        """
        return KrlExpression(text, self.look_up).whole()
