"""An ingest of many recordings needs no more memory than one of few."""

import subprocess
import sys

import pytest
from copied_trees import copy_tree

PROGRAM = """
import resource, sys
from tactiledata.ingest.pipeline import ingest
report = ingest([sys.argv[1]], sys.argv[2])
assert all(source.state == "added" for source in report.sources), report
print(len(report.sources), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.slow
def test_peak_memory_does_not_grow_with_the_number_of_recordings(tiny_folders, tmp_path):
    """Sixteen times the recordings take less than a tenth more memory."""
    peaks = {}
    for count in (2, 32):
        home = tmp_path / str(count)
        for number in range(count):
            log = home / f"log-{number}"
            copy_tree(tiny_folders[0], log)
            # another title makes it another recording
            with (log / "log.yaml").open("a") as stream:
                stream.write(f"\nlicence: number {number}\n")
        command = [sys.executable, "-c", PROGRAM, str(home), str(tmp_path / f"{count}.zarr")]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        recordings, peak = map(int, done.stdout.split())
        assert recordings == count
        peaks[count] = peak
    assert peaks[32] < 1.1 * peaks[2], peaks
