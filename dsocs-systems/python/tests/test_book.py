"""The listings of the book's chapter on Python, and of the package's own page, run."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from conftest import SWING

PACKAGE = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize("page", [PACKAGE.parent / "src" / "guide" / "python.md", PACKAGE / "README.md", PACKAGE.parents[1] / "README.md"], ids=["book", "package", "project"])
def test_listings_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    listings = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    assert listings
    (tmp_path / "swing.dsocs").write_text(SWING, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for listing in listings:
        exec(compile(listing, str(page), "exec"), names)
