"""The syntax tree of a declaration: its statements and their expressions, for mathematical typesetting.

The engine has read the text already, so this need not find mistakes. Statements that it does not know are left as text.
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

_TOKENS = re.compile(
    r"(?P<space>\s+|//[^\n]*|/\*.*?\*/)"
    r"|(?P<number>\d[\d_]*(?:\.\d[\d_]*)?(?:[eE][+-]?\d+)?(?:_?f64)?)"
    r"|(?P<name>[^\W\d]\w*)"
    r"|(?P<text>\"[^\"]*\")"
    r"|(?P<mark>\.\.=|\.\.|<=|>=|==|!=|&&|\|\||[-+*/%<>=!.,;:()\[\]{}|&#])",
    re.DOTALL,
)

#: The precedence of operators.
_BINDING = {"||": 1, "&&": 2, "<": 3, "<=": 3, ">": 3, ">=": 3, "==": 3, "!=": 3, "..": 4, "..=": 4, "+": 5, "-": 5, "*": 6, "/": 6, "%": 6}


class Node(NamedTuple):
    """A node of an expression: its kind, a name or a number, and its operands."""

    kind: str
    value: str
    parts: tuple[Any, ...]


class Statement(NamedTuple):
    """A statement: `lagrangian`, `let` or another keyword; the name of a `let`; the expression; the text."""

    word: str
    name: str
    of: Node | None
    text: str


class _NotKnown(Exception):
    """Raised for a statement that is left as text."""


def statements(text: str) -> list[Statement]:
    """The statements of a text, without blocks in braces (parameters and runs) and constants."""
    found: list[Statement] = []
    tokens, place = _tokens(text), 0
    while place < len(tokens):
        begin, depth = place, 0
        while place < len(tokens):
            mark = tokens[place][1]
            depth += (mark in ("(", "[", "{")) - (mark in (")", "]", "}"))
            place += 1
            if depth == 0 and (mark == ";" or mark == "}" and tokens[begin][1] in ("parameters", "run")):
                break
        if tokens[begin][1] not in ("parameters", "run", "const", "coordinates"):
            found.append(_statement(text, tokens[begin:place]))
    return found


def _tokens(text: str) -> list[tuple[str, str, int]]:
    tokens, place = [], 0
    while place < len(text):
        match = _TOKENS.match(text, place)
        if match is None:
            place += 1
            continue
        if match.lastgroup != "space":
            tokens.append((str(match.lastgroup), match.group(), place))
        place = match.end()
    return tokens


def _statement(text: str, tokens: list[tuple[str, str, int]]) -> Statement:
    own = [mark for _, mark, _ in tokens if mark != ";"]
    end = tokens[-1][2] + len(tokens[-1][1])
    written = text[tokens[0][2] : end]
    try:
        if own[0] == "let" and own[2] == "=":
            return Statement("let", own[1], _Reader(tokens[3:]).all(), written)
        if len(own) > 2 and own[1] == "=":
            return Statement(own[0], own[0], _Reader(tokens[2:]).all(), written)
    except (_NotKnown, IndexError):
        pass
    return Statement(own[0], own[0], None, written)


class _Reader:
    """Parses an expression."""

    def __init__(self, tokens: list[tuple[str, str, int]]) -> None:
        self.tokens = [(kind, mark) for kind, mark, _ in tokens if mark != ";"]
        self.place = 0
        # `[0.0; n]` is the only thing with a semicolon inside; it is not mathematics
        if sum(mark == ";" for _, mark, _ in tokens) > 1:
            raise _NotKnown

    def next(self) -> str:
        return self.tokens[self.place][1] if self.place < len(self.tokens) else ""

    def take(self, *marks: str) -> bool:
        if self.next() in marks:
            self.place += 1
            return True
        return False

    def need(self, mark: str) -> None:
        if not self.take(mark):
            raise _NotKnown

    def all(self) -> Node:
        node = self.expression(0)
        if self.place < len(self.tokens):
            raise _NotKnown
        return node

    def expression(self, least: int) -> Node:
        left = self.unary()
        while (binding := _BINDING.get(self.next(), 0)) > least:
            operator = self.next()
            self.place += 1
            left = Node("operator", operator, (left, self.expression(binding)))
        return left

    def unary(self) -> Node:
        if self.take("-"):
            return Node("minus", "", (self.unary(),))
        if self.take("!"):
            return Node("not", "", (self.unary(),))
        node = self.atom()
        while True:
            if self.take("."):
                name = self.word()
                if self.next() != "(":
                    # `.0`, a part of a tuple
                    node = Node("index", "", (node, Node("name", name, ())))
                else:
                    self.place += 1
                    node = Node("call", name, (node, *self.list(")")))
            elif self.take("["):
                node = Node("index", "", (node, *self.list("]")))
            elif node.kind == "name" and self.take("("):
                node = Node("call", node.value, tuple(self.list(")")))
            else:
                return node

    def word(self) -> str:
        kind, mark = self.tokens[self.place]
        if kind not in ("name", "number"):
            raise _NotKnown
        self.place += 1
        return mark

    def list(self, end: str) -> list[Node]:
        nodes = []
        while not self.take(end):
            nodes.append(self.expression(0))
            if not self.take(","):
                self.need(end)
                break
        return nodes

    def atom(self) -> Node:
        if self.take("("):
            parts = self.list(")")
            is_tuple = len(parts) != 1 or self.tokens[self.place - 2][1] == ","
            return Node("tuple", "", tuple(parts)) if is_tuple else parts[0]
        if self.take("["):
            return Node("list", "", tuple(self.list("]")))
        if self.take("{"):
            node = self.expression(0)
            self.need("}")
            return node
        if self.take("|"):
            names = []
            while not self.take("|"):
                names.append(self.word())
                if not self.take(","):
                    self.need("|")
                    break
            return Node("function", ",".join(names), (self.expression(0),))
        if self.take("if"):
            condition = self.expression(0)
            self.need("{")
            one = self.expression(0)
            self.need("}")
            self.need("else")
            if self.next() == "if":
                return Node("if", "", (condition, one, self.atom()))
            self.need("{")
            other = self.expression(0)
            self.need("}")
            return Node("if", "", (condition, one, other))
        kind, mark = self.tokens[self.place]
        if kind not in ("name", "number"):
            raise _NotKnown
        self.place += 1
        return Node(kind, mark, ())
