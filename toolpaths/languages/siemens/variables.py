"""SiemensVariables: R parameters, variables of DEF, and what the arguments of a subprogram are called in it."""

from __future__ import annotations

from toolpaths.interpreting.values import ExpressionError, Runtime
from toolpaths.languages.siemens.block import ADDRESSES, Arguments, is_parameter, stored, unknown
from toolpaths.languages.siemens.expressions import SiemensExpression, Value, as_number

_NUMBERS = ("REAL", "INT")
_TYPES = (*_NUMBERS, "BOOL", "STRING", "CHAR", "AXIS", "FRAME")
_STARTS: dict[str, Value] = {"REAL": 0.0, "INT": 0.0, "BOOL": False, "STRING": "", "CHAR": 0.0}
#: Variables of the system whose assignment moves nothing: outputs, tool data, counters.
_OUTPUTS = ("$A_OUT", "$A_OUTA", "$TC_", "$AC_TIMER", "$AC_MARKER", "$A_DB", "$AC_PARAM", "$AN_TIMER", "$A_DLB")


class SiemensVariables:
    """What names stand for; a subprogram has its own beside the R parameters."""

    def __init__(self) -> None:
        self._parameters: dict[str, Value] = {}
        self._scopes: list[dict[str, Value]] = [{}]

    def look_up(self, name: str) -> Value:
        """The value of a variable; Runtime where the file gives it none."""
        key = stored(name)
        if is_parameter(key):
            return self._parameters.get(key, unknown(key))
        scope = self._scopes[-1]
        if key in scope:
            return scope[key]
        plain = key.partition("[")[0]
        return scope[f"{plain}[]"] if f"{plain}[]" in scope else unknown(key)

    def put(self, name: str, value: Value) -> bool:
        """Assign; whether it is one of the machine or of its builder, which moves nothing that is read.

        Raises:
            ValueError: a variable of the system that moves depend on, or a name that is none: an axis, perhaps.
        """
        key = stored(name)
        if key.startswith("$"):
            if key.startswith(_OUTPUTS):
                return True
            raise ValueError(f"{key}=...: it writes into the control", "Post without it.")
        scope = self._scopes[-1]
        if is_parameter(key):
            self._parameters[key] = value
        elif key in scope or f"{key.partition('[')[0]}[]" in scope:
            scope[key] = value
        elif key.startswith("_"):
            scope[key] = value
            return True
        else:
            raise ValueError(
                f"{key}=...: no address that is read, and no variable of DEF", "Post without it, or declare it."
            )
        return False

    def declare(self, tokens: SiemensExpression) -> None:
        """DEF REAL A=5, B, C[10].

        Raises:
            ExpressionError: another form.
        """
        kind = tokens.take().upper()
        if kind not in _TYPES:
            raise ExpressionError(f"DEF {kind}: {', '.join(_TYPES)} are expected")
        if kind == "STRING" and tokens.peek() == "[":
            tokens.skip_brackets()
        while True:
            name = tokens.take().upper()
            if len(name) == 1 or name in ADDRESSES:
                raise ExpressionError(f"DEF of {name}, which is an address")
            start = _STARTS.get(kind, unknown(name))
            if tokens.peek() == "[":
                tokens.skip_brackets()
                name = f"{name}[]"
            if tokens.peek() == "=":
                tokens.take()
                start = tokens.value()
            self._scopes[-1][name] = start
            if tokens.peek() != ",":
                break
            tokens.take()
        if tokens.kind():
            raise ExpressionError(f"{tokens.peek()!r} is not expected here")

    def enter(self, tokens: SiemensExpression | None, given: Arguments) -> None:
        """A subprogram begins: its PROC line behind the name, and what it is called with.

        Raises:
            ExpressionError: they do not fit together.
        """
        scope: dict[str, Value] = {}
        if tokens is not None and tokens.peek() == "(":
            tokens.take()
            for k in range(len(given) + 100):
                if tokens.peek() == ")":
                    break
                _parameter(tokens, scope, given[k] if k < len(given) else None)
                if tokens.peek() == ",":
                    tokens.take()
        if len([v for v in given if v is not None]) > len(scope):
            raise ExpressionError("it is called with more values than its PROC line has")
        self._scopes.append(scope)

    def leave(self) -> None:
        """A subprogram ends."""
        self._scopes.pop()


def _parameter(tokens: SiemensExpression, scope: dict[str, Value], given: Value | None) -> None:
    """REAL NAME, or INT NAME=5."""
    kind = tokens.take().upper()
    if kind not in _TYPES:
        raise ExpressionError(f"parameter {kind}: {', '.join(_TYPES)} are expected, by value")
    if kind == "STRING" and tokens.peek() == "[":
        tokens.skip_brackets()
    name = tokens.take().upper()
    start = _STARTS.get(kind, unknown(name))
    if tokens.peek() == "=":
        tokens.take()
        start = tokens.value()
    value = start if given is None else given
    scope[name] = as_number(value) if kind in _NUMBERS and not isinstance(value, Runtime) else value
