"""The notebooks of the gallery, executed: each as a script, and as a notebook where jupytext and nbclient are installed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

GALLERY = Path(__file__).resolve().parents[1] / "gallery"
NOTEBOOKS = sorted(GALLERY.glob("*.py"))
#: The number of starts in the last notebook, which is a million outside of tests.
STARTS = "10000"


def environment(folder: Path) -> dict[str, str]:
    return {**os.environ, "MPLBACKEND": "Agg", "MPLCONFIGDIR": str(folder), "STARTS": STARTS}


def test_every_notebook_is_listed() -> None:
    page = (GALLERY / "README.md").read_text(encoding="utf-8")
    assert len(NOTEBOOKS) == 6
    for notebook in NOTEBOOKS:
        assert f"| `{notebook.name}` |" in page


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=[path.stem for path in NOTEBOOKS])
def test_a_notebook_runs_as_a_script(notebook: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    pytest.importorskip("scipy")
    done = subprocess.run([sys.executable, str(notebook)], cwd=tmp_path, env=environment(tmp_path), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not any(tmp_path.glob("*.py"))


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=[path.stem for path in NOTEBOOKS])
def test_a_notebook_runs_in_a_kernel(notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib")
    pytest.importorskip("scipy")
    pytest.importorskip("ipykernel")
    jupytext, nbclient = pytest.importorskip("jupytext"), pytest.importorskip("nbclient")
    for name, value in environment(tmp_path).items():
        monkeypatch.setenv(name, value)
    monkeypatch.delenv("MPLBACKEND")
    # the kernel that is installed beside this Python
    monkeypatch.setenv("JUPYTER_PATH", str(Path(sys.prefix) / "share" / "jupyter"))
    document = jupytext.read(notebook)
    assert [cell.cell_type for cell in document.cells][:1] == ["markdown"]
    nbclient.NotebookClient(document, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    # figures are shown
    shown = [output for cell in document.cells if cell.cell_type == "code" for output in cell.outputs]
    assert any("image/png" in output.get("data", {}) for output in shown)
