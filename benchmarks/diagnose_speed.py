"""Seconds of `tactiledata diagnose STORE` once the gel's plays are kept: 60 trajectories from store to page.

    python benchmarks/diagnose_speed.py [--quick] [--touches 60] [--own-pad] [--folder FOLDER]

The rig records a world with relaxation in a formula of its own; the toolkit ingests it, and plays it once on a coarse
pad, all gels and indenters that effects stand for included. What follows is timed in a process of its own and does not
depend on the pad: reading the store and the kept plays, naming, locating, showing, the page. The answer does: a coarse
pad is no gel. Checked is that page and document are, byte by byte, those of the first run.

With `--own-pad` two processes play the sensor's own pad at finite strain, and the first run counts, which finds nothing
kept: seconds to the preview, to a first answer where there is one before the end, and to its end.
"""

from __future__ import annotations

import argparse
import filecmp
import itertools
import os
import tempfile
import time
from pathlib import Path
from typing import Any

from timing import Seat, header, verdict

from tactiledata.diagnose.answer.documents import store_document, write_store_diagnosis
from tactiledata.diagnose.options import DiagnosisOptions
from tactiledata.diagnose.store import diagnose_store
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.ingest.pipeline import ingest
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.sensors.base import GelGeometry
from tactiledata.store.read.reader import Store

COARSE = GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0))
TARGET_S = 300.0
WRITTEN = ("report.html", "diagnosis.json")


def scenario(count: int) -> dict[str, Any]:
    """Five indenters on two units."""
    return {
        "format": "tactiledata-scenario/1",
        "title": "how long a diagnosis takes",
        "seed": 17,
        "sensors": {"D20542": {"background": "digit-bg-0"}, "D20571": {"background": "digit-bg-2"}},
        "indenters": {
            **{f"ball{radius}": {"shape": "sphere", "radius": 1e-3 * radius} for radius in (3, 4, 6)},
            "dome": {"shape": "dome"},
            "punch": {"shape": "cylinder_flat", "radius": 0.003},
        },
        "material": {"youngs_modulus": 0.9e6, "poisson_ratio": 0.475, "friction": 0.7},
        "hidden": [{"effect": "relaxation", "strength": "strong"}],
        "streams": {"joints": 125, "tcp": 125, "wrench": 100, "arm_wrench": 0},
        "images": {"frames_per_step": 2, "free_air_frames": 2},
        "recordings": {"group": "sensor", "tare": "log", "powered": 600},
        "generate": {
            "count": count, "depth": [0.0004, 0.0008], "force_limit": 12.0, "shear": [0.0005, 0.001],
            "shear_share": 0.8, "reverse_share": 0.4, "dwell": [1.0, 4.0], "speeds": [0.0003, 0.001, 0.003],
        },
    }  # fmt: skip


def coarse_pad(sensor: str, geometry: GelGeometry) -> PadMesh:
    """Quick to play."""
    return structured_pad(f"{sensor}-coarse", geometry, COARSE)


class Diagnosis:
    """A contestant: one diagnosis in a process of its own."""

    def __init__(self, store: str, count: int, own_pad: bool) -> None:
        self._store, self._count, self._own_pad = store, count, own_pad

    def run(self, out: str) -> dict[str, Any]:
        """The document's answer, and seconds from step to step."""
        steps: list[tuple[str, float]] = []
        options = DiagnosisOptions(trajectories=self._count, make_pad=coarse_pad)
        if self._own_pad:
            options = DiagnosisOptions(trajectories=self._count, workers=2)
        first_answers: list[tuple[float, str]] = []

        def tell(sentence: str) -> None:
            first_answers.append((time.perf_counter() - began, sentence))

        began = time.perf_counter()
        done = diagnose_store(
            Store.open(self._store),
            options,
            step_progress=lambda what: steps.append((what, time.perf_counter() - began)),
            first_answer=tell,
            preview=tell,
        )
        steps.append(("page and document", time.perf_counter() - began))
        document = store_document(done)
        write_store_diagnosis(Path(out), "the world", done, document)
        steps.append(("", time.perf_counter() - began))
        return {"sentence": document["sentences"][0], "steps": steps, "first_answers": first_answers}


def _diagnosed(store: Path, count: int, out: Path, own_pad: bool) -> tuple[float, float, Any]:
    """Seconds, processor seconds and what was found, of a process of its own."""
    seat = Seat(Diagnosis, str(store), count, own_pad)
    told: tuple[float, float, Any] = seat.call("run", str(out))
    seat.close()
    return told


def print_steps(steps: list[tuple[str, float]], seconds: float) -> None:
    """How long each step took that took at least a fiftieth of all."""
    began, listed = 0.0, [("read the store and the plays", 0.0), *steps]
    for (what, _), (_, ended) in itertools.pairwise(listed):
        if ended - began >= 0.02 * seconds:
            print(f"  {ended - began:6.1f} s  {what}", flush=True)
        began = ended


def main() -> None:
    """Record and play what is not there yet, then time."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="ten trajectories")
    parser.add_argument("--touches", type=int, default=60)
    parser.add_argument("--own-pad", action="store_true", help="play the sensor's own pad at finite strain")
    parser.add_argument("--folder", type=Path, help="where the world and its plays are kept for another run")
    asked = parser.parse_args()
    count = 10 if asked.quick else asked.touches
    with tempfile.TemporaryDirectory() as temporary:
        folder = asked.folder or Path(temporary)
        os.environ.setdefault("TACTILEDATA_CACHE", str(folder / "cache"))
        os.environ.setdefault("OMP_NUM_THREADS", "2")
        store = folder / "world.zarr"
        if not store.exists():
            ingest(record(load_scenario(scenario(count)), folder / "logs", "mcap"), store)
        header(f"diagnosing {count} trajectories", ("numpy", "scipy", "scikit-learn", "matplotlib"))
        first, _, told = _diagnosed(store, count, folder / "first", asked.own_pad)
        print(f"with plays: {first:.0f} s", flush=True)
        print_steps(told["steps"], first)
        for at, sentence in told["first_answers"]:
            print(f"told after {at:.0f} s: {sentence}", flush=True)
        seconds, processor, found = _diagnosed(store, count, folder / "second", asked.own_pad)
        alike = [filecmp.cmp(folder / "first" / name, folder / "second" / name, shallow=False) for name in WRITTEN]
    print(f"answer: {found['sentence']}")
    print(f"plays kept: {seconds:.1f} s, {processor:.1f} s of processors")
    print_steps(found["steps"], seconds)
    print(f"page and document: {'the same bytes as in the first run' if all(alike) else 'NOT those of the first run'}")
    verdict("seconds", seconds, TARGET_S, at_most=True)


if __name__ == "__main__":
    main()
