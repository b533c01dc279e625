"""The demo, whole, on the smallest world and with the quick gel."""

import json

import pytest
from command import run_command

pytestmark = pytest.mark.slow


def test_it_ends_with_meshes_a_calibration_and_pages(tmp_path, capsys):
    """The demo of a tiny world ends with meshes, a calibration, an audit without leaks, and two pages."""
    out = tmp_path / "demo"
    code, printed, _ = run_command(capsys, "demo", "--world", "tiny", "--fidelity", "linear", "--out", out, "--json")
    assert code == 0
    told = json.loads(printed)
    assert told["replay"]["with_mesh"] == sum(told["replay"]["status"].values())
    assert told["replay"]["with_mesh"] > 40
    assert told["audit"]["leaks"] == 0
    assert told["calibration"] == json.loads((out / "calibration.json").read_text())
    # four touches are too few to name what they lack, and it says so by leaving the step out
    assert told["diagnosis"] is None
    for page in ("report.html", "calibration.html"):
        text = (out / page).read_text()
        assert "<img" in text
        assert "(simulated recordings)</h1>" in text
    assert told["simulated_recordings"] == {"simulated": 2, "real": 0, "not_stated": 0}
    assert (out / "recorded.png").stat().st_size > 10_000
