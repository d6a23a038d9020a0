"""Formulas as MathML, which browsers typeset themselves."""

from __future__ import annotations

import re
from html import escape

from ._formulas import Node, Statement
from ._latex import of_mathml

_GREEK = dict(
    alpha="α", beta="β", gamma="γ", delta="δ", epsilon="ε", zeta="ζ", eta="η", theta="θ", iota="ι", kappa="κ", mu="μ", nu="ν", xi="ξ", pi="π", rho="ρ",
    sigma="σ", tau="τ", phi="φ", chi="χ", psi="ψ", omega="ω", Omega="Ω", Delta="Δ", Theta="Θ", Phi="Φ", Psi="Ψ", Gamma="Γ", Sigma="Σ", PI="π", TAU="2π",
)  # fmt: skip
_GREEK["lambda"] = "λ"
_FUNCTIONS = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "signum": "sgn", "ln": "ln", "max": "max", "min": "min"}
#: Functions that are written without brackets before a symbol.
_BARE = ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "ln", "signum")
#: Products of vectors.
_VECTORS = {"inner": "·", "cross": "×"}
_DOTS = {"dot": "˙", "ddot": "¨", "dddot": "⃛"}
_RELATIONS = {"<=": "≤", ">=": "≥", "==": "=", "!=": "≠", "&&": "∧", "||": "∨", "%": "mod"}

#: The precedence of a formula: a sum, a product, a sign before it, a power, a symbol.
_RELATION, _SUM, _PRODUCT, _POWER, _ATOM = range(5)


def _mi(text: str) -> str:
    return f"<mi>{escape(text)}</mi>"


def _mo(text: str, space: bool = False) -> str:
    return f"<mo>{escape(text)}</mo>" if space else f'<mo lspace="0" rspace="0">{escape(text)}</mo>'


def _row(*parts: str) -> str:
    return f"<mrow>{''.join(parts)}</mrow>"


def name(of: str, over: str = "") -> str:
    """A name: Greek letters; the part behind the first `_`, or a number behind a letter, is an index."""
    stem, _, index = of.partition("_")
    if not index and (match := re.fullmatch(r"([^\W\d_]+?)(\d+)", of)):
        stem, index = match.groups()
    symbol = _mi(_GREEK.get(stem, stem))
    if over:
        symbol = f'<mover accent="true">{symbol}{_mo(over)}</mover>'
    if not index:
        return symbol
    parts = [part for part in index.split("_") if part]
    under = [f"<mn>{part}</mn>" if part.isdecimal() else _mi(_GREEK.get(part, part)) for part in parts]
    return f"<msub>{symbol}{_row(_mo(',').join(under))}</msub>"


def _number(text: str) -> str:
    text = text.replace("_f64", "").replace("f64", "").replace("_", "")
    mantissa, _, exponent = text.lower().partition("e")
    mantissa = mantissa.removesuffix(".0")
    if not exponent:
        return f"<mn>{mantissa}</mn>"
    return _row(f"<mn>{mantissa}</mn>", _mo("·"), f"<msup><mn>10</mn><mn>{int(exponent)}</mn></msup>")


def _in_brackets(inner: str, left: str = "(", right: str = ")") -> str:
    return _row(f'<mo fence="true" lspace="0" rspace="0">{left}</mo>', inner, f'<mo fence="true" lspace="0" rspace="0">{right}</mo>')


def _list(nodes: tuple[Node, ...]) -> str:
    return _row((_mo(",") + '<mspace width="0.3em"/>').join(formula(node)[0] for node in nodes))


def _held(node: Node, least: int) -> str:
    """A formula, in brackets if its precedence is lower than `least`."""
    text, holds = formula(node)
    return text if holds >= least else _in_brackets(text)


def formula(node: Node) -> tuple[str, int]:
    """A formula, and its precedence."""
    kind, value, parts = node
    if kind == "name":
        return name(value), _ATOM
    if kind == "number":
        return _number(value), _ATOM if "e" not in value.lower() else _PRODUCT
    if kind == "minus":
        return _row(_mo("−"), _held(parts[0], _PRODUCT)), _SUM
    if kind == "not":
        return _row(_mo("¬"), _held(parts[0], _ATOM)), _ATOM
    if kind == "index":
        base, *places = parts
        return f"<msub>{_held(base, _ATOM)}{_list(tuple(places))}</msub>", _ATOM
    if kind in ("tuple", "list"):
        return _in_brackets(_list(parts)), _ATOM
    if kind == "if":
        return _cases(node), _ATOM
    if kind == "function":
        return _row(*(name(one) for one in value.split(",")), _mo("↦"), formula(parts[0])[0]), _RELATION
    if kind == "operator":
        return _operator(value, *parts)
    return _call(value, parts)


def _operator(operator: str, left: Node, right: Node) -> tuple[str, int]:
    if operator == "/":
        return f"<mfrac>{_row(formula(left)[0])}{_row(formula(right)[0])}</mfrac>", _PRODUCT
    if operator == "*" and left.kind == "minus":
        # a sign is taken out of a product
        return formula(Node("minus", "", (Node("operator", "*", (left.parts[0], right)),)))
    if operator == "*":
        factor = _held(right, _PRODUCT)
        # two numbers side by side would be read as one
        between = _mo("·") if _first(right) == "number" else '<mspace width="0.2em"/>'
        return _row(_held(left, _PRODUCT), between, factor), _PRODUCT
    if operator in ("+", "-"):
        sign = f"<mo>{'+' if operator == '+' else '−'}</mo>"
        return _row(_held(left, _SUM), sign, _held(right, _SUM if operator == "+" and right.kind != "minus" else _PRODUCT)), _SUM
    return _row(_held(left, _SUM), f"<mo>{escape(_RELATIONS.get(operator, operator))}</mo>", _held(right, _SUM)), _RELATION


def _first(node: Node) -> str:
    """The kind of the node that a formula begins with."""
    while node.kind == "operator" and node.value == "*" or node.kind == "call" and node.value in ("powi", "powf"):
        node = node.parts[0]
    return node.kind


def _call(of: str, parts: tuple[Node, ...]) -> tuple[str, int]:
    if of in _DOTS and len(parts) == 1:
        return _rate(of, parts[0])
    if of in ("powi", "powf", "powd") and len(parts) == 2:
        return f"<msup>{_held(parts[0], _ATOM)}{_row(formula(parts[1])[0])}</msup>", _POWER
    if of == "sum" and len(parts) == 2 and parts[1].kind == "function" and parts[0].kind == "operator":
        return _sum(parts[0], parts[1]), _PRODUCT
    if of in _VECTORS and len(parts) == 2:
        # each factor has its own brackets: a product of three vectors keeps them
        return _row(_held(parts[0], _ATOM), _mo(_VECTORS[of]), _held(parts[1], _ATOM)), _SUM if of == "cross" else _PRODUCT
    if of == "angular_velocity" and len(parts) == 1 and parts[0].kind == "name":
        return _turning(parts[0].value), _ATOM
    if len(parts) == 1:
        inner = formula(parts[0])[0]
        if of == "norm":
            return _in_brackets(inner, "|", "|"), _ATOM
        if of == "norm_squared":
            return f"<msup>{_in_brackets(inner, '|', '|')}<mn>2</mn></msup>", _POWER
        if of == "inverse":
            return f"<msup>{_held(parts[0], _ATOM)}{_row(_mo('−'), '<mn>1</mn>')}</msup>", _POWER
        if of == "sqrt":
            return f"<msqrt>{inner}</msqrt>", _ATOM
        if of == "cbrt":
            return f"<mroot>{_row(inner)}<mn>3</mn></mroot>", _ATOM
        if of == "abs":
            return _in_brackets(inner, "|", "|"), _ATOM
        if of == "exp":
            return f"<msup>{_mi('e')}{_row(inner)}</msup>", _POWER
        if of == "recip":
            return f"<mfrac><mn>1</mn>{_row(inner)}</mfrac>", _PRODUCT
        if of in _BARE and parts[0].kind in ("name", "index"):
            # sin θ
            return _row(_function(of), '<mspace width="0.2em"/>', inner), _PRODUCT
    return _row(_function(of), _in_brackets(_list(parts))), _ATOM


def _function(of: str) -> str:
    known = _FUNCTIONS.get(of, of)
    return f'<mi mathvariant="normal">{escape(known)}</mi>' if of in _FUNCTIONS or len(of) > 1 and of not in _GREEK and "_" not in of else name(of)


def _is_symbol(of: str) -> bool:
    """Whether a name is a letter, with or without an index: a dot over a word would be a dot over one of its letters."""
    stem = re.sub(r"\d+$", "", of.partition("_")[0])
    return len(_GREEK.get(stem, stem)) == 1


def _rate(of: str, node: Node) -> tuple[str, int]:
    if node.kind == "name" and _is_symbol(node.value):
        return name(node.value, _DOTS[of]), _ATOM
    if node.kind == "index" and node.parts[0].kind == "name" and _is_symbol(node.parts[0].value):
        return f"<msub>{name(node.parts[0].value, _DOTS[of])}{_list(tuple(node.parts[1:]))}</msub>", _ATOM
    order = list(_DOTS).index(of) + 1
    power = [f"<msup>{_mi('d')}<mn>{order}</mn></msup>", f"<msup>{_mi('t')}<mn>{order}</mn></msup>"] if order > 1 else [_mi("d"), _mi("t")]
    space = '<mspace width="0.2em"/>'
    return _row(f"<mfrac>{power[0]}{_row(_mi('d'), power[1])}</mfrac>", space, _held(node, _ATOM)), _PRODUCT


def _sum(span: Node, function: Node) -> str:
    index, end = function.value, span.parts[1]
    if span.value == "..":
        # the upper end of the range is exclusive
        last = Node("number", str(int(end.value) - 1), ()) if end.kind == "number" and end.value.isdecimal() else None
        upper = formula(last)[0] if last else _row(_held(end, _SUM), "<mo>−</mo><mn>1</mn>")
    else:
        upper = formula(end)[0]
    under = _row(name(index), "<mo>=</mo>", formula(span.parts[0])[0])
    sign = f'<munderover><mo movablelimits="false">∑</mo>{under}{_row(upper)}</munderover>'
    return _row(sign, _held(function.parts[0], _PRODUCT))


def _cases(node: Node) -> str:
    rows = []
    while node.kind == "if":
        condition, one, other = node.parts
        rows.append((formula(one)[0], f"<mtext>if&#160;</mtext>{formula(condition)[0]}"))
        node = other
    rows.append((formula(node)[0], "<mtext>otherwise</mtext>"))
    lines = "".join(f"<mtr><mtd>{one}</mtd><mtd>{_row(when)}</mtd></mtr>" for one, when in rows)
    return _row('<mo fence="true">{</mo>', f'<mtable columnalign="left left">{lines}</mtable>')


def shown(inner: str) -> str:
    """A formula on a line of its own, which scrolls where it is too long.

    It is written in LaTeX, which every notebook sets, and beside it in MathML, which `SCRIPT` puts in its place: a browser sets it without anything from outside. Where a
    notebook is not trusted, scripts are left out with what is in them, and LaTeX stays.
    """
    math = f'<math displaystyle="true" style="font-size:115%">{_row(inner)}</math>'
    style = "overflow-x:auto;overflow-y:hidden;padding:.2em 0 .5em 1.5em"
    return f'<div class="dsocs-formula" style="{style}">$${escape(of_mathml(math))}$$</div><script type="application/mathml+xml">{math}</script>'


#: Replaces LaTeX by MathML where the page allows scripts.
SCRIPT = (
    "<script>document.querySelectorAll('script[type=\"application/mathml+xml\"]').forEach(function (math) {"
    " var place = math.previousElementSibling;"
    " if (place && place.className === 'dsocs-formula') { place.innerHTML = math.textContent; } });</script>"
)


def word(of: str) -> str:
    """A name as a page writes it in a table."""
    stem, _, index = of.partition("_")
    if not index and (match := re.fullmatch(r"([^\W\d_]+?)(\d+)", of)):
        stem, index = match.groups()
    parts = [_GREEK.get(part, part) for part in index.split("_") if part]
    return f"<i>{escape(_GREEK.get(stem, stem))}</i>" + (f"<sub>{escape(','.join(parts))}</sub>" if parts else "")


def equation(left: str, right: str) -> str:
    """An equation on a line."""
    return shown(_row(left, "<mo>=</mo>", right))


def definition(statement: Statement) -> str:
    """The definition that a `let` makes."""
    node = statement.of
    assert node is not None
    if node.kind == "function":
        arguments = [name(one) for one in node.value.split(",")]
        left = _row(_function(statement.name), _in_brackets(_row(_mo(",").join(arguments))))
        return equation(left, formula(node.parts[0])[0])
    return equation(name(statement.name), formula(node)[0])


def rows(node: Node) -> tuple[Node, ...]:
    """The rows of a constraint: one, or the elements of a list."""
    return node.parts if node.kind == "list" else (node,)


def _turning(rotation: str) -> str:
    """The angular velocity of a rotation."""
    return f"<msub>{_mi('ω')}{name(rotation)}</msub>"


def turning(rotation: str, has_forces: bool, is_constrained: bool, has_attitude: bool) -> str:
    """The Euler–Poincaré equation for a rotation: three components in the frame of its body."""
    velocity = _turning(rotation)
    momentum = f"<mfrac>{_row(_mi('∂'), _mi('L'))}{_row(_mi('∂'), velocity)}</mfrac>"
    derivative = f"<mfrac>{_mi('d')}{_row(_mi('d'), _mi('t'))}</mfrac>"
    torques = [f"<msub>{_mi(letter)}{name(rotation)}</msub>" for letter, has in (("F", has_forces), ("f", is_constrained)) if has]
    if has_attitude:
        torques.insert(0, f"<mfrac>{_row(_mi('∂'), _mi('L'))}{_row(_mi('∂'), name(rotation))}</mfrac>")
    return equation(_row(derivative, momentum, "<mo>+</mo>", velocity, _mo("×"), momentum), _row("<mo>+</mo>".join(torques)) if torques else "<mn>0</mn>")


def motion(coordinate: str, has_forces: bool, is_constrained: bool) -> str:
    """Lagrange's equation for a coordinate."""

    def by(symbol: str) -> str:
        return f"<mfrac>{_row(_mi('∂'), _mi('L'))}{_row(_mi('∂'), symbol)}</mfrac>"

    derivative = f"<mfrac>{_mi('d')}{_row(_mi('d'), _mi('t'))}</mfrac>"
    plain, dotted = name(coordinate), _rate("dot", Node("name", coordinate, ()))[0]
    forces = [f"<msub>{_mi(letter)}{plain}</msub>" for letter, has in (("F", has_forces), ("f", is_constrained)) if has]
    return equation(_row(derivative, by(dotted), "<mo>−</mo>", by(plain)), _row("<mo>+</mo>".join(forces)) if forces else "<mn>0</mn>")
