"""The demo, whole, on the smallest world and with the quick gel."""

import json
import math

import cv2
import pytest
from command import run_command


@pytest.mark.slow
def test_it_ends_with_meshes_a_calibration_and_pages(tmp_path, capsys):
    """The demo of a tiny world ends with meshes, a calibration, an audit without leaks, two pages, and a transfer."""
    out = tmp_path / "demo"
    code, printed, _ = run_command(
        capsys, "demo", "--world", "tiny", "--fidelity", "linear", "--workers", "1", "--out", out, "--json"
    )
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
    _has_transfer(told, out)


def _has_transfer(told, out):
    """Hold the transfer and its scores: kept touches, a style nearer to the target's, and a picture of four columns."""
    assert told["transfer"]["target"]["name"] == "ycb-sensorA"
    assert told["transfer"]["sensors"] == ["D20001"]
    assert told["transfer"]["frames"] > 10
    assert "the model" in told["transfer"]["reason"]
    for measured in ("kept_touch", "drawn_by_model"):
        (facts,) = told["transfer"][measured]
        assert all(math.isfinite(facts[name]) for name in ("strength", "correlation", "overlap"))
    style = {score["first"]: score["value"] for score in told["score"]["scores"]}
    (made,) = {score["first"] for score in told["score"]["kept"]}
    assert 0.0 <= style[made] < 0.2 * style["D20001"]
    assert len(told["score"]["kept"]) == 3
    assert all(0.6 < score["value"] < 1.4 for score in told["score"]["kept"])
    picture = cv2.imread(str(out / "transfer" / "D20001-ycb-sensorA.png"))
    assert picture.shape[1] > 4 * 240
    assert told["transfer"]["picture"] == str(out / "transfer" / "D20001-ycb-sensorA.png")
