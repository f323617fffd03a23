"""The address of a Dask scheduler: refused before a client is made, which waits long for what is not there."""

from __future__ import annotations

import re
import socket

from compensator.errors import CompensatorError

SECONDS = 5.0  # for the answer of a scheduler
_SCHEMES = ("tcp", "tls", "ws", "wss", "ucx")
_FORM = re.compile(rf"(?:(?:{'|'.join(_SCHEMES)})://)?(\[[0-9A-Fa-f:.%]+\]|[^:/\[\]\s]+):(\d{{1,5}})/?")


def host_and_port(address: str) -> tuple[str, int]:
    """Host and port of an address such as ``tcp://host:8786``.

    Raises:
        CompensatorError: it has another form.
    """
    form = _FORM.fullmatch(address)
    if form is None or not 0 < int(form[2]) < 65536:
        expected = "expected tcp://host:port, as `dask scheduler` prints it, such as tcp://localhost:8786"
        raise CompensatorError(f"--scheduler {address}: {expected}")
    return form[1].strip("[]"), int(form[2])


def refuse_silent(address: str) -> None:
    """Refuse an address where nothing listens.

    Raises:
        CompensatorError: names the address and why.
    """
    if address.startswith("ucx:"):
        return
    try:
        socket.create_connection(host_and_port(address), SECONDS).close()
    except OSError as e:
        raise CompensatorError(f"--scheduler {address}: no scheduler answers there within {SECONDS:g}s: {e}") from e
