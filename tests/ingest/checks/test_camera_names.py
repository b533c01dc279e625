"""Recordings whose cameras have other names than those of the same sensor model are remarked, and no others."""

import pytest

from tactiledata.ingest.checks.camera_names import camera_findings


def cameras(**names):
    """The cameras of a recording: names by the model of their sensors."""
    return {model: frozenset(listed.split()) for model, listed in names.items()}


def remarked(*recordings):
    return list(camera_findings([f"log{row}" for row in range(len(recordings))], recordings))


@pytest.mark.parametrize(
    ("recordings", "rows"),
    [
        ([cameras(digit="digit"), cameras(digit="camera")], [1]),
        ([cameras(digit="camera"), cameras(digit="digit"), cameras(digit="digit")], [0]),
        ([cameras(digit="camera", other="camera"), cameras(digit="digit")], [0]),
        ([cameras(digit="camera"), cameras(digit="camera"), cameras(digit="digit")], [2]),
        ([cameras(digit="digit"), cameras(unknown="camera")], [1]),
        ([cameras(d="x"), cameras(d="digit"), cameras(g="digit")], [0]),
        ([cameras(digit="left right"), cameras(digit="right")], []),
        ([cameras(digit="digit"), cameras(gelsight_r15="gelsight")], []),
        ([cameras(digit="digit", camera="webcam"), cameras(digit="digit")], []),
        ([cameras(digit="digit"), cameras(unknown="digit")], []),
        ([cameras(), cameras(digit="digit")], []),
        ([cameras(digit="camera")], []),
        ([], []),
    ],
    ids=["another name", "the rare one first", "a tie that the model decides", "most against the model",
         "a model that nobody states", "a tie", "one camera fewer",
         "another model", "a camera beside", "the same name", "no camera", "one recording", "no recording"],
)  # fmt: skip
def test_a_camera_of_another_name_is_remarked(recordings, rows):
    """The recordings without the camera that most others have are said; other models and further cameras are not."""
    assert remarked(*recordings) == rows


def test_the_remark_names_the_usual_name_and_where_it_is():
    """The sentence has both names, the model, a recording with the usual one, and what to do."""
    named = [cameras(digit="digit"), cameras(digit="digit"), cameras(digit="tactile")]
    [finding] = camera_findings(["monday", "tuesday", "friday"], named).values()
    assert (finding.code, finding.severity, finding.stream) == ("camera-names", "warning", "tactile")
    words = "'tactile' has another name than cameras of other sensors of model digit: 'digit' in monday and 1 more"
    assert words in finding.message
    assert "Write it as digit under images:" in finding.message
