"""Stamps of some samples, bits of frames, sizes and runs of images: what stands in files and must not move."""

import numpy as np
import pytest

from tactiledata.contract.atomic import readable_json
from tactiledata.contract.image_batches import image_batches
from tactiledata.contract.image_sizes import stray_sizes, usual_size
from tactiledata.contract.provenance import digest_of, json_bytes, provenance
from tactiledata.contract.records import Recording, Signal, Source, Stamps, Trajectory
from tactiledata.contract.take import (
    FINDING_SCHEMA,
    FRAME_SCHEMA,
    SOURCE_SCHEMA,
    TRAJECTORY_SCHEMA,
    UNUSABLE,
    FrameFlag,
)

LOG, PUBLISH, HEADER = (np.arange(4, dtype=np.int64) + start for start in (10, 20, 30))


@pytest.mark.parametrize("rows", [np.array([3, 1]), np.array([False, True, True, False]), slice(1, 3)])
def test_stamps_of_some_samples(rows):
    """Each stamp that is there is taken by the same rows; one that is not there stays away."""
    taken = Stamps(LOG, PUBLISH, HEADER).take(rows)
    assert (taken.log - LOG[rows] == 0).all()
    assert (taken.publish - taken.log == 10).all()
    assert (taken.header - taken.log == 20).all()
    assert len(taken) == 2
    assert Stamps(LOG, publish=PUBLISH).take(rows).header is None
    assert Stamps(LOG, header=HEADER).take(rows).publish is None
    assert (Stamps(LOG, header=HEADER).take(rows).header == HEADER[rows]).all()


def test_what_a_recording_holds_by_default():
    """A recording holds a source and a description by default, and its host clock is that of its log."""
    source = Source("a.mcap", "a", "mcap", ("a.mcap",))
    recording = Recording(source, None)
    assert (recording.host_clock, recording.trajectories, recording.findings) == ("log", (), ())
    assert [dict(held) for held in (recording.signals, recording.references, recording.frame_values)] == [{}] * 3
    assert (source.part, Trajectory("t", 0, 1).sensor, Trajectory("t", 0, 1).extra) == ("", "", {})
    assert Signal("wrench", Stamps(LOG), np.zeros((4, 1)), ("fx",)).frame == ""


def test_bits_of_frames_stay_as_stores_hold_them():
    """The six bits of a stored frame; unusable are missing, broken, stray and blank ones, 1 + 2 + 16 + 32."""
    bits = {name: value for name, value in vars(FrameFlag).items() if name.isupper()}
    assert bits == {"MISSING": 1, "BROKEN": 2, "GAP": 4, "OUTSIDE": 8, "STRAY_SIZE": 16, "BLANK": 32}
    assert UNUSABLE == 51


def test_columns_of_the_tables_of_a_store():
    """Every table has its columns once, and what is counted in nanoseconds has 64 bits."""
    for schema in (FRAME_SCHEMA, TRAJECTORY_SCHEMA, SOURCE_SCHEMA, FINDING_SCHEMA):
        assert len(set(schema.names)) == len(schema.names)
        assert {str(schema.field(name).type) for name in schema.names if name.endswith("_ns")} <= {"int64"}


def test_the_usual_size_may_be_the_smaller_or_the_larger():
    """A stray is told by its number, not by its size; the usual size alone is no stray."""
    small, large = (100, 900), (3200, 2400)
    assert stray_sizes({large: 30, small: 2}) == {small}
    assert stray_sizes({small: 30, large: 2}) == {large}
    assert usual_size({small: 2, large: 3}) == large
    assert stray_sizes({small: 1}) == set()
    assert stray_sizes({small: 0}) == set()
    # the usual size has 10 of 21 images: less than half
    assert stray_sizes({large: 10, small: 2, (7, 7): 9}) == set()


@pytest.mark.parametrize(
    ("pixels", "runs"),
    [
        ([2**24, 2**24, 1], [(0, 2), (2, 3)]),
        ([2**24, 2**24 + 1], [(0, 1), (1, 2)]),
        ([2**25, 1], [(0, 1), (1, 2)]),
        ([2**25 - 1, 1], [(0, 2)]),
    ],
)
def test_a_run_has_at_most_33_million_pixels_unless_told_otherwise(pixels, runs):
    """33,554,432 pixels fit into one run, one more does not."""
    assert list(image_batches(np.array(pixels, np.int64), 256)) == runs


def test_json_for_people_byte_by_byte():
    """Keys in order, two spaces a level, characters as they are, one line break at the end."""
    assert (
        readable_json({"b": {"ä": 1}, "a": [1]}) == '{\n  "a": [\n    1\n  ],\n  "b": {\n    "ä": 1\n  }\n}\n'.encode()
    )


def test_canonical_json_byte_by_byte():
    """Keys in order, no spaces, characters as they are: a digest that others can compute, too."""
    assert json_bytes({"b": [1, 2.5, None], "a": "ä"}) == '{"a":"ä","b":[1,2.5,null]}'.encode()
    assert digest_of({}) == "44136fa355b3678a1146ad16f7e8649e94fb4fc21fe77e8310c060f61caaff8a"  # sha256sum of {}


def test_provenance_without_settings_has_none():
    """No settings are the same as empty ones."""
    assert provenance("ingest", {}) == provenance("ingest", {}, {})
    assert provenance("ingest", {})["settings"] == {}
