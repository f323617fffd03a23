"""URScript text as a tree of statements and blocks, each with its place.

Source: Universal Robots, The URScript Programming Language (def, thread, if, while, end; ``#`` begins a comment).
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

from toolpaths.errors import ReadError

_LINE = re.compile(r"([^\r\n]*+)(\r\n|\r|\n|\Z)")
_CODE = re.compile(r'(?:[^"#]++|"[^"]*+"?)*+')
_HEAD = re.compile(r"(?:def|thread|sec|while|if|elif|else|for)\b")
_NAMED = re.compile(r"([A-Za-z_]\w*+)\s*+\(([^()]*+)\)")
_DEEPEST = 60
FUNCTIONS = ("def", "thread", "sec")


@dataclass(frozen=True, slots=True, eq=False)
class UrNode:
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
    body: list[UrNode] = field(default_factory=list)
    name: str = ""
    parameters: tuple[str, ...] = ()


def tree(text: str, source: str) -> UrNode:
    """The file as one block.

    Raises:
        ReadError: names the line: an end without its block, a block without its end, a nesting that is too deep.
    """
    root = UrNode(word="", text="", line=0, start=0, end=0)
    stack = [root]
    for number, m in enumerate(_LINE.finditer(text), 1):
        code = _CODE.match(m[1])
        raw = code[0].rstrip() if code else ""
        said = raw.lstrip()
        if number == 1 and said.startswith("\xef\xbb\xbf"):
            said = said[3:]
        if not said:
            continue
        start, end = m.start() + len(raw) - len(said), m.start() + len(raw)
        if said == "end":
            if len(stack) == 1:
                raise ReadError(source, number, "'end' without a block", "Give the file as it was posted.")
            stack.pop()
        elif said[-1] == ":" and (head := _HEAD.match(said)):
            _open(
                stack,
                UrNode(word=head[0], text=said[head.end() : -1].strip(), line=number, start=start, end=end),
                source,
            )
        else:
            stack[-1].body.append(UrNode(word="", text=said, line=number, start=start, end=end))
    if len(stack) > 1:
        open_ = stack[-1]
        problem = f"'{open_.word}' without its 'end'"
        raise ReadError(source, open_.line, problem, "The file may be cut off: post it again.")
    return root


def _open(stack: list[UrNode], head: UrNode, source: str) -> None:
    """Take up the head of a block: ``text`` is what stands between its word and the colon."""
    if head.word in ("elif", "else"):
        if stack[-1].word != "if":
            raise ReadError(source, head.line, f"'{head.word}' without an if", "Give the file as it was posted.")
        if head.text:  # its condition may call what moves the arm
            stack[-1].body.append(replace(head, word=""))
        return
    if head.word in FUNCTIONS:
        named = _NAMED.fullmatch(head.text)
        if named is None:
            problem = f"{head.word} {head.text[:30]!r}"
            raise ReadError(source, head.line, problem, "Expected a name and parameters in brackets.")
        parameters = tuple(p.strip() for p in named[2].split(",")) if named[2].strip() else ()
        head = replace(head, name=named[1], parameters=parameters)
    if len(stack) > _DEEPEST:
        raise ReadError(source, head.line, f"blocks nested deeper than {_DEEPEST}", "Simplify the program.")
    stack[-1].body.append(head)
    stack.append(head)
