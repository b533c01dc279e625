"""A trajectory of a plan goes by its own name where that is enough, and by that of its recording, too, where not."""

import shutil

from coarse import coarse_pad

from tactiledata.ingest.pipeline import ingest
from tactiledata.replay.plan import plan_replay
from tactiledata.store.read.reader import Store


def names(*recordings, store):
    ingest(recordings, store)
    return [touch.name for touch in plan_replay(Store.open(store), coarse_pad).touches]


def test_no_two_trajectories_of_a_plan_are_alike(tiny_mcaps, tmp_path):
    """Alone a recording's trajectories keep their names; beside one with the same names both get their folders."""
    alone = names(tiny_mcaps[0], store=tmp_path / "one.zarr")
    assert alone
    assert not any("/" in name for name in alone)
    days = [tmp_path / day / "run.mcap" for day in ("monday", "tuesday")]
    for number, day in enumerate(days):
        day.parent.mkdir()
        shutil.copy(tiny_mcaps[0], day)
        with day.open("ab") as stream:
            stream.write(b"x" * number)
    both = names(*days, store=tmp_path / "two.zarr")
    assert sorted(both) == sorted(f"{day}/run.mcap/{name}" for day in ("monday", "tuesday") for name in alone)
