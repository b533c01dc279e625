"""An export of many recordings needs no more memory than one of few."""

import subprocess
import sys
from pathlib import Path

import loader_stores
import pytest

PROGRAM = """
import sys, threading, time
from pathlib import Path
from tactiledata.export import EXPORTERS
from tactiledata.export.export import export_data
from tactiledata.export.plan import ExportPlan
from tactiledata.store.read.reader import Store
peak = [0]
def watch():
    # what the process itself holds: pages of mapped files are the system's, which takes them back when it needs them
    while True:
        lines = open("/proc/self/status").read().splitlines()
        peak[0] = max(peak[0], next(int(line.split()[1]) for line in lines if line.startswith("RssAnon")))
        time.sleep(0.005)
threading.Thread(target=watch, daemon=True).start()
store = Store.open(sys.argv[1])
for to in EXPORTERS:
    export_data(store, ExportPlan(to, file_mb=5), Path(sys.argv[1]).with_name(to))
print(peak[0])
"""


@pytest.mark.nightly
def test_peak_memory_does_not_grow_with_the_store(tmp_path, monkeypatch):
    """Five times the pictures, 110 MB of them, take far less memory more than they have bytes, in all formats."""
    monkeypatch.setattr(loader_stores, "HEIGHT", 160)
    monkeypatch.setattr(loader_stores, "WIDTH", 200)
    peaks = {}
    for count in (12, 64):
        place = tmp_path / str(count) / "ds.zarr"
        loader_stores.split_store(place, n_sources=count)
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM, str(place)], capture_output=True, text=True, check=False,
            cwd=Path(__file__).resolve().parents[2],
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        peaks[count] = int(done.stdout)
    size = sum(path.stat().st_size for path in (tmp_path / "64" / "huggingface" / "data").iterdir())
    assert size > 100e6
    # HDF5 keeps up to 32 MB of places in its file
    assert (peaks[64] - peaks[12]) * 1024 < size / 2.5, peaks
