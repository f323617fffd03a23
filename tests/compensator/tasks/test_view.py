"""`view`: a page of this machine only, edits computed by Python, the cell saved under another name, never touched."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import tomllib
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

from compensator.errors import CellError, CompensatorError
from compensator.tasks.view import new_file, view_server
from compensator.viewer.cell_edit import checked_edit, edited_text
from compensator.viewer.server import PageServer
from tests.compensator.report.small_path import CELL, prepared
from tests.compensator.report.test_scene import unpacked

COMMENTED = CELL.replace("[workobject]\n", "[workobject]  # on the table\n# measured in May\n").replace(
    "800.0]", "800.0]  # mm"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = prepared(tmp_path_factory.mktemp("view"))
    (made / "cell.toml").write_text(COMMENTED)
    return made


@pytest.fixture(scope="module")
def server(folder: Path) -> Iterator[PageServer]:
    with view_server(folder / "cell.toml", [folder / "circle.csv"]) as made:
        Thread(target=made.serve_forever, daemon=True).start()
        yield made
        made.shutdown()


def asked(server: PageServer, path: str, content: object = None, **headers: str) -> tuple[int, str]:
    data = None if content is None else json.dumps(content).encode()
    request = urllib.request.Request(server.url.rstrip("/") + path, data=data, headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=60) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as refused:
        return refused.code, refused.read().decode()


def edited(server: PageServer, edit: object, path: str = "/edit") -> dict[str, Any]:
    status, text = asked(server, path, edit, **{"X-Token": server.token})
    assert status == 200
    answer: dict[str, Any] = json.loads(text)
    return answer


def test_it_listens_on_this_machine_alone(server: PageServer) -> None:
    assert server.server_address[0] == "127.0.0.1" and server.url == f"http://127.0.0.1:{server.server_port}/"
    assert asked(server, "/")[0] == 200
    assert asked(server, "/", Host="evil.example")[0] == 403
    assert asked(server, "/../cell.toml")[0] == 404


def test_only_its_own_page_may_edit(server: PageServer) -> None:
    assert asked(server, "/edit", {}) == (403, "refused")
    assert asked(server, "/edit", {}, **{"X-Token": "guess"})[0] == 403
    assert asked(server, "/edit", {}, Host="evil.example", **{"X-Token": server.token})[0] == 403
    assert asked(server, "/other", {}, **{"X-Token": server.token})[0] == 403


def test_the_page_fetches_nothing_from_elsewhere(server: PageServer) -> None:
    page = asked(server, "/")[1]
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)
    assert policy is not None and "default-src 'none'" in policy[1] and "connect-src 'self'" in policy[1]
    assert not re.search(r"<(?:link|img|iframe)|\bsrc=", page)


def test_deflection_follows_the_tool_and_the_work_object(server: PageServer) -> None:
    def worst(answer: dict[str, Any]) -> float:
        return float(answer["numbers"][1]["value"].split()[0])

    plain, longer = edited(server, {}), edited(server, {"tool": {"xyz": [0, 0, 450]}})
    assert worst(longer) > 1.3 * worst(plain)
    assert longer["values"]["tool"] == {"xyz": [0, 0, 450], "rpy": [0, 0, 0]}
    nearer = edited(server, {"workobject": {"xyz": [1300, -100, 800]}})
    elbow = [unpacked(answer["scene"]["joints"]["q"])[2] for answer in (plain, nearer)]
    assert elbow[1] - elbow[0] > 5.0  # deg: it bends for what is nearer
    assert unpacked(nearer["scene"]["stations"]["work"])[3] == pytest.approx(1.3)


def test_reach_is_told(server: PageServer) -> None:
    answer = edited(server, {"workobject": {"xyz": [4000, 0, 800]}})
    assert set(answer) == {"error"} and "circle.csv:" in answer["error"]


@pytest.mark.parametrize(
    ("edit", "why"),
    [
        ([1], "a table of tables"),
        ({"robot": {"xyz": [1, 2, 3]}}, "[robot] is no table"),
        ({"tool": {"mass": [1, 2, 3]}}, "tool.mass cannot be edited"),
        ({"tool": {"xyz": [1, 2]}}, "3 numbers are expected"),
        ({"tool": {"xyz": [1, 2, "3"]}}, "3 numbers are expected"),
        ({"tool": {"xyz": [1, 2, 1e9]}}, "3 numbers are expected"),
        ({"tool": {"xyz": [0, 0, 0.25]}}, "this looks like metres"),
    ],
)
def test_a_wrong_edit_is_refused_in_words(server: PageServer, edit: object, why: str) -> None:
    assert why in edited(server, edit)["error"]


def test_the_cell_is_saved_beside_itself_with_its_comments(server: PageServer, folder: Path) -> None:
    before = (folder / "cell.toml").read_bytes()
    edit = {"workobject": {"xyz": [1490.5, -100, 800], "rpy": [0, 0, 12.5]}}
    answer = edited(server, {"name": "moved.toml", "edit": edit}, "/save")
    text = (folder / "moved.toml").read_text()
    assert answer == {"saved": str(folder / "moved.toml")}
    assert "# on the table\n" in text and "xyz = [1490.5, -100.0, 800.0]  # mm" in text and "# measured in May" in text
    table, old = tomllib.loads(text), tomllib.loads(COMMENTED)
    assert table.pop("workobject") == {"xyz": [1490.5, -100, 800], "rpy": [0, 0, 12.5]}
    assert table == {k: v for k, v in old.items() if k != "workobject"}
    assert (folder / "cell.toml").read_bytes() == before
    again = edited(server, {"name": "moved.toml", "edit": {}}, "/save")
    assert "stands there already" in again["error"] and (folder / "moved.toml").read_text() == text


NOWHERE = ("../out.toml", "/etc/out.toml", "a/b.toml", "out.txt", ".hidden.toml", "", None, "x" * 300)


@pytest.mark.parametrize("name", NOWHERE)
def test_it_saves_nowhere_else(tmp_path: Path, name: object) -> None:
    with pytest.raises(CompensatorError, match=r"expected (the|a) name"):
        new_file(tmp_path, name)


def test_a_text_laid_out_otherwise_is_written_afresh() -> None:
    inline = 'schema = "cell/1"\nworkobject = { xyz = [1.0, 2.0, 3.0] }  # inline\n'
    text = f"{inline}[tools.2]\nxyz = [\n  0.0,\n  0.0,\n  9.0,\n]\n"
    there: dict[str, dict[str, list[float]]] = {"workobject": {"xyz": []}, "tools.2": {"xyz": []}}
    edit = checked_edit({"workobject": {"xyz": [7, 8, 9]}, "tools.2": {"xyz": [4, 5, 6]}}, there)
    table = tomllib.loads(edited_text(text, edit))
    assert table == {"schema": "cell/1", "workobject": {"xyz": [7, 8, 9]}, "tools": {"2": {"xyz": [4, 5, 6]}}}


def test_a_number_in_a_comment_is_not_taken_for_the_value() -> None:
    text = "[tool]\n# xyz = [9.0, 9.0, 9.0]\nxyz = [1.0, 2.0, 3.0]\n[workobject]\nxyz = [5.0, 5.0, 5.0]\n"
    assert edited_text(text, {"tool": {"xyz": [4.0, 4.0, 4.0]}}) == text.replace("[1.0, 2.0, 3.0]", "[4.0, 4.0, 4.0]")


def test_a_cell_alone_shows_its_arm(folder: Path) -> None:
    with view_server(folder / "cell.toml") as made:
        page = made.service.page("token")
        answer = made.service.answers["/edit"]({"tool": {"xyz": [0, 0, 400]}})
    assert "No toolpath" in page and answer["scene"]["stations"]["count"] == 1


def test_a_taken_port_is_told(server: PageServer, folder: Path) -> None:
    with pytest.raises(CompensatorError, match=f"--port {server.server_port}: cannot listen"):
        view_server(folder / "cell.toml", port=server.server_port)


def test_a_cell_that_is_refused_serves_nothing(tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text("schema = 3")
    with pytest.raises(CellError):
        view_server(tmp_path / "cell.toml")


def test_the_verb_prints_its_address_and_ends_with_an_interrupt(folder: Path) -> None:
    command = [sys.executable, "-m", "compensator", "view", str(folder / "cell.toml"), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None and run.stderr is not None
        url = run.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/", url)
        with urllib.request.urlopen(url, timeout=60) as page:
            assert "the cell at work" in page.read().decode()
        run.send_signal(signal.SIGINT)
        assert run.wait(timeout=60) == 0
        assert run.stderr.read() == "Ctrl-C ends it\n"
