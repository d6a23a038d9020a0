"""The listings of the book's chapter on Python, and of the package's own page, run."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from conftest import SWING

PACKAGE = Path(__file__).resolve().parents[1]


def quadrotor() -> str:
    """The text file in the chapter on rotations that its Python listing reads."""
    chapter = (PACKAGE.parent / "src" / "guide" / "rotations.md").read_text(encoding="utf-8")
    texts = re.findall(r"```text\n(.*?)```", chapter, re.DOTALL)
    return next(text for text in texts if text.startswith("//! A quadrotor"))


@pytest.mark.parametrize("page", [PACKAGE.parent / "src" / "guide" / "python.md", PACKAGE.parent / "src" / "guide" / "rotations.md", PACKAGE / "README.md", PACKAGE.parents[1] / "README.md"], ids=["book", "rotations", "package", "project"])
def test_listings_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    listings = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    assert listings
    (tmp_path / "swing.dsocs").write_text(SWING, encoding="utf-8")
    (tmp_path / "quadrotor.dsocs").write_text(quadrotor(), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for listing in listings:
        exec(compile(listing, str(page), "exec"), names)
