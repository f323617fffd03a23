"""The server of `compensator view`: one page on this machine, its edits computed, its cell saved.

It listens on 127.0.0.1 only, answers to no other name (a page from elsewhere could be given this address by its name
server), and takes edits only with the token that stands in the page, so that no other page can send any.
"""

from __future__ import annotations

import json
import secrets
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Lock
from typing import Any

HOST = "127.0.0.1"
LARGEST = 100_000  # bytes of a request
Answer = Mapping[str, Any]
TOKEN = "X-Token"


@dataclass(frozen=True)
class PageService:
    """What the server is asked for.

    Attributes:
        page: the page, given the token. answers: path of a POST -> what answers it; refusals are told in words.
        is_refusal: whether an exception is one.
    """

    page: Callable[[str], str]
    answers: Mapping[str, Callable[[Any], Answer]]
    is_refusal: Callable[[Exception], bool]


class PageServer(ThreadingHTTPServer):
    """Listens from the time it is made; ``url`` is where.

    Args:
        port: 0 takes a free one.

    Raises:
        OSError: the port is taken.
    """

    daemon_threads = True

    def __init__(self, service: PageService, port: int = 0) -> None:
        super().__init__((HOST, port), _Handler)
        self.service = service
        self.token = secrets.token_urlsafe(24)
        self.working = Lock()  # one computation at a time

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that has gone away is no error; any other stands on standard error, and the server goes on."""
        if not isinstance(sys.exc_info()[1], ConnectionError):
            super().handle_error(request, client_address)

    @property
    def url(self) -> str:
        """Of the page."""
        return f"http://{HOST}:{self.server_port}/"

    @property
    def names(self) -> set[str]:
        """How a browser may call this server."""
        return {f"{name}:{self.server_port}" for name in (HOST, "localhost")}


class _Handler(BaseHTTPRequestHandler):
    server: PageServer
    timeout = 60
    server_version, sys_version = "compensator", ""

    def do_GET(self) -> None:
        if not self._is_ours():
            return
        if self.path == "/favicon.ico":
            self._send(HTTPStatus.NO_CONTENT, "text/plain", b"")
        elif self.path == "/":
            with self.server.working:
                page = self.server.service.page(self.server.token)
            self._send(HTTPStatus.OK, "text/html; charset=utf-8", page.encode())
        else:
            self._send(HTTPStatus.NOT_FOUND, "text/plain", b"not here")

    def do_POST(self) -> None:
        if not self._is_ours():
            return
        answer, token = self.server.service.answers.get(self.path), self.headers.get(TOKEN, "")
        if answer is None or not secrets.compare_digest(token.encode(), self.server.token.encode()):
            self._send(HTTPStatus.FORBIDDEN, "text/plain", b"refused")
            return
        self._json(*self._answered(answer))

    def _answered(self, answer: Callable[[Any], Answer]) -> tuple[HTTPStatus, Answer]:
        length = self.headers.get("Content-Length", "")
        if not length.isdigit() or int(length) > LARGEST:
            return HTTPStatus.BAD_REQUEST, {"error": f"a request of at most {LARGEST} bytes is expected"}
        try:
            given = json.loads(self.rfile.read(int(length)))
        except ValueError:
            return HTTPStatus.BAD_REQUEST, {"error": "JSON is expected"}
        try:
            with self.server.working:
                return HTTPStatus.OK, answer(given)
        except Exception as error:
            if not self.server.service.is_refusal(error):
                raise
            return HTTPStatus.OK, {"error": str(error)}

    def _is_ours(self) -> bool:
        if self.headers.get("Host") in self.server.names:
            return True
        self._send(HTTPStatus.FORBIDDEN, "text/plain", b"refused")
        return False

    def _json(self, status: HTTPStatus, answer: Answer) -> None:
        self._send(status, "application/json", json.dumps(answer, allow_nan=False).encode())

    def _send(self, status: HTTPStatus, kind: str, content: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("X-Frame-Options", "DENY")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing: the terminal has one line with the address."""
