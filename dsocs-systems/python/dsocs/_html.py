"""The HTML of a run and of a system in a notebook."""

from __future__ import annotations

import re
from html import escape
from typing import TYPE_CHECKING, Any

from . import _formulas, _mathml
from ._declared import Quantity

if TYPE_CHECKING:
    from ._run import Run
    from ._system import System


def run(run: Run) -> str:
    """The page of a run, in a frame; it loads nothing from outside."""
    if len(run) < 2:
        return f"<p>{escape(repr(run))}</p>"
    page = escape(run.page(), quote=True)
    # a notebook that is not trusted shows no frame, and its page removes styles, too: then the line becomes
    # visible
    hint = f"{repr(run)}: the page of this run is shown when the notebook is trusted."
    return (
        f'<style>.dsocs-untrusted {{ display: none }}</style><p class="dsocs-untrusted">{escape(hint)}</p>'
        f'<iframe srcdoc="{page}" title="{escape(repr(run), quote=True)}" sandbox="allow-scripts" '
        'style="width:100%;box-sizing:border-box;height:640px;border:1px solid #8888;border-radius:4px" loading="lazy"></iframe>'
    )


#: The constraint statements, in the order in which they are shown, with their headings.
_CONSTRAINTS = {
    "holonomic": "constraints on positions",
    "nonholonomic": "constraints on velocities",
    "kinematic": "constraints on accelerations",
}


def system(system: System) -> str:
    """A system: its Lagrangian, constraints and equations as formulas, its quantities in a table, and its text."""
    parts = [f"<h4>{escape(system.name)} <small>({escape(system.kind)})</small></h4>"]
    if system.doc:
        parts.append(f"<p>{_documentation(system.doc)}</p>")
    parts += _mathematics(system)
    values = system.parameters
    groups = (("coordinates", _places(system)), ("parameters", system._parameters), ("observed", system.observables))
    tables = []
    for heading, quantities in groups:
        if not quantities:
            continue
        has_values = heading == "parameters"
        head = f"<tr><th style='text-align:left'>{heading}</th>{'<th>value</th>' if has_values else ''}<th>unit</th><th></th></tr>"
        rows = []
        for of in quantities:
            value = f"<td>{values[of.name]:g}</td>" if has_values else ""
            rows.append(
                f"<tr><td style='text-align:left'>{_mathml.word(of.name)} <code>{escape(of.name)}</code></td>{value}"
                f"<td>{escape(of.unit or '')}</td><td style='text-align:left'>{_documentation(of.meaning)}</td></tr>"
            )
        tables.append(f"<table>{head}{''.join(rows)}</table>")
    parts.append(f"<div style='overflow-x:auto'>{''.join(tables)}</div>")
    parts.append(f"<details><summary>text</summary><pre style='overflow-x:auto'>{escape(system.text)}</pre></details>")
    parts.append(_mathml.SCRIPT)
    return "".join(parts)


def _documentation(text: str) -> str:
    """Documentation of a declaration as HTML, with parts in backticks as code."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(text))


def _mathematics(system: System) -> list[str]:
    """The statements of a system as formulas, or as text where they cannot be parsed."""
    found = _formulas.statements(system.text)
    words = {statement.word for statement in found}
    has_forces, is_constrained = "external_forces" in words, any(system.constraints)
    first, where, parts, rest = [], [], [], []
    for statement in found:
        node = statement.of
        if statement.word in ("observe", "symmetries"):
            continue
        if node is None:
            rest.append(statement.text)
        elif statement.word == "lagrangian":
            first.append(_mathml.equation("<mi>L</mi>", _mathml.formula(node)[0]))
        elif statement.word in _CONSTRAINTS:
            parts.append(f"<p>{_CONSTRAINTS[statement.word]}</p>")
            parts += [_mathml.equation(_mathml.formula(row)[0], "<mn>0</mn>") for row in _mathml.rows(node)]
        elif statement.word in ("variational", "constraint_forces"):
            what = "virtual displacements are spanned by" if statement.word == "variational" else "constraint forces f are spanned by"
            parts.append(f"<p>{what}</p>")
            parts += [_mathml.shown(_mathml.formula(row)[0]) for row in _mathml.rows(node)]
        elif statement.word == "external_forces":
            parts.append("<p>external forces</p>")
            parts.append(_mathml.equation("<mi>F</mi>", _mathml.formula(node)[0]))
        elif statement.word == "branch" and node.kind == "call" and node.value == "divide":
            parts.append("<p>a factor is divided out of a constraint</p>")
            parts.append(_mathml.shown(_mathml.formula(node.parts[0])[0]))
        elif statement.word == "let":
            where.append(_mathml.definition(statement))
        else:
            rest.append(statement.text)
    if "lagrangian" in words:
        parts.append("<p>equations of motion</p>")
        turning, others = _coordinates(system)
        has_attitude = _names_attitude(found, turning)
        parts += [_mathml.turning(name, has_forces, is_constrained, name in has_attitude) for name in turning]
        if turning:
            attitude = ", and the derivative by the attitude is that by turns about its axes" if has_attitude else ""
            parts.append(f"<p>of a rotation in the frame of its body: ω is its angular velocity{attitude}</p>")
        parts += [_mathml.motion(name, has_forces, is_constrained) for name in others]
    if where:
        first += ["<p>with</p>", *where]
    return [*first, *parts, *(f"<p><code>{escape(text)}</code></p>" for text in rest)]


def _places(system: System) -> list[Quantity]:
    """The coordinates as declared: a rotation is one, although its quaternion has four numbers."""
    turning = {first + place for first in system._rotations for place in (1, 2, 3)}
    quantities = []
    for place, of in enumerate(system.coordinates):
        if place in system._rotations:
            quantities.append(of._replace(name=of.name.removesuffix("_w")))
        elif place not in turning:
            quantities.append(of)
    return quantities


def _coordinates(system: System) -> tuple[list[str], list[str]]:
    """The names of the rotations, and of the other coordinates if they are few enough for an equation each; otherwise the letter q."""
    turning = [system._names[first].removesuffix("_w") for first in system._rotations]
    others = [of.name for of in _places(system) if of.name not in turning]
    return turning, others if len(others) <= 4 else ["q"]


def _names_attitude(statements: list[_formulas.Statement], turning: list[str]) -> set[str]:
    """The rotations whose attitude the Lagrangian contains, not only their angular velocity; all of them where this is not known."""
    lets = {statement.name: statement.of for statement in statements if statement.word == "let"}

    def attitudes(node: Any, among: frozenset[str]) -> set[str]:
        if not isinstance(node, _formulas.Node):
            return set(turning)
        if node.kind == "call" and node.value == "angular_velocity":
            return set()
        if node.kind == "name":
            if node.value in turning:
                return {node.value}
            return attitudes(lets[node.value], among | {node.value}) if node.value in lets and node.value not in among else set()
        if node.kind == "call" and node.value in lets and node.value not in among:
            return attitudes(lets[node.value], among | {node.value}).union(*(attitudes(part, among) for part in node.parts))
        return set().union(*(attitudes(part, among) for part in node.parts))

    lagrangian = next((statement.of for statement in statements if statement.word == "lagrangian"), None)
    return attitudes(lagrangian, frozenset())
