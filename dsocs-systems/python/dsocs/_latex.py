"""Formulas as LaTeX, from their MathML: shown where a notebook is not trusted, whose page removes MathML."""

from __future__ import annotations

import xml.etree.ElementTree as tree

_SYMBOLS = {
    "α": "alpha", "β": "beta", "γ": "gamma", "δ": "delta", "ε": "varepsilon", "ζ": "zeta", "η": "eta", "θ": "theta", "ι": "iota", "κ": "kappa", "μ": "mu", "ν": "nu",
    "ξ": "xi", "π": "pi", "ρ": "rho", "σ": "sigma", "τ": "tau", "φ": "varphi", "χ": "chi", "ψ": "psi", "ω": "omega", "λ": "lambda", "Ω": "Omega", "Δ": "Delta",
    "Θ": "Theta", "Φ": "Phi", "Ψ": "Psi", "Γ": "Gamma", "Σ": "Sigma", "∂": "partial", "∑": "sum", "·": "cdot", "×": "times", "≤": "le", "≥": "ge", "≠": "ne", "∧": "wedge",
    "∨": "vee", "¬": "neg", "↦": "mapsto", "<": "lt", ">": "gt", "&": "&", "%": "%", "#": "#", "{": "{", "}": "}", "$": "$", "_": "_",
}  # fmt: skip
_ACCENTS = {"˙": "dot", "¨": "ddot", "⃛": "dddot"}


def of_mathml(math: str) -> str:
    """The LaTeX of a formula in the MathML that `_mathml` makes."""
    return _of(tree.fromstring(math)).strip()


def _of(element: tree.Element) -> str:
    kind, parts = element.tag, [_of(part) for part in element]
    text = element.text or ""
    if kind == "mspace":
        return r"\,"
    if kind == "mtext":
        return rf"\text{{{text}}}".replace("\N{NO-BREAK SPACE}", " ")
    if kind == "mi":
        return _word(text, element.get("mathvariant") == "normal")
    if kind in ("mo", "mn"):
        return _text(text)
    if kind == "mfrac":
        return rf"\frac{{{parts[0]}}}{{{parts[1]}}}"
    if kind == "msqrt":
        return rf"\sqrt{{{''.join(parts)}}}"
    if kind == "mroot":
        return rf"\sqrt[{parts[1]}]{{{parts[0]}}}"
    if kind == "msub":
        return f"{{{parts[0]}}}_{{{parts[1]}}}"
    if kind == "msup":
        return f"{{{parts[0]}}}^{{{parts[1]}}}"
    if kind == "mover":
        return rf"\{_ACCENTS.get(element[1].text or '', 'bar')}{{{parts[0]}}}"
    if kind == "munderover":
        return f"{parts[0]}_{{{parts[1]}}}^{{{parts[2]}}}"
    if kind == "mtr":
        return " & ".join(parts)
    if kind == "mtable":
        lines = r" \\ ".join(parts)
        return rf"\begin{{cases}}{lines}\end{{cases}}"
    # the brace before cases belongs to them
    return "".join(parts).replace(r"\{\begin{cases}", r"\begin{cases}")


def _word(text: str, upright: bool) -> str:
    if len(text) > 1:
        return rf"\mathrm{{{_text(text)}}}" if upright else rf"\mathit{{{_text(text)}}}"
    return _text(text)


def _text(text: str) -> str:
    said = "".join((rf"\{_SYMBOLS[one]} " if _SYMBOLS[one].isalpha() else rf"\{_SYMBOLS[one]}") if one in _SYMBOLS else one for one in text)
    return said.replace("−", "-")
