"""URScript text as a tree of statements and blocks, each with its place.

Source: Universal Robots, The URScript Programming Language (def, thread, if, while, end; ``#`` begins a comment).
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from toolpaths.errors import ReadError

_LINE = re.compile(r"([^\r\n]*+)(\r\n|\r|\n|\Z)")
_CODE = re.compile(r'(?:[^"#]++|"[^"]*+"?)*+')
_HEAD = re.compile(r"(?:def|thread|sec|while|if|elif|else|for)\b")
_NAMED = re.compile(r"([A-Za-z_]\w*+)\s*+\(([^()]*+)\)")
_DEEPEST = 60
FUNCTIONS = ("def", "thread", "sec")


@dataclass(slots=True)
class Node:
    """A statement (``word`` is ``""``), or a block.

    Attributes:
        word: def, thread, sec, while or if.
        text: the statement without indentation and comment; of a block what stands behind its word.
        line: counted from 1.
        start, end: place of the statement in the text; of a block that of its head.
        body: statements of a block, those of all branches of an if.
        name, parameters: of a function.
    """

    word: str
    text: str
    line: int
    start: int
    end: int
    body: list[Node] = field(default_factory=list)
    name: str = ""
    parameters: tuple[str, ...] = ()


def tree(text: str, source: str) -> Node:
    """The file as one block.

    Raises:
        ReadError: names the line: an end without its block, a block without its end, a nesting that is too deep.
    """
    root = Node("", "", 0, 0, 0)
    stack = [root]
    for number, m in enumerate(_LINE.finditer(text), 1):
        code = _CODE.match(m[1])
        raw = code[0].rstrip() if code else ""
        said = raw.lstrip()
        if number == 1 and said.startswith("\xef\xbb\xbf"):
            said = said[3:]
        if not said:
            continue
        start = m.start() + len(raw) - len(said)
        node = Node("", said, number, start, m.start() + len(raw))
        if said == "end":
            if len(stack) == 1:
                raise ReadError(source, number, "'end' without a block", "Give the file as it was posted.")
            stack.pop()
        elif said[-1] == ":" and (head := _HEAD.match(said)):
            _open(stack, node, head, source)
        else:
            stack[-1].body.append(node)
    if len(stack) > 1:
        open_ = stack[-1]
        problem = f"'{open_.word}' without its 'end'"
        raise ReadError(source, open_.line, problem, "The file may be cut off: post it again.")
    return root


def _open(stack: list[Node], node: Node, head: re.Match[str], source: str) -> None:
    word, rest = head[0], node.text[head.end() : -1].strip()
    if word in ("elif", "else"):
        if stack[-1].word != "if":
            raise ReadError(source, node.line, f"'{word}' without an if", "Give the file as it was posted.")
        if rest:  # its condition may call what moves the arm
            node.text = rest
            stack[-1].body.append(node)
        return
    node.word, node.text = word, rest
    if word in FUNCTIONS:
        named = _NAMED.fullmatch(rest)
        if named is None:
            raise ReadError(source, node.line, f"{word} {rest[:30]!r}", "Expected a name and parameters in brackets.")
        node.name = named[1]
        node.parameters = tuple(p.strip() for p in named[2].split(",")) if named[2].strip() else ()
    if len(stack) > _DEEPEST:
        raise ReadError(source, node.line, f"blocks nested deeper than {_DEEPEST}", "Simplify the program.")
    stack[-1].body.append(node)
    stack.append(node)
