"""What is installed from the source distribution works without the source tree."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.slow
def test_the_wheel_built_from_the_sdist_holds_what_is_needed(tmp_path):
    """Sdist to wheel: schemas, recipes, backgrounds and their licence are in it, and the command runs from it alone."""
    done = subprocess.run(
        [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(tmp_path), str(ROOT)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    wheel = next(tmp_path.glob("*.whl"))
    names = set(zipfile.ZipFile(wheel).namelist())
    for schema in (ROOT / "schemas").glob("*.json"):
        assert f"tactiledata/schemas/{schema.name}" in names
    assert "tactiledata/docs/findings.md" in names
    for recipe in (ROOT / "recipes").rglob("*.yaml"):
        assert f"tactiledata/recipes/{recipe.relative_to(ROOT / 'recipes').as_posix()}" in names
    assert "tactiledata/sensors/digit_backgrounds/LICENSE" in names
    assert sum(name.endswith(".jpg") and "digit_backgrounds" in name for name in names) == 18
    installed = tmp_path / "installed"
    zipfile.ZipFile(wheel).extractall(installed)
    program = (
        "import sys; sys.argv = ['tactiledata', 'record', 'tiny', '--out', 'logs', '--format', 'folder']\n"
        "import tactiledata; assert 'installed' in tactiledata.__file__, tactiledata.__file__\n"
        "from tactiledata.cli.main import run; run()"
    )
    run = subprocess.run(
        [sys.executable, "-P", "-c", program],
        cwd=tmp_path,
        env={"PYTHONPATH": str(installed), "PATH": "/usr/bin:/bin"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr[-3000:]
    assert list((tmp_path / "logs").glob("*/log.yaml"))
