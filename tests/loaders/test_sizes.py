"""Frames of several sizes cannot be stacked: the error says which frames, and what to do about them."""

import cv2
import numpy as np
import pytest

from tactiledata.errors import UsageError
from tactiledata.ingest.pipeline import IngestOptions, ingest
from tactiledata.loaders.fit import RECORDINGS_DIFFER, SENSORS_DIFFER
from tactiledata.loaders.numpy import TactileArrays


def recording(folder, sizes, seed):
    """A folder of images of these heights; widths are three quarters."""
    rng = np.random.default_rng(seed)
    folder.mkdir()
    for number, height in enumerate(sizes):
        picture = rng.integers(0, 255, (height, height * 3 // 4, 3), np.uint8)
        assert cv2.imwrite(str(folder / f"{number:02}.png"), picture)
    return folder


def mapping(sensor, folder):
    return {"format": "tactiledata-mapping/1", "images": {"digit": {"topic": folder.name, "sensor": sensor}}}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sensors", "sizes", "advice"),
    [
        (("D1", "D2"), ([32] * 6, [64] * 3), SENSORS_DIFFER),
        (("D1", "D1"), ([32] * 6, [64] * 3), RECORDINGS_DIFFER),
        (("D1", "D1"), ([32] * 6, [32] * 3), None),
    ],
)
def test_the_error_counts_sizes_and_advises(tmp_path, sensors, sizes, advice):
    """Sizes that follow sensors need cameras of their own, others one size; one size in all is no error."""
    for number, (sensor, heights) in enumerate(zip(sensors, sizes, strict=True)):
        folder = recording(tmp_path / f"run{number}", heights, number)
        ingest([folder], tmp_path / "ds.zarr", IngestOptions(mapping=mapping(sensor, folder)))
    if advice is None:
        assert len(TactileArrays(tmp_path / "ds.zarr", "all", ["digit"], allow_leaks=True)) == 9
        return
    with pytest.raises(UsageError) as caught:
        TactileArrays(tmp_path / "ds.zarr", "all", ["digit"], allow_leaks=True)
    assert caught.value.remedy == advice
    assert "6 of 32 x 24, 3 of 64 x 48; the first of the rarest is frame 6, in trajectory 'run1'" in caught.value.found
