"""The tutorial notebook runs from the first cell to the last, is kept without outputs, and is a page of the site."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOK = ROOT / "docs" / "tutorial.ipynb"
LINK = re.compile(r"\]\((?!https?://)(?P<target>[^)#\s]+)")


@pytest.fixture
def notebook():
    """The notebook, checked against the notebook format."""
    nbformat = pytest.importorskip("nbformat")
    read = nbformat.read(NOTEBOOK, 4)
    nbformat.validate(read)
    return read


def test_the_notebook_is_kept_without_outputs(notebook):
    """A change of the notebook is a change of its text: no outputs, no counts, no metadata of a machine."""
    for cell in notebook.cells:
        assert not cell.metadata
        if cell.cell_type == "code":
            assert not cell.outputs
            assert cell.execution_count is None
    assert set(notebook.metadata) == {"kernelspec", "language_info"}


def test_links_of_the_notebook_lead_somewhere(notebook):
    """Every relative link exists, and the notebook says that its recordings are simulated."""
    text = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "markdown")
    targets = [match["target"] for match in LINK.finditer(text)]
    assert targets
    for target in targets:
        assert (NOTEBOOK.parent / target).exists(), target
    assert "Everything here is simulated" in text


@pytest.mark.slow
def test_the_notebook_runs(notebook, tmp_path):
    """Raw MCAP files become a store, a page, a split, a trained model and a diagnosis that names what was concealed."""
    pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    shutil.copy(NOTEBOOK, tmp_path)
    environment = {
        **os.environ,
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT),
        "OMP_NUM_THREADS": "1",
        "TACTILEDATA_CACHE": str(tmp_path / "cache"),
    }
    # in a process of its own: sockets of the notebook's machinery are closed late, which is a warning
    command = [sys.executable, "-c", "from nbclient.cli import main; main()", "tutorial.ipynb", "--output=executed"]
    done = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False, timeout=900
    )
    assert done.returncode == 0, done.stderr[-3000:]
    cells = json.loads((tmp_path / "executed.ipynb").read_text(encoding="utf-8"))["cells"]
    outputs = [output for cell in cells for output in cell.get("outputs", [])]
    assert not [output for output in outputs if output.get("name") == "stderr"]
    assert any("image/png" in output.get("data", {}) for output in outputs)
    text = "".join("".join(output.get("text", "")) for output in outputs)
    assert "Simulated recordings" in text
    assert "no leak found" in text
    seen, unseen = (float(error) for error in re.findall(r": error ([\d.]+) N", text))
    assert seen < unseen
    assert "The simulation lacks viscoelastic relaxation" in text
    assert "named: ['relaxation'] - concealed: ['HiddenSpringpot']" in text
    for page in ("page/report.html", "diagnosis/report.html"):
        assert (tmp_path / page).is_file()
