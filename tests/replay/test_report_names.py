"""A replay names the trajectories that it left out as every other command does: the recording, and their own name."""

from tactiledata.contract.simulated import NOTHING_STATED
from tactiledata.replay.report import ReplayReport


def test_what_was_not_replayed_is_named_with_its_recording():
    """Three are named and no uid is printed; the JSON has uids and names."""
    uids = tuple(f"{number:016x}" for number in range(4))
    names = {uid: f"run{number}.mcap/t0" for number, uid in enumerate(uids)}
    report = ReplayReport("ds.zarr", "low", "", "", {}, 0, 4, {}, {"no pose": uids}, 0, NOTHING_STATED, names)
    text = "\n".join(report.lines())
    assert "4 trajectories not replayed (run0.mcap/t0, run1.mcap/t0, run2.mcap/t0 …): no pose" in text
    assert not any(uid in text for uid in uids)
    assert report.document()["refused"] == {"no pose": list(uids)}
    assert report.document()["names"] == names
