"""ACROSS: meshes as values of moments without images, net forces as a signal, steps in natural order."""

import h5py
import numpy as np
import pytest
from generators import across_hdf5
from generators.collect import codes, read

from tactiledata.errors import BrokenLog, UnsafeContent
from tactiledata.formats.across_hdf5 import AcrossHdf5Format
from tactiledata.formats.reading import intake

FORMAT = AcrossHdf5Format()


def first(folder, **settings):
    """The first file of a fake."""
    return read(FORMAT, across_hdf5.write(folder, np.random.default_rng(3), **settings))[0]


def test_meshes_and_forces(tmp_path):
    """Trials and environments follow one another, steps 0 … 10 by number, vertices in metres, forces in newtons."""
    recording, sink = first(tmp_path)
    assert [touch.name for touch in recording.trajectories] == [
        f"trial_{i}-env_{k}" for i in range(2) for k in range(3)
    ]
    assert [image.encoding for image in sink.images] == ["missing"] * 66
    wanted = [across_hdf5.mesh(i, j, k, 20) for i in range(2) for k in range(3) for j in range(11)]
    vertices = recording.frame_values["vertices"]
    np.testing.assert_allclose(vertices.values.reshape(-1, 20, 3), wanted, rtol=1e-6)
    assert vertices.columns[:4] == ("x0", "y0", "z0", "x1")
    assert set(vertices.units) == {"m"}
    force = recording.signals["net_force_digit"]
    np.testing.assert_allclose(force.values[:, 2], np.tile(-0.5 * np.arange(11), 6), rtol=1e-6)
    assert force.stamps.log.tolist() == [image.log_ns for image in sink.images]
    assert force.units == ("N", "N", "N")
    assert codes(recording) == {"nominal-rate", "images-absent"}


def test_every_sensor_its_own_file(tmp_path):
    """DIGIT and BioTac are two sources with two sensors; one file can be named."""
    root = across_hdf5.write(tmp_path, np.random.default_rng(3), sensors=("digit", "biotac"))
    taken = read(FORMAT, root)
    assert [sink.images[0].sensor for _, sink in taken] == ["across-biotac", "across-digit"]
    assert len(read(FORMAT, root / "results_biotac_job_7.hdf5")) == 1


def test_another_name_is_known_by_its_content(tmp_path):
    """A file that was renamed is known by its groups."""
    across_hdf5.write(tmp_path, np.random.default_rng(3), other_name="mine.h5")
    ((recording, _),) = read(FORMAT, tmp_path / "mine.h5")
    assert "net_force_digit" in recording.signals


@pytest.mark.parametrize("share", [0.0, 0.02, 0.5, 0.97])
def test_cut_files_are_broken_logs(tmp_path, share):
    """A cut file is claimed by its name and is a clear error."""
    root = across_hdf5.write(tmp_path, np.random.default_rng(3), cut=share)
    assert FORMAT.sniff(root)
    with pytest.raises(BrokenLog, match="HDF5"):
        read(FORMAT, root)


def test_missing_and_other_meshes_are_said(tmp_path):
    """A missing environment and a mesh of another size are NaN at their moment, damage, and no row moves."""
    recording, sink = first(tmp_path / "a", drop_env=(0, 4, 1))
    assert "value-missing" in codes(recording)
    assert len(sink.images) == 66
    assert np.flatnonzero(np.isnan(recording.frame_values["vertices"].values).all(axis=1)).tolist() == [15]
    assert np.flatnonzero(np.isnan(recording.signals["net_force_digit"].values).all(axis=1)).tolist() == [15]
    recording, _ = first(tmp_path / "b", other_mesh=(0, 4, 1))
    assert "length-mismatch" in codes(recording)
    assert np.isnan(recording.frame_values["vertices"].values[15]).all()


def test_a_dataset_that_claims_too_much_is_left_out(tmp_path):
    """A data set of twelve gigabytes in a small file is reported and takes no memory."""
    recording, _ = first(tmp_path, huge=True, steps=3)
    assert "value-missing" in codes(recording)
    assert np.isfinite(recording.frame_values["vertices"].values[0]).all()


def test_links_to_other_files_are_refused(tmp_path):
    """A link into another file is refused, whatever it holds."""
    across_hdf5.write(tmp_path / "other", np.random.default_rng(3))
    with pytest.raises(UnsafeContent, match="link"):
        first(tmp_path / "a", external=tmp_path / "other/results_digit_job_7.hdf5")


def test_a_file_without_meshes_is_a_broken_log(tmp_path):
    """A file of the right name without trials is a clear error."""
    with h5py.File(tmp_path / "results_digit_1.hdf5", "w") as file:
        file["trial_0/step_0/other"] = np.zeros(3)
    with pytest.raises(BrokenLog, match="nothing to read"):
        read(FORMAT, tmp_path)


def test_large_meshes_wait_on_disk(tmp_path, monkeypatch):
    """Beyond the memory limit values are mapped from a temporary file, equal to those kept in memory."""
    small, _ = first(tmp_path / "a", drop_env=(0, 4, 1))
    monkeypatch.setattr(intake, "MEMORY_LIMIT", 5000)
    large, _ = first(tmp_path / "b", drop_env=(0, 4, 1))
    assert isinstance(large.frame_values["vertices"].values, np.memmap)
    np.testing.assert_array_equal(large.frame_values["vertices"].values, small.frame_values["vertices"].values)
