"""The Python listings of the book, of the package's own page and of the project's, run."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from conftest import SWING

PACKAGE = Path(__file__).resolve().parents[1]
GUIDE = PACKAGE.parent / "src" / "guide"

#: Chapters with Python listings, by their names. Those of `many_runs` read the tables of a sweep, which this package does not make.
CHAPTERS = ["constraints", "control", "methods", "python", "rotations", "time_forces_inputs", "two_roots"]
PAGES = {**{name: GUIDE / f"{name}.md" for name in CHAPTERS}, "package": PACKAGE / "README.md", "project": PACKAGE.parents[1] / "README.md"}


def text_files(page: str) -> dict[str, str]:
    """The text files of a page, by the names that the sentences before them give."""
    return dict(re.findall(r"`(\w+\.dsocs)`[^`]*:\n\n```text\n(.*?)```", page, re.DOTALL))


@pytest.mark.parametrize("page", PAGES.values(), ids=PAGES.keys())
def test_listings_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = page.read_text(encoding="utf-8")
    listings = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert listings
    for name, file in {"swing.dsocs": SWING, **text_files(text)}.items():
        (tmp_path / name).write_text(file, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for listing in listings:
        exec(compile(listing, str(page), "exec"), names)
