"""Systems from Python expressions.

`coordinates` and `parameter` give expressions. Operators and numpy's functions make others of them, `dot` and `ddot` their time derivatives, and
`System.of` a system, whose text says the same in the language of the text files.
"""

from __future__ import annotations

import keyword
import numbers
import re
import sys
from typing import Any, Callable, Iterable, Iterator, Mapping, Sequence, Union

import numpy as np

from ._errors import InputTypeError, SetupError
from ._inputs import miscounted, number, unknown

#: The types that an operator takes besides expressions.
ExpressionLike = Union["Expression", float, int]

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
# the words of the language, which cannot be names
_WORDS = frozenset(
    "as break const continue crate dot ddot dddot each else enum extern false fn for h if impl in let loop match mod move mut node leg parameters pi pub "
    "ref return run samples self Self static struct sum super t tau trait true type unsafe use where while async await dyn PI TAU".split()
)

#: the meanings of some of them, for messages
_MEANINGS = {
    "t": "the time", "h": "the step", "PI": "the number π", "TAU": "the number 2π", "pi": "the number π", "tau": "the number 2π", "dot": "the time derivative",
    "ddot": "the second time derivative", "dddot": "the third time derivative", "sum": "a sum", "parameters": "the block of the parameters", "samples": "a table of samples",
    "run": "the block of a run", "each": "a row for each index", "node": "the number of a node", "leg": "the number of a leg", "const": "what begins a constant", "let": "what begins a name",
}  # fmt: skip

# the precedence of operators in the text: sums, products, signs, calls and names
_SUM, _PRODUCT, _SIGN, _ATOM = range(4)


class Expression:
    """A quantity of a declaration: made by `coordinates`, `parameter`, `dot`, operators and numpy's functions."""

    __slots__ = ("_args", "_op", "_value")

    def __init__(self, op: str, args: tuple[Expression, ...] = (), value: Any = None) -> None:
        self._op = op
        self._args = args
        self._value = value

    # operators

    def __add__(self, other: Any) -> Any:
        return _binary("+", self, other)

    def __radd__(self, other: Any) -> Any:
        return _binary("+", other, self)

    def __sub__(self, other: Any) -> Any:
        return _binary("-", self, other)

    def __rsub__(self, other: Any) -> Any:
        return _binary("-", other, self)

    def __mul__(self, other: Any) -> Any:
        return _binary("*", self, other)

    def __rmul__(self, other: Any) -> Any:
        return _binary("*", other, self)

    def __truediv__(self, other: Any) -> Any:
        return _binary("/", self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return _binary("/", other, self)

    def __neg__(self) -> Expression:
        return Expression("neg", (self,))

    def __pos__(self) -> Expression:
        return self

    def __abs__(self) -> Expression:
        return _call("abs", self)

    def __pow__(self, other: Any) -> Any:
        exponent = _maybe(other)
        if exponent is None:
            return NotImplemented
        if exponent._op == "number" and float(exponent._value).is_integer() and abs(exponent._value) < 2**31:
            return Expression("powi", (self,), int(exponent._value))
        return Expression("powf", (self, exponent))

    def __rpow__(self, other: Any) -> Any:
        base = _maybe(other)
        return NotImplemented if base is None else Expression("powf", (base, self))

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if function is np.where:
            raise InputTypeError("np.where does not know expressions: write dsocs.where(a < b, x, y)")
        return _refused(f"numpy's {function.__name__}")

    def __bool__(self) -> bool:
        raise InputTypeError(
            f"`{self}` is neither true nor false: it has a value in a run alone; where it decides, write where(a < b, x, y)"
        )

    def _sympy_(self) -> Any:
        raise InputTypeError(
            f"`{self}` is an expression of dsocs, and meets one of sympy: write a system in one of the two; dsocs.to_sympy({self}) is this one in sympy"
        )

    def __float__(self) -> float:
        raise InputTypeError(f"`{self}` has a value in a run alone: use numpy's functions (np.sin) in place of those of math")

    def __lt__(self, other: Any) -> Any:
        return _compared("<", self, other)

    def __le__(self, other: Any) -> Any:
        return _compared("<=", self, other)

    def __gt__(self, other: Any) -> Any:
        return _compared("<", other, self)

    def __ge__(self, other: Any) -> Any:
        return _compared("<=", other, self)

    def __str__(self) -> str:
        return _Printer({}).text(self)

    def __repr__(self) -> str:
        return f"<Expression {self}>"

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        function = _UFUNCS.get(ufunc.__name__)
        if function is None or method != "__call__" or options:
            return _refused(f"numpy's {ufunc.__name__}")
        if any(isinstance(x, np.ndarray) and x.ndim for x in inputs):
            arrays = np.broadcast_arrays(*(np.asarray(x, dtype=object) for x in inputs))
            result = np.empty(arrays[0].shape, dtype=object)
            for place in np.ndindex(result.shape):
                result[place] = function(*(x[place] for x in arrays))
            return result
        return function(*inputs)

    # numpy's functions of object arrays call these methods

    def sin(self) -> Expression:
        return _call("sin", self)

    def cos(self) -> Expression:
        return _call("cos", self)

    def tan(self) -> Expression:
        return _call("tan", self)

    def arcsin(self) -> Expression:
        return _call("asin", self)

    def arccos(self) -> Expression:
        return _call("acos", self)

    def arctan(self) -> Expression:
        return _call("atan", self)

    def sinh(self) -> Expression:
        return _call("sinh", self)

    def cosh(self) -> Expression:
        return _call("cosh", self)

    def tanh(self) -> Expression:
        return _call("tanh", self)

    def arcsinh(self) -> Expression:
        return _call("asinh", self)

    def arccosh(self) -> Expression:
        return _call("acosh", self)

    def arctanh(self) -> Expression:
        return _call("atanh", self)

    def exp(self) -> Expression:
        return _call("exp", self)

    def expm1(self) -> Expression:
        return _call("exp_m1", self)

    def log(self) -> Expression:
        return _call("ln", self)

    def log1p(self) -> Expression:
        return _call("ln_1p", self)

    def sqrt(self) -> Expression:
        return _call("sqrt", self)

    def cbrt(self) -> Expression:
        return _call("cbrt", self)

    def sign(self) -> Expression:
        return _call("signum", self)

    def square(self) -> Expression:
        return Expression("powi", (self,), 2)

    def arctan2(self, x: ExpressionLike) -> Expression:
        return _call("atan2", self, x)


def _expression(name: str, given: Any) -> Expression:
    """An expression; the error for anything else contains the name of the argument."""
    found = _maybe(given)
    if found is not None:
        return found
    if _is_matrix(given) and given.shape == (1, 1):
        given = given[0]
    converted = _from_sympy(given)
    if converted is None:
        if isinstance(given, tuple) and len(given) == 1 and isinstance(given[0], Expression):
            own = given[0]._value[0] if given[0]._op == "coordinate" else "x"
            raise InputTypeError(
                f"{name} is a tuple of one expression: `coordinates` gives a tuple; with a comma, `{own}, = dsocs.coordinates({own!r})`, its element has the name"
            )
        raise InputTypeError(f"{name} is {given!r:.80}; expected an expression")
    return converted


def _maybe(given: Any) -> Expression | None:
    if isinstance(given, Expression):
        return given
    if isinstance(given, np.ndarray) and given.ndim == 0:
        return _maybe(given.item())
    if isinstance(given, (bool, np.bool_)):
        return None
    if isinstance(given, (numbers.Real, np.number)) and not _is_sympy(given):
        return Expression("number", value=number("a number of an expression", given))
    return None


def _binary(op: str, left: Any, right: Any) -> Any:
    if isinstance(left, np.ndarray) and left.ndim or isinstance(right, np.ndarray) and right.ndim:
        return NotImplemented
    first, second = _maybe(left), _maybe(right)
    if first is None or second is None:
        return NotImplemented
    return Expression(op, (first, second))


def _compared(op: str, left: Any, right: Any) -> Any:
    first, second = _maybe(left), _maybe(right)
    if first is None or second is None:
        return NotImplemented
    return Expression(op, (first, second))


def _call(name: str, *args: Any) -> Expression:
    return Expression("call", tuple(_expression(f"an argument of {name}", arg) for arg in args), name)


def _refused(what: str) -> Any:
    raise InputTypeError(f"{what} has no counterpart in a declaration")


def _method(name: str) -> Callable[..., Expression]:
    return lambda x, *others: _call(name, x, *others)


def _minimum(a: Any, b: Any) -> Expression:
    return where(_compared("<", a, b), a, b)


def _maximum(a: Any, b: Any) -> Expression:
    return where(_compared("<", a, b), b, a)


_UFUNCS: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: _binary("+", a, b),
    "subtract": lambda a, b: _binary("-", a, b),
    "multiply": lambda a, b: _binary("*", a, b),
    "divide": lambda a, b: _binary("/", a, b),
    "power": lambda a, b: _expression("a base", a) ** b,
    "float_power": lambda a, b: _expression("a base", a) ** b,
    "negative": lambda a: -a,
    "positive": lambda a: a,
    "absolute": abs,
    "fabs": abs,
    "square": lambda a: a**2,
    "reciprocal": lambda a: 1 / a,
    "sign": _method("signum"),
    "arctan2": _method("atan2"),
    "hypot": lambda a, b: _call("sqrt", _expression("x", a) ** 2 + _expression("y", b) ** 2),
    "minimum": _minimum,
    "maximum": _maximum,
    "less": lambda a, b: _compared("<", a, b),
    "less_equal": lambda a, b: _compared("<=", a, b),
    "greater": lambda a, b: _compared("<", b, a),
    "greater_equal": lambda a, b: _compared("<=", b, a),
    **{
        name: _method(own)
        for name, own in dict(
            sin="sin", cos="cos", tan="tan", arcsin="asin", arccos="acos", arctan="atan", sinh="sinh", cosh="cosh", tanh="tanh",
            arcsinh="asinh", arccosh="acosh", arctanh="atanh", exp="exp", expm1="exp_m1", log="ln", log1p="ln_1p", sqrt="sqrt", cbrt="cbrt",
        ).items()
    },
}  # fmt: skip


def _a(kind: str) -> str:
    return f"an {kind}" if kind[0] in "aeiou" else f"a {kind}"


def _checked_name(kind: str, name: object) -> str:
    if not isinstance(name, str):
        raise InputTypeError(f"the name of {_a(kind)} is {name!r}; expected a text")
    if (meaning := _MEANINGS.get(name)) is not None:
        raise SetupError(f"`{name}` cannot be the name of {_a(kind)}: in a declaration it is {meaning}; take another name, such as `{name}1`")
    if not _NAME.match(name) or name in _WORDS or keyword.iskeyword(name):
        turns = "; rotations and arrays of coordinates are said in a text: dsocs.System(\"…\")" if kind == "coordinate" and ":" in str(name) else ""
        raise SetupError(f"`{name}` cannot be the name of {_a(kind)}: take another name, a word of letters, digits and `_` that means nothing else{turns}")
    return name


def coordinates(*names: str, doc: Mapping[str, str] | None = None) -> tuple[Expression, ...]:
    """The coordinates of a system, in their order: `x, y = dsocs.coordinates("x", "y")`. `doc` gives their meanings, with the unit at the end:
    `{"x": "The place [m]"}`."""
    if not names:
        raise SetupError("no names are given; expected those of the coordinates, coordinates('x', 'y')")
    checked = [_checked_name("coordinate", name) for name in names]
    for place, name in enumerate(checked):
        if name in checked[:place]:
            raise SetupError(f"the coordinate `{name}` is named twice")
    if doc is not None and not isinstance(doc, Mapping):
        raise InputTypeError(f"doc is {doc!r:.60}; expected a dict that says by name what a coordinate is, doc={{{checked[0]!r}: 'The angle [rad]'}}")
    docs = dict(doc or {})
    for name in docs:
        if name not in checked:
            raise SetupError(f"doc says what `{name}` is, which is no coordinate")
    return tuple(Expression("coordinate", value=(name, docs.get(name, ""))) for name in checked)


def parameter(name: str, value: float, doc: str = "") -> Expression:
    """A parameter and its value; `doc` gives its meaning, with the unit at the end: `"The length of the rod [m]"`."""
    checked = _checked_name("parameter", name)
    return Expression("parameter", value=(checked, number(checked, value), doc))


#: The time.
time = Expression("time")


def dot(x: ExpressionLike) -> Expression:
    """The time derivative of an expression."""
    return Expression("dot", (_expression("the argument of dot", x),))


def ddot(x: ExpressionLike) -> Expression:
    """The second time derivative of a coordinate, its acceleration."""
    return Expression("ddot", (_expression("the argument of ddot", x),))


def dddot(x: ExpressionLike) -> Expression:
    """The third time derivative of a coordinate."""
    return Expression("dddot", (_expression("the argument of dddot", x),))


def where(condition: Any, x: ExpressionLike, y: ExpressionLike) -> Expression:
    """`x` where a comparison holds, and `y` elsewhere: `where(a < b, x, y)`."""
    if not isinstance(condition, Expression) or condition._op not in ("<", "<="):
        raise InputTypeError(f"the condition is {condition!r:.80}; expected a comparison, a < b")
    return Expression("where", (condition, _expression("x", x), _expression("y", y)))


class _Printer:
    """Prints expressions as text; shared parts may be replaced by names."""

    def __init__(self, named: Mapping[int, str]) -> None:
        self.named = named

    def text(self, of: Expression, least: int = _SUM) -> str:
        # not recursive: a sum of thousands of terms is deeply nested
        done: dict[int, tuple[str, int]] = {}
        stack = [of]
        while stack:
            node = stack[-1]
            if id(node) in done:
                stack.pop()
                continue
            if id(node) in self.named and node is not of:
                done[id(node)] = (self.named[id(node)], _ATOM)
                continue
            missing = [arg for arg in node._args if id(arg) not in done]
            if missing:
                stack.extend(missing)
                continue
            done[id(node)] = self._print(node, lambda arg, level: _fenced(*done[id(arg)], level))
        return _fenced(*done[id(of)], least)

    @staticmethod
    def _print(node: Expression, arg: Callable[[Expression, int], str]) -> tuple[str, int]:
        op, args, value = node._op, node._args, node._value
        if op == "number":
            shown = _number(value)
            return shown, _SIGN if shown.startswith("-") else _ATOM
        if op in ("coordinate", "parameter"):
            return value[0], _ATOM
        if op == "time":
            return "t", _ATOM
        if op in ("+", "-"):
            return f"{arg(args[0], _SUM)} {op} {arg(args[1], _PRODUCT)}", _SUM
        if op in ("*", "/"):
            return f"{arg(args[0], _PRODUCT)} {op} {arg(args[1], _SIGN)}", _PRODUCT
        if op == "neg":
            return f"-{arg(args[0], _SIGN)}", _SIGN
        if op == "powi":
            return f"{arg(args[0], _ATOM)}.powi({value})", _ATOM
        if op == "powf":
            return f"{arg(args[0], _ATOM)}.powf({arg(args[1], _SUM)})", _ATOM
        if op in ("dot", "ddot", "dddot"):
            return f"{op}({arg(args[0], _SUM)})", _ATOM
        if op == "call":
            others = ", ".join(arg(other, _SUM) for other in args[1:])
            return f"{arg(args[0], _ATOM)}.{value}({others})", _ATOM
        if op in ("<", "<="):
            return f"{arg(args[0], _SUM)} {op} {arg(args[1], _SUM)}", -1
        condition = arg(args[0], -1)
        return f"(if {condition} {{ {arg(args[1], _SUM)} }} else {{ {arg(args[2], _SUM)} }})", _ATOM


def _fenced(text: str, level: int, least: int) -> str:
    return text if level >= least else f"({text})"


def _number(value: float) -> str:
    if float(value).is_integer() and abs(value) < 1e15:
        return f"{float(value):.1f}"
    return repr(float(value))


def _walk(roots: Iterable[Expression]) -> Iterator[Expression]:
    """All subexpressions of expressions, each once, inner ones before those that contain them."""
    seen: set[int] = set()
    stack = [(root, False) for root in reversed(list(roots))]
    while stack:
        node, ready = stack.pop()
        if ready:
            yield node
        elif id(node) not in seen:
            seen.add(id(node))
            stack.append((node, True))
            stack.extend((arg, False) for arg in reversed(node._args))


def _several(given: Any) -> list[Any]:
    """The elements of a list, an array or a matrix of sympy; a single one is a list of one."""
    return list(given) if isinstance(given, (list, tuple)) or isinstance(given, np.ndarray) and given.ndim or _is_matrix(given) else [given]


def _rows(name: str, given: Any) -> list[Expression]:
    """The rows of an argument: one, or several."""
    if given is None:
        return []
    rows = _several(given)
    return [_expression(f"{name}[{place}]" if len(rows) > 1 or rows[0] is not given else name, _row(row)) for place, row in enumerate(rows)]


def _row(given: Any) -> Any:
    """A row that is zero; an equation of sympy is that of its sides' difference."""
    sympy = sys.modules.get("sympy")
    return given.lhs - given.rhs if sympy is not None and isinstance(given, sympy.Eq) else given


def _fields(name: str, given: Any, own: Sequence[str]) -> list[list[Expression]]:
    """Vectors, each with a component for each coordinate."""
    if _is_matrix(given):
        # a column is one vector
        given = [given] if given.shape == (len(own), 1) else given.tolist()
    if not isinstance(given, (list, tuple, np.ndarray)):
        raise InputTypeError(f"{name} is {given!r:.80}; expected a list of vectors, each with a component for each coordinate")
    return [_components(f"{name}[{place}]", field, own) for place, field in enumerate(given)]


def _components(name: str, given: Any, own: Sequence[str]) -> list[Expression]:
    """The components of a vector, one for each coordinate, in their order or by name; those that are not named are zero."""
    if isinstance(given, Mapping):
        by_name = {}
        for key, component in given.items():
            of = _context.coordinates.get(key, key) if _context is not None else key
            coordinate = of._value[0] if isinstance(of, Expression) and of._op == "coordinate" else str(key)
            if coordinate not in own:
                raise SetupError(f"{name} has a component for `{key}`, which is no coordinate; these are {', '.join(own)}")
            by_name[coordinate] = _expression(f"{name}[{coordinate!r}]", component)
        return [by_name.get(coordinate, Expression("number", value=0.0)) for coordinate in own]
    parts = _several(given)
    if len(parts) != len(own):
        raise SetupError(miscounted(name, len(parts), own))
    return [_expression(f"{name}[{place}]", component) for place, component in enumerate(parts)]


def written(
    own: Any,
    *,
    lagrangian: Any,
    holonomic: Any,
    nonholonomic: Any,
    kinematic: Any,
    variational: Any,
    constraint_forces: Any,
    external_forces: Any,
    branch: Any,
    observe: Mapping[str, Any] | None,
    parameters: Mapping[str, float] | None,
    doc: str,
) -> str:
    """The text of a system that is given by expressions."""
    if parameters is not None and not isinstance(parameters, Mapping):
        raise InputTypeError(f"parameters is {type(parameters).__name__}; expected a dict of values by name")
    given_values: dict[str, float] = {}
    for name, value in dict(parameters or {}).items():
        checked = number(f"parameters[{str(name)!r}]", value)
        # sympy takes symbols of one name with other assumptions for different ones; a declaration has names alone
        if given_values.setdefault(str(name), checked) != checked:
            raise _two_values(str(name), given_values[str(name)], checked)
    if observe is not None and not isinstance(observe, Mapping):
        raise InputTypeError(f"observe is {observe!r:.60}; expected a dict of expressions by the names under which they are observed, observe={{'height': …}}")
    given = list(own) if _is_matrix(own) or hasattr(own, "__iter__") else [own]
    with _sympy_context(given, given_values):
        listed = [_expression(f"coordinates[{place}]", of) for place, of in enumerate(given)]
        names: list[str] = []
        for place, of in enumerate(listed):
            if of._op != "coordinate":
                raise InputTypeError(f"coordinates[{place}] is `{of}`; expected one that dsocs.coordinates gave")
            names.append(of._value[0])
        if not names:
            raise SetupError("there are no coordinates; expected those of the system in their order, coordinates=(x, y)")
        statements: list[tuple[str, list[list[Expression]], Callable[[list[list[str]]], str]]] = []

        def one(rows: list[list[str]]) -> str:
            return rows[0][0]

        def many(rows: list[list[str]]) -> str:
            return rows[0][0] if len(rows[0]) == 1 else "[" + ", ".join(rows[0]) + "]"

        def vector(rows: list[list[str]]) -> str:
            return rows[0][0] if len(rows[0]) == 1 else "(" + ", ".join(rows[0]) + ")"

        def vectors(rows: list[list[str]]) -> str:
            return "[" + ", ".join("(" + ", ".join(row) + ("," if len(row) == 1 else "") + ")" for row in rows) + "]"

        statements.append(("lagrangian", [[_expression("lagrangian", lagrangian)]], one))
        for name, rows in (("holonomic", holonomic), ("nonholonomic", nonholonomic), ("kinematic", kinematic)):
            if found := _rows(name, rows):
                statements.append((name, [found], many))
        if isinstance(variational, str):
            if variational != "chetaev":
                raise SetupError(f"variational is {variational!r}; expected vectors, or 'chetaev'")
            statements.append(("variational", [], lambda rows: "chetaev"))
        elif variational is not None:
            statements.append(("variational", _fields("variational", variational, names), vectors))
        if constraint_forces is not None:
            statements.append(("constraint_forces", _fields("constraint_forces", constraint_forces, names), vectors))
        if external_forces is not None:
            statements.append(("external_forces", [_components("external_forces", external_forces, names)], vector))
        if branch is not None:
            statements.append(("branch", [[_expression("branch", branch)]], lambda rows: f"divide({rows[0][0]})"))
        observed = {
            _checked_name("observed expression", name): _expression(f"observe[{name!r}]", of) for name, of in dict(observe or {}).items()
        }
    roots = [part for _, rows, _ in statements for row in rows for part in row] + list(observed.values())
    nodes = list(_walk(roots))
    declared = _known(nodes, names)
    _check_used(given_values, declared)
    # first those that are given, in their order: sympy has an order of its own within sums and products
    known = {name: (value, declared[name][1]) for name, value in given_values.items()}
    known.update({name: of for name, of in declared.items() if name not in known})
    for name in observed:
        if name in known or name in names:
            raise SetupError(f"observe has an expression `{name}`, which is the name of a {'parameter' if name in known else 'coordinate'}; take another name")
    used = {*names, *known, *observed}
    # a part that occurs several times is written once, as a `let`
    counts: dict[int, int] = {}
    for node in nodes:
        for arg in node._args:
            counts[id(arg)] = counts.get(id(arg), 0) + 1
    for root in roots:
        counts[id(root)] = counts.get(id(root), 0) + 1
    named: dict[int, str] = {}
    printer = _Printer(named)
    lets = []
    for node in nodes:
        if counts.get(id(node), 0) > 1 and node._args and node._op not in ("neg", "<", "<=", "dot", "ddot", "dddot"):
            name = next(f"e{place}" for place in range(len(used) + 1) if f"e{place}" not in used)
            used.add(name)
            lets.append(f"let {name} = {printer.text(node)};")
            named[id(node)] = name
    lines = [f"//! {line}" for line in doc.splitlines()]
    if known:
        lines.append("parameters {")
        for name, (value, about) in known.items():
            lines.extend(f"    /// {line}" for line in about.splitlines())
            lines.append(f"    {name} = {_number(value)},")
        lines.append("}")
    lines.append("coordinates(")
    for of in listed:
        lines.extend(f"    /// {line}" for line in of._value[1].splitlines())
        lines.append(f"    {of._value[0]},")
    lines.append(");")
    lines.extend(lets)

    def shown(part: Expression) -> str:
        return named.get(id(part)) or printer.text(part)

    for name, rows, print_ in statements:
        lines.append(f"{name} = {print_([[shown(part) for part in row] for row in rows])};")
    for name, of in observed.items():
        lines.append(f"let {name} = {shown(of)};")
    if observed:
        lines.append(f"observe = [{', '.join(observed)}];")
    return "\n".join(lines) + "\n"


def _known(nodes: Iterable[Expression], names: Sequence[str]) -> dict[str, tuple[float, str]]:
    """The parameters of expressions, with their values."""
    known: dict[str, tuple[float, str]] = {}
    for node in nodes:
        if node._op == "coordinate" and node._value[0] not in names:
            raise SetupError(f"the coordinate `{node._value[0]}` is used, and is none of the system's; these are {', '.join(names)}")
        if node._op == "parameter":
            name, value, about = node._value
            if name in names:
                raise SetupError(f"`{name}` is a coordinate and a parameter")
            before = known.get(name)
            if before is not None and before[0] != value:
                raise _two_values(name, before[0], value)
            known[name] = (value, about or (before[1] if before else ""))
    return known


def _check_used(given: Mapping[str, float], known: Mapping[str, Any]) -> None:
    """Refuses values of parameters that no expression contains: one of them may be misspelt."""
    unused = [name for name in given if name not in known]
    if len(unused) == 1:
        raise SetupError(f"{unknown('parameter', unused[0], known)}: no expression contains `{unused[0]}`; leave it out of parameters, if it is not misspelt")
    if unused:
        used = ", ".join(repr(name) for name in known)
        raise SetupError(
            f"no expression contains the parameters {', '.join(f'`{name}`' for name in unused)}; the system has {', '.join(known) or 'none'}. A dict that several "
            f"systems share is cut down to those of this one: parameters={{name: shared[name] for name in shared if str(name) in ({used}{',' if len(known) == 1 else ''})}}"
        )


def _two_values(name: str, one: float, other: float) -> SetupError:
    return SetupError(f"the parameter `{name}` has two values, {one:g} and {other:g}; give one of the two another name")


# sympy


class _SympyContext:
    """The meanings of sympy's symbols while a system is written."""

    def __init__(self, own: Sequence[Any], parameters: Mapping[str, float] | None) -> None:
        self.parameters = {str(name): value for name, value in dict(parameters or {}).items()}
        self.coordinates: dict[Any, Expression] = {}
        self.time: Any = None
        self.done: dict[Any, Expression] = {}
        self.own = own


_context: _SympyContext | None = None


class _sympy_context:  # noqa: N801
    def __init__(self, own: Sequence[Any], parameters: Mapping[str, float] | None) -> None:
        self.context = _SympyContext(own, parameters)

    def __enter__(self) -> None:
        global _context
        _context = self.context
        for of in self.context.own:
            if _is_sympy(of):
                if not of.is_Function or len(of.args) != 1:
                    own = str(of) if of.is_Symbol else "q"
                    raise SetupError(f"the coordinate `{of}` is no function of the time alone: sympy.physics.mechanics.dynamicsymbols({own!r}) is one")
                self.context.time = of.args[0]
                name = _checked_name("coordinate", str(of.func))
                self.context.coordinates[of] = Expression("coordinate", value=(name, ""))

    def __exit__(self, *_: object) -> None:
        global _context
        _context = None


def _is_sympy(given: Any) -> bool:
    """Whether a value is a sympy expression; sympy is not imported for it."""
    sympy = sys.modules.get("sympy")
    return sympy is not None and isinstance(given, sympy.Basic)


def _is_matrix(given: Any) -> bool:
    """Whether a value is a matrix of sympy."""
    sympy = sys.modules.get("sympy")
    return sympy is not None and isinstance(given, sympy.MatrixBase)


def _from_sympy(given: Any) -> Expression | None:
    """An expression from a sympy expression; None for other values."""
    if not _is_sympy(given):
        return None
    context = _context if _context is not None else _SympyContext((), None)
    if given in context.done:
        return context.done[given]
    found = _converted(given, context)
    context.done[given] = found
    return found


_SYMPY = dict(
    sin="sin", cos="cos", tan="tan", asin="asin", acos="acos", atan="atan", sinh="sinh", cosh="cosh", tanh="tanh", asinh="asinh", acosh="acosh",
    atanh="atanh", exp="exp", log="ln", Abs="abs", sign="signum", atan2="atan2", Max="max", Min="min",
)  # fmt: skip

#: What stands for functions of sympy that a declaration does not know.
_SUBSTITUTES = {
    "Heaviside": "Piecewise((0, x < 0), (1, True))", "sec": "1/cos(x)", "csc": "1/sin(x)", "cot": "1/tan(x)", "sech": "1/cosh(x)", "csch": "1/sinh(x)",
    "coth": "1/tanh(x)", "sinc": "sin(x)/x",
}  # fmt: skip


def _converted(given: Any, context: _SympyContext) -> Expression:
    import sympy
    from sympy.core.function import AppliedUndef

    def of(part: Any) -> Expression:
        return _expression("a part of an expression of sympy", part)

    if given in context.coordinates:
        return context.coordinates[given]
    if context.time is not None and given == context.time:
        return time
    if given.is_Number or given.is_NumberSymbol:
        return Expression("number", value=number(str(given), float(given)))
    if given.is_Symbol:
        name = str(given)
        if context.time is not None and name == str(context.time):
            raise SetupError(
                f"the symbol `{name}` is not the time of the coordinates, since it has other assumptions: take theirs, "
                "`sympy.physics.mechanics.dynamicsymbols._t`"
            )
        if name not in context.parameters and name not in _MEANINGS:
            raise SetupError(f"the symbol `{name}` is neither a coordinate nor the time, and has no value: parameters={{{name!r}: …}} gives one")
        if name in _MEANINGS:
            raise SetupError(
                f"the symbol `{name}` cannot be a parameter: in a declaration it is {_MEANINGS[name]}; take a symbol of another name, sympy.Symbol('{name}1'), or "
                f"put it in place of this one, `.subs({name}, sympy.Symbol('{name}1'))`"
            )
        return parameter(name, context.parameters[name])
    if given.is_Add or given.is_Mul:
        op = "+" if given.is_Add else "*"
        parts = [of(part) for part in given.args]
        result = parts[0]
        for part in parts[1:]:
            result = Expression(op, (result, part))
        return result
    if given.is_Pow:
        base, exponent = given.args
        if base == sympy.E:
            return _call("exp", of(exponent))
        if exponent == sympy.Rational(1, 2):
            return _call("sqrt", of(base))
        if exponent.is_Rational:
            return of(base) ** (int(exponent) if exponent.is_Integer else float(exponent))  # type: ignore[no-any-return]
        return of(base) ** of(exponent)  # type: ignore[no-any-return]
    if isinstance(given, sympy.Derivative):
        if len(given.variable_count) != 1 or given.variable_count[0][0] != context.time:
            raise SetupError(f"`{given}` is no derivative by the time")
        count = int(given.variable_count[0][1])
        inner = of(given.expr)
        if count > 3:
            raise SetupError(f"`{given}` is a derivative above the third")
        return Expression(("dot", "ddot", "dddot")[count - 1], (inner,))
    name = type(given).__name__
    if name in ("Max", "Min"):
        first, *others = (of(part) for part in given.args)
        for other in others:
            first = _call(_SYMPY[name], first, other)
        return first
    if name in _SYMPY:
        return _call(_SYMPY[name], *(of(part) for part in given.args))
    if isinstance(given, sympy.Piecewise):
        *branches, (last, condition) = given.args
        if condition != sympy.true:
            raise SetupError(f"`{given}` has no value where none of its conditions holds: its last part is `(…, True)`")
        chosen = of(last)
        for x, condition in reversed(branches):
            chosen = _chosen(condition, of(x), chosen)
        return chosen
    if name in _SUBSTITUTES:
        raise SetupError(f"a declaration does not know `{given}`: what stands for it is {_SUBSTITUTES[name]}")
    if isinstance(given, AppliedUndef):
        own = str(given.func)
        raise SetupError(
            f"`{given}` is none of the coordinates; an input, which a run may set, is a symbol with a value, sympy.Symbol({own!r}) and "
            f"parameters={{{own!r}: …}}"
        )
    if given.is_Function:
        raise SetupError(f"`{given}` is no function that a declaration knows")
    raise SetupError(f"`{given}` has no counterpart in a declaration")


def _chosen(condition: Any, x: Expression, y: Expression) -> Expression:
    """`x` where a condition of sympy holds, and `y` elsewhere."""
    import sympy

    if isinstance(condition, sympy.And):
        for part in condition.args:
            x = _chosen(part, x, y)
        return x
    if isinstance(condition, sympy.Or):
        for part in condition.args:
            y = _chosen(part, x, y)
        return y
    if isinstance(condition, sympy.Not):
        return _chosen(condition.args[0], y, x)
    if isinstance(condition, (sympy.StrictLessThan, sympy.LessThan, sympy.StrictGreaterThan, sympy.GreaterThan)):
        strict = isinstance(condition, (sympy.StrictLessThan, sympy.StrictGreaterThan))
        less, greater = (_expression("a side of a comparison", side) for side in (condition.lts, condition.gts))
        return where(_compared("<" if strict else "<=", less, greater), x, y)
    raise SetupError(f"`{condition}` has no counterpart in a declaration; a condition compares by <, <=, > or >=")


def to_sympy(of: Expression) -> Any:
    """The expression in sympy: coordinates are functions of `t`, parameters symbols."""
    import sympy

    if not isinstance(of, Expression):
        raise InputTypeError(f"of is {type(of).__name__}; expected an expression")
    t = sympy.Symbol("t")
    names = {own: name for name, own in _SYMPY.items()}
    done: dict[int, Any] = {}
    for node in _walk([of]):
        args = [done[id(arg)] for arg in node._args]
        op, value = node._op, node._value
        if op == "number":
            exact = sympy.Integer(int(value)) if float(value).is_integer() else sympy.Float(value, 17)
            done[id(node)] = exact
        elif op == "coordinate":
            done[id(node)] = sympy.Function(value[0])(t)
        elif op == "parameter":
            done[id(node)] = sympy.Symbol(value[0])
        elif op == "time":
            done[id(node)] = t
        elif op in _ARITHMETIC:
            done[id(node)] = _ARITHMETIC[op](*args)
        elif op == "powi":
            done[id(node)] = args[0] ** value
        elif op in ("dot", "ddot", "dddot"):
            done[id(node)] = sympy.diff(args[0], t, ("dot", "ddot", "dddot").index(op) + 1)
        elif op == "call":
            own = {"sqrt": sympy.sqrt, "cbrt": sympy.cbrt, "exp_m1": lambda x: sympy.exp(x) - 1, "ln_1p": lambda x: sympy.log(1 + x)}
            done[id(node)] = (own.get(value) or getattr(sympy, names[value]))(*args)
        else:
            done[id(node)] = sympy.Piecewise((args[1], args[0]), (args[2], True))
    return done[id(of)]


_ARITHMETIC: dict[str, Callable[..., Any]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "neg": lambda a: -a,
    "powf": lambda a, b: a**b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
}
