"""Formulas and pages in a notebook, inspected in a browser from an executed notebook where the tools are installed."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree
from pathlib import Path

import pytest
from conftest import BEADS, CURVED, FRICTION, ROD, SWING, text_of_library

import dsocs
from dsocs import _formulas

#: The script that inspects a page.
PROBE = """<script>
window.addEventListener("load", () => setTimeout(() => {
  const formulas = [...document.querySelectorAll("math")].map((math) => math.getBoundingClientRect());
  const frames = [...document.querySelectorAll("iframe")].map((frame) => frame.getBoundingClientRect());
  const found = {
    formulas: formulas.length,
    flat: formulas.filter((box) => box.height < 5 || box.width < 3).length,
    stacked: [...document.querySelectorAll("mfrac")].filter((one) => one.getBoundingClientRect().height > 20).length,
    fractions: document.querySelectorAll("mfrac").length,
    latex: document.body.innerText.split("$$").length - 1,
    frames: frames.length,
    frame_width: Math.max(0, ...frames.map((box) => box.width)),
    page_width: document.documentElement.clientWidth,
    scroll_width: document.documentElement.scrollWidth,
  };
  document.title = JSON.stringify(found);
}, 1500));
</script>"""


def math_of(system: dsocs.System) -> list[str]:
    return re.findall(r"<math.*?</math>", system._repr_html_(), re.DOTALL)


def words(math: str) -> str:
    """The symbols of a formula, one after the other."""
    return "".join(xml.etree.ElementTree.fromstring(math).itertext())


def test_a_lagrangian_is_set() -> None:
    shown = [words(math) for math in math_of(dsocs.System(SWING, name="swing"))]
    assert shown[0] == "L=(lengthθ˙)22+gravitylengthcosθ"
    assert "F=torque−frictionlength2θ˙" in shown
    assert "ddt∂L∂θ˙−∂L∂θ=Fθ" in shown
    assert "height=length(1−cosθ)" in shown


@pytest.mark.parametrize("text", [SWING, ROD, CURVED, BEADS, FRICTION], ids=["swing", "rod", "curved", "beads", "friction"])
def test_formulas_are_well_formed_and_nothing_is_left_as_text(text: str) -> None:
    system = dsocs.System(text)
    shown = math_of(system)
    assert shown
    for math in shown:
        xml.etree.ElementTree.fromstring(math)
    assert all(statement.of is not None for statement in _formulas.statements(text))


LIBRARY = ["pendulum", "chain", "arm", "rolling-disk", "quaternion-top", "crane", "clothoid", "snakeboard", "vehicle", "rod-and-wheel", "contact-oscillator", "kapitza"]


@pytest.mark.parametrize("name", LIBRARY)
def test_systems_of_the_library_are_set(program: Path, tmp_path: Path, name: str) -> None:
    system = dsocs.read(text_of_library(program, tmp_path, name))
    for math in math_of(system):
        xml.etree.ElementTree.fromstring(math)
    left = [statement.word for statement in _formulas.statements(system.text) if statement.of is None]
    assert left == []


def test_cases_and_sums_are_set() -> None:
    system = dsocs.System(
        "parameters { k: [3] = [1.0; 3] } coordinates(x: [3]);"
        "lagrangian = sum(0..3, |i| dot(x[i]).powi(2) / 2 - k[i] * (if x[i] < 0 { 0 } else { x[i].powi(2) }));"
    )
    shown = words(math_of(system)[0])
    assert shown.startswith("L=∑i=02") and "otherwise" in shown and "if" in shown


def test_what_is_not_understood_is_left_as_text() -> None:
    found = _formulas.statements("lagrangian = x ? y; let a = 2 * x;")
    assert found[0].of is None and found[0].text == "lagrangian = x ? y;" and found[1].of is not None


def sanitized(html: str) -> str:
    """An output as the page of an untrusted notebook keeps it: without frames, scripts and styles; of unknown tags only their content."""
    html = re.sub(r"<(script|style)\b.*?</\1>", "", html, flags=re.DOTALL)
    return re.sub(r"</?(?!(?:p|div|h4|small|table|tr|th|td|i|b|sub|sup|code|pre|details|summary)\b)[a-z]+[^>]*>", "", html)


def test_formulas_and_pages_are_told_where_a_notebook_is_not_trusted() -> None:
    swing = dsocs.System(SWING, name="swing")
    left = sanitized(swing._repr_html_())
    formulas = re.findall(r"\$\$(.*?)\$\$", left)
    assert formulas[0] == r"L=\frac{{(\mathit{length}\,\dot{\theta })}^{2}}{2}+\mathit{gravity}\,\mathit{length}\,\mathrm{cos}\,\theta"
    assert len(formulas) == len(math_of(swing)) and "<math" not in left
    assert all(formula.count("{") == formula.count("}") for formula in formulas)
    run = swing.flow().until(1.0)
    assert "the page of this run is shown when the notebook is trusted" in sanitized(run._repr_html_())
    assert "iframe" not in sanitized(run._repr_html_())


def test_cases_are_written_in_latex() -> None:
    system = dsocs.System("coordinates(x); lagrangian = dot(x).powi(2) / 2 - (if x < 0 { 0 } else { x.powi(2) });")
    assert r"\begin{cases}0 &amp; \text{if }x\lt 0 \\ {x}^{2} &amp; \text{otherwise}\end{cases}" in system._repr_html_()


BODY = """
parameters { torque: [3] = [0.0; 3] }
coordinates(
    /// The attitude of the body [1]
    r: rotation
);
let w = r.angular_velocity();
lagrangian = w.inner(w) / 2 - (r * [0, 0, 1])[2];
external_forces = torque;
let moment = r * w.cross(torque);
observe = [moment];
"""


def test_a_rotation_has_the_equation_of_euler_and_poincare() -> None:
    page = dsocs.System(BODY)._repr_html_()
    formulas = re.findall(r"\$\$(.*?)\$\$", page)
    assert r"L=\frac{w\cdot w}{2}-{(r\,(0,\,0,\,1))}_{2}" in formulas
    assert r"w={\omega }_{r}" in formulas and r"moment" in page
    turning = r"\frac{d}{dt}\frac{\partial L}{\partial {\omega }_{r}}+{\omega }_{r}\times \frac{\partial L}{\partial {\omega }_{r}}=\frac{\partial L}{\partial r}+{F}_{r}"
    assert turning in formulas and r"r\,(w\times \mathit{torque})" in " ".join(formulas)
    assert not any("r_w" in formula or "{r}_{w}" in formula for formula in formulas)
    # if the Lagrangian does not contain the attitude, no torque acts on the body
    free = dsocs.System("coordinates(r: rotation, x); lagrangian = r.angular_velocity().norm_squared() / 2 + dot(x).powi(2) / 2;")._repr_html_()
    assert "{\\omega }_{r}\\times \\frac{\\partial L}{\\partial {\\omega }_{r}}=0" in free
    assert page.count("<code>r</code>") == 1 and "<code>r_x</code>" not in page


NOTEBOOK = [
    ("markdown", "# A pendulum"),
    ("code", "import dsocs\nswing = dsocs.read('swing.dsocs')\nswing"),
    ("code", "run = swing.flow().until(5.0)\nrun"),
    ("code", "dsocs.read('curved.dsocs')"),
]


def browser() -> str | None:
    return next((found for name in ("chromium", "chromium-browser", "chromium-headless-shell", "google-chrome") if (found := shutil.which(name))), None)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of an executed notebook."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    nbconvert = pytest.importorskip("nbconvert")
    pytest.importorskip("ipykernel")
    folder = tmp_path_factory.mktemp("notebook")
    (folder / "swing.dsocs").write_text(SWING, encoding="utf-8")
    (folder / "curved.dsocs").write_text(CURVED, encoding="utf-8")
    cells = [nbformat.v4.new_markdown_cell(text) if kind == "markdown" else nbformat.v4.new_code_cell(text) for kind, text in NOTEBOOK]
    notebook = nbformat.v4.new_notebook(cells=cells)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("JUPYTER_PATH", str(Path(sys.prefix) / "share" / "jupyter"))
        nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(folder)}}).execute()
    html, _ = nbconvert.HTMLExporter().from_notebook_node(notebook)
    file = folder / "notebook.html"
    file.write_text(html.replace("</head>", PROBE + "</head>", 1), encoding="utf-8")
    return file


def look(page: Path, width: int, *more: str) -> str:
    """The findings of the script on a page of this width."""
    program = browser()
    if program is None:
        pytest.skip("there is no Chromium (apt-get install chromium on Debian)")
    done = subprocess.run(
        [
            program, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars", "--no-first-run",
            "--disable-background-networking", f"--user-data-dir={page.parent / 'profile'}", f"--window-size={width},4000", "--virtual-time-budget=8000",
            # nothing from outside is loaded
            "--host-resolver-rules=MAP * ~NOTFOUND", *more, page.as_uri(),
        ],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    return done.stdout


@pytest.mark.parametrize("width", [1200, 600])
def test_the_page_of_a_notebook_fits_and_its_formulas_are_set(page: Path, width: int) -> None:
    title = re.search(r"<title>(.*?)</title>", look(page, width, "--dump-dom"), re.DOTALL)
    assert title is not None
    found = json.loads(title.group(1))
    # each formula replaces its LaTeX
    assert found["formulas"] == 10 and found["flat"] == 0 and found["latex"] == 0
    assert found["fractions"] > 4 and found["stacked"] == found["fractions"]
    assert found["frames"] == 1 and 300 < found["frame_width"] <= found["page_width"]
    assert found["scroll_width"] <= found["page_width"]
