"""What a notebook shows of a run and of a system."""

from __future__ import annotations

import re
from html import escape
from typing import TYPE_CHECKING

from . import _formulas, _mathml

if TYPE_CHECKING:
    from ._run import Run
    from ._system import System


def run(run: Run) -> str:
    """The page of a run, in a frame of its own: it asks for nothing from outside."""
    if len(run) < 2:
        return f"<p>{escape(repr(run))}</p>"
    page = escape(run.page(), quote=True)
    # a notebook that is not trusted shows no frame, and its page takes away styles, too: then the line is seen
    hint = f"{repr(run)}: the page of this run is shown when the notebook is trusted."
    return (
        f'<style>.dsocs-untrusted {{ display: none }}</style><p class="dsocs-untrusted">{escape(hint)}</p>'
        f'<iframe srcdoc="{page}" title="{escape(repr(run), quote=True)}" sandbox="allow-scripts" '
        'style="width:100%;box-sizing:border-box;height:640px;border:1px solid #8888;border-radius:4px" loading="lazy"></iframe>'
    )


#: The statements that are set, in their order, and what they are called.
_CONSTRAINTS = {
    "holonomic": "constraints on positions",
    "nonholonomic": "constraints on velocities",
    "kinematic": "constraints on accelerations",
}


def system(system: System) -> str:
    """What is known of a system: its Lagrangian, constraints and equations as formulas, its quantities in a table, and its text."""
    parts = [f"<h4>{escape(system.name)} <small>({escape(system.kind)})</small></h4>"]
    if system.doc:
        parts.append(f"<p>{_told(system.doc)}</p>")
    parts += _mathematics(system)
    values = system.parameters
    groups = (("coordinates", system.coordinates), ("parameters", system._parameters), ("observed", system.observables))
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
                f"<td>{escape(of.unit or '')}</td><td style='text-align:left'>{_told(of.meaning)}</td></tr>"
            )
        tables.append(f"<table>{head}{''.join(rows)}</table>")
    parts.append(f"<div style='overflow-x:auto'>{''.join(tables)}</div>")
    parts.append(f"<details><summary>text</summary><pre style='overflow-x:auto'>{escape(system.text)}</pre></details>")
    parts.append(_mathml.SCRIPT)
    return "".join(parts)


def _told(text: str) -> str:
    """What a declaration says of something, with its code as code."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(text))


def _mathematics(system: System) -> list[str]:
    """The statements of a system as formulas; those that are not understood as text."""
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
        parts += [_mathml.motion(name, has_forces, is_constrained) for name in _coordinates(system)]
    if where:
        first += ["<p>with</p>", *where]
    return [*first, *parts, *(f"<p><code>{escape(text)}</code></p>" for text in rest)]


def _coordinates(system: System) -> list[str]:
    """The coordinates, if there are so few that each may have an equation; otherwise the letter q."""
    names = system._names
    return names if len(names) <= 4 else ["q"]
