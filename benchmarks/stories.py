"""Three stories of concealed physics, from recording to page: what calibration hides, what its loss cannot see.

    python benchmarks/stories.py [relaxation] [frame_rotation] [arm_compliance] [nothing] [--quick] [--out stories]

Each world is recorded by the rig with its own layer solver and one effect in a formula of its own, or with none; all
have the same touches. The toolkit ingests it, calibrates it as the SPLIT paper does and with the vector loss, and
diagnoses it. Plays are kept in TACTILEDATA_CACHE, so that the second story costs a third of the first.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from tactiledata.calibrate.calibrate import calibrate
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.diagnose.diagnose_store import diagnose_store
from tactiledata.diagnose.store_document import store_document, write_store_diagnosis
from tactiledata.diagnose.store_options import DiagnosisOptions
from tactiledata.ingest.pipeline import ingest
from tactiledata.rig.record import record
from tactiledata.rig.scenario import load_scenario
from tactiledata.store.reader import Store

STORIES: dict[str, list[dict[str, Any]]] = {
    "nothing": [],
    "relaxation": [{"effect": "relaxation", "strength": "medium"}],
    "frame_rotation": [{"effect": "frame_rotation", "strength": "medium"}],
    "arm_compliance": [{"effect": "arm_compliance", "strength": "strong"}],
}
TRUTH = {"youngs_modulus": 0.9e6, "poisson_ratio": 0.475, "friction": 0.72}
CALIBRATED = 12
"""Touches that calibrations fit."""


def scenario(story: str, count: int) -> dict[str, Any]:
    """A world; its touches are the same in all stories."""
    return {
        "format": "tactiledata-scenario/1",
        "title": f"a story: {story}",
        "seed": 311,
        "sensors": {"D20542": {"background": "digit-bg-0"}},
        "indenters": {
            "ball3": {"shape": "sphere", "radius": 0.003},
            "ball5": {"shape": "sphere", "radius": 0.005},
            "ball8": {"shape": "sphere", "radius": 0.008},
            "dome": {"shape": "dome"},
        },
        "material": TRUTH,
        "contact": "layer",
        "contact_pitch": 0.0004,
        "hidden": STORIES[story],
        "streams": {"joints": 125, "tcp": 125, "wrench": 100},
        "images": {"frames_per_step": 2, "free_air_frames": 2},
        "recordings": {"group": "sensor", "tare": "log", "powered": 900},
        "generate": {
            "count": count,
            "depth": [0.0005, 0.0009],
            "force_limit": 13.0,
            "speeds": [0.0003, 0.001, 0.003],
            "dwell": [1.0, 6.0],
            "tilt": [0.0, 0.06],
            "shear": [0.0005, 0.0012],
            "shear_share": 0.8,
            "reverse_share": 0.4,
        },
    }


def tell(story: str, out: Path, count: int) -> None:
    """Record, calibrate, diagnose; pages and pictures go to a folder."""
    home, began = out / story, time.perf_counter()
    logs = record(load_scenario(scenario(story, count)), home / "logs", "mcap")
    ingest(logs, home / "world.zarr")
    store = Store.open(home / "world.zarr")
    print(f"## {story}: {count} touches, recorded in {time.perf_counter() - began:.0f} s")
    for loss in ("norm", "vector"):
        options = CalibrationOptions(loss=loss, trajectories=min(CALIBRATED, count), hold_out=0.0)
        found = calibrate(store, options).fit
        modulus, ratio, friction = found.parameters
        values = f"E {modulus / 1e3:.0f} kPa, nu {ratio:.3f}, mu {friction:.2f}"
        print(f"calibrated, {loss} loss: {values}; {loss} loss {found.losses[loss].fitted:.3f}", flush=True)
    began = time.perf_counter()
    done = diagnose_store(store, DiagnosisOptions(trajectories=count))
    document = store_document(done)
    written = write_store_diagnosis(home / "diagnosis", f"story: {story}", done, document)
    print(f"diagnosed in {time.perf_counter() - began:.0f} s: {written[0]}")
    for sentence in document["sentences"]:
        print(f"- {sentence}")


def main() -> None:
    """Tell the stories that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stories", nargs="*", metavar="STORY", help=f"of {', '.join(STORIES)}; all of them by default")
    parser.add_argument("--quick", action="store_true", help="eight touches")
    parser.add_argument("--touches", type=int, default=24)
    parser.add_argument("--out", type=Path, default=Path("stories"))
    asked = parser.parse_args()
    for story in asked.stories or STORIES:
        if story not in STORIES:
            parser.error(f"no story is called {story!r}; there are: {', '.join(STORIES)}")
        tell(story, asked.out, 8 if asked.quick else asked.touches)


if __name__ == "__main__":
    main()
