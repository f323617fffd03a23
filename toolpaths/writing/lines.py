"""Lines of a written program: their ends, what stands between moves, and all of them read again."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from toolpaths.writing.program import Order, Program

#: Commands that every robot language has a word for by itself: a tool has its data, a halt is one.
MOUNT, HALT = "M6", "M0"


def with_crlf(pieces: Iterator[str]) -> Iterator[str]:
    """Line ends as the makers' tools on Windows write them."""
    for piece in pieces:
        yield piece.replace("\n", "\r\n")


@dataclass(frozen=True)
class Between:
    """How a language spells what stands between moves; each gives whole lines.

    Attributes:
        comment: a comment of this text.
        line: a line that the user gave.
        halt: the arm stands until the operator, who is shown the text, lets it go on.
        mount: the data of the tool of this number hold from here on.
        go: a joint move to this pose.
        change: the machine takes the tool of this number; None: the operator does, at a halt.
        say: an order that the language has words for; None: it has none, but for the halt.
    """

    comment: Callable[[str], str]
    line: Callable[[str], str]
    halt: Callable[[str], str]
    mount: Callable[[int], str]
    go: Callable[[int], str]
    change: Callable[[int], str] | None = None
    say: Callable[[Order], str] | None = None


def lines_before(program: Program, between: Between, block: slice | None = None) -> dict[int, str]:
    """Pose -> the lines in front of its move, of those that have some; those behind the last move at its length.

    What is ordered in front of the first pose is left to ``lines_at_start``: it comes before the moves to the start.

    Args:
        block: the poses asked for; None: all.
    """
    n = len(program)
    first, stop = (0, n + 1) if block is None else (block.start, block.stop + (block.stop == n))
    before: dict[int, str] = {}
    for pose, text in program.comments:
        if first <= pose < stop:
            before[pose] = before.get(pose, "") + between.comment(text)
    orders: dict[int, list[Order]] = {}
    for order in program.orders:
        orders.setdefault(order.pose, []).append(order)
    changes = program.tool_changes
    for pose in {*orders, *changes}:
        if max(first, 1) <= pose < stop:
            before[pose] = before.get(pose, "") + _said(program, between, pose, orders.get(pose, []))
    return {pose: lines for pose, lines in before.items() if lines}


def lines_at_start(program: Program, between: Between) -> str:
    """What is ordered in front of the first pose; its tool is taken to be mounted, and its data to hold already."""
    return _said(program, between, 0, [order for order in program.orders if order.pose == 0])


def joint_moves(program: Program) -> list[int]:
    """Poses behind the first that a joint move goes to: the arm comes from where a tool was mounted."""
    mounted = [o.pose for o in program.orders if o.command.word == MOUNT and o.lines and 0 < o.pose < len(program)]
    return sorted({*mounted, *program.tool_changes})


def interrupted(program: Program) -> list[int]:
    """Poses in front of which the program does more than move: the arm has to stand at the ones before."""
    acting = [o.pose for o in program.orders if o.lines or (o.lines is None and o.command.word == HALT)]
    return sorted({*acting, *program.tool_changes})


def _said(program: Program, between: Between, pose: int, orders: list[Order]) -> str:
    """The lines for the orders in front of a pose, and for the tool that goes there."""
    out = ""
    mount = _mount(program, between, pose) if pose in program.tool_changes else ("", "")
    if not any(order.command.word == MOUNT for order in orders):
        out, mount = "".join(mount), ("", "")
    for order in orders:
        word, lines = order.command.word, order.lines
        if word == MOUNT:
            out += (mount[0] if lines is None else "".join(map(between.line, lines))) + mount[1]
            mount = ("", "")
        elif lines is not None:
            out += "".join(map(between.line, lines))
        elif between.say:
            out += between.say(order)
        elif word == HALT:
            out += between.halt(f"{order.text} in line {order.line}")
    return out + (between.go(pose) if pose in joint_moves(program) else "")


def _mount(program: Program, between: Between, pose: int) -> tuple[str, str]:
    """The tool of a pose is mounted; its data hold."""
    number = int(program.tool[pose])
    text = f"mount tool {number} ({program.tools[number].name}), then go on"
    return between.change(number) if between.change else between.halt(text), between.mount(number)


def text_of(path: Path) -> str:
    """The text of a written program, line ends as they are."""
    with open(path, encoding="ascii", newline="") as stream:
        return stream.read()
