"""What a notebook shows of a run and of a system."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._run import Run
    from ._system import System


def run(run: Run) -> str:
    """The page of a run, in a frame of its own: it asks for nothing from outside."""
    if len(run) < 2:
        return f"<p>{escape(repr(run))}</p>"
    page = escape(run.report(), quote=True)
    return (
        f'<iframe srcdoc="{page}" title="{escape(repr(run), quote=True)}" sandbox="allow-scripts" '
        'style="width:100%;height:640px;border:1px solid #8888;border-radius:4px" loading="lazy"></iframe>'
    )


def system(system: System) -> str:
    """What is known of a system: its quantities in a table, and its declaration."""
    parts = [f"<h4>{escape(system.name)} <small>({escape(system.kind)})</small></h4>"]
    if system.doc:
        parts.append(f"<p>{escape(system.doc)}</p>")
    values = system.parameters
    groups = (("coordinates", system.coordinates), ("parameters", system._parameters), ("observed", system.observables))
    for heading, quantities in groups:
        if not quantities:
            continue
        has_values = heading == "parameters"
        head = f"<tr><th style='text-align:left'>{heading}</th>{'<th>value</th>' if has_values else ''}<th>unit</th><th></th></tr>"
        rows = []
        for of in quantities:
            value = f"<td>{values[of.name]:g}</td>" if has_values else ""
            rows.append(
                f"<tr><td style='text-align:left'><code>{escape(of.name)}</code></td>{value}<td>{escape(of.unit or '')}</td>"
                f"<td style='text-align:left'>{escape(of.meaning)}</td></tr>"
            )
        parts.append(f"<table>{head}{''.join(rows)}</table>")
    parts.append(f"<details><summary>declaration</summary><pre>{escape(system._declaration)}</pre></details>")
    return "".join(parts)
