"""A sensor without a picture of its untouched gel is said, with the command that adds one."""

import shlex

import numpy as np

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Recording, Source
from tactiledata.ingest.trajectories.reference import find_references


def test_the_advice_of_a_missing_background_can_be_run_as_it_stands():
    """The command in the finding holds the sensor's name, quoted, and every argument that `sensors add` needs."""
    recording = Recording(Source("p", "k", "folder", ()), LogDescription({}), {}, ())
    said = []
    serial = "left DIGIT's"
    assert find_references(recording, [serial], np.arange(1), np.full(1, 5.0, np.float32), list, said.append) == {}
    [finding] = said
    command = finding.message.split("`")[1]
    assert shlex.split(command) == ["tactiledata", "sensors", "add", serial, *["--background", "FILE", "--store", "S"]]
