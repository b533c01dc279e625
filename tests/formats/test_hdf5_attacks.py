"""HDF5 files that lie, lead outside or ask for more than they hold: said in words, and nothing is read beyond them."""

import os
import zlib
from contextlib import suppress

import h5py
import numpy as np
import pytest
from command import run_command
from generators import across_hdf5
from generators.collect import codes, read

from tactiledata.errors import BrokenLog, SchemaError, UnsafeContent
from tactiledata.formats.across_hdf5 import AcrossHdf5Format
from tactiledata.formats.reading import hdf5_members
from tactiledata.formats.reading.hdf5_members import open_hdf5

FORMAT = AcrossHdf5Format()
NODES = "trial_0/step_1/nodal_coords_digit"
FORCES = "trial_0/step_1/net_force_vecs_digit"
MESH = np.ones((20, 3), np.float32)


@pytest.fixture
def made(tmp_path):
    """A file of one trial, three steps and two environments, open to be spoilt; read() gives what comes of it."""

    class Made:
        path = across_hdf5.write(tmp_path, np.random.default_rng(3), trials=1, steps=3, environments=2)
        path = path / "results_digit_job_7.hdf5"

        def spoil(self, change):
            with h5py.File(self.path, "r+") as file:
                change(file)
            return self

        def read(self):
            return read(FORMAT, self.path)[0]

        def replaced(self, name, **dataset):
            def change(file):
                del file[name]
                file.create_dataset(name, **dataset)

            return self.spoil(change)

    return Made()


def test_the_file_that_is_spoilt_is_read(made):
    """Negative control: unspoilt, the file gives two trajectories, six moments and no damage."""
    recording, sink = made.read()
    assert (len(recording.trajectories), len(sink.images)) == (2, 6)
    assert codes(recording) == {"nominal-rate", "images-absent"}


@pytest.mark.parametrize(
    ("dataset", "words"),
    [
        ({"data": np.array([[b"1", b"2", b"3"]] * 20)}, "type |S1"),
        ({"data": ["1"] * 60, "dtype": h5py.string_dtype()}, "type object"),
        ({"data": np.zeros(20, [("x", "f4"), ("y", "f4")])}, "type [("),
        ({"data": MESH.astype(complex)}, "complex128"),
        ({"data": MESH.astype(bool)}, "bool"),
        ({"data": np.zeros((20, 3), "V8")}, "type |V8"),
        ({"shape": (20,), "dtype": np.dtype(("f4", (3,)))}, "type"),
        ({"shape": (20,), "dtype": np.dtype(("f4", (10**8,))), "chunks": (1,)}, "type"),
        ({"shape": (3,), "dtype": h5py.ref_dtype}, "type object"),
        ({"shape": (3,), "dtype": h5py.regionref_dtype}, "type object"),
        ({"data": h5py.Empty("f4")}, "of shape None"),
        ({"data": 1.0}, "vertices of shape ()"),
        ({"data": np.zeros((1,) * 32, "f4")}, "vertices of shape (1, 1"),
        ({"data": np.zeros((0, 3), "f4")}, "vertices of shape (0, 3)"),
        ({"data": np.zeros((3, 20), "f4")}, "vertices of shape (3, 20)"),
        ({"shape": (10**15, 3), "dtype": "f4", "chunks": (1000, 3)}, "of shape (1000000000000000, 3)"),
        ({"shape": (20, 3), "maxshape": (None, 3), "dtype": "f4", "chunks": (10**8, 3)}, "in chunks of 1200000000"),
        ({"data": MESH, "chunks": (20, 3), "scaleoffset": 2}, "packed by the HDF5 filter 6"),
        ({"data": np.full((20, 3), np.inf)}, "60 of 60 values that are not finite"),
        ({"data": np.full((20, 3), np.nan)}, "60 of 60 values that are not finite"),
    ],
)  # fmt: skip
def test_numbers_that_are_not_what_they_should_be(made, dataset, words):
    """Wrong types, shapes, sizes and values of one mesh are damage at its moment; all others are read."""
    recording, sink = made.replaced(f"{NODES}/env_0", **dataset).read()
    (found,) = [finding for finding in recording.findings if finding.severity == "damage"]
    assert found.code == "value-missing"
    assert words in found.message
    assert len(sink.images) == 6
    values = recording.frame_values["vertices"].values
    assert np.flatnonzero(~np.isfinite(values).all(axis=1)).tolist() == [1]


@pytest.mark.parametrize(
    "dataset",
    [
        {"data": MESH.astype(">f8")},
        {"data": MESH.astype("f2")},
        {"data": MESH.astype("u8")},
        {"data": MESH, "compression": "gzip", "shuffle": True, "fletcher32": True, "chunks": (7, 2)},
        {"data": MESH, "compression": "lzf"},
    ],
    ids=["big-endian", "half", "whole", "gzip", "lzf"],
)
def test_numbers_of_other_kinds_are_read(made, dataset):
    """Negative control: any real number, and what h5py compresses by itself."""
    recording, _ = made.replaced(f"{NODES}/env_0", **dataset).read()
    np.testing.assert_array_equal(recording.frame_values["vertices"].values[1], np.ones(60))
    assert codes(recording) == {"nominal-rate", "images-absent"}


def test_infinite_forces_are_said(made):
    """An infinite net force is NaN in the signal, and damage."""
    recording, _ = made.replaced(f"{FORCES}/env_0", data=np.array([0.0, np.inf, 1.0])).read()
    assert "value-missing" in codes(recording)
    assert np.isnan(recording.signals["net_force_digit"].values).tolist()[1] == [False, True, False]


def linked(place, link):
    def change(file):
        if place in file:
            del file[place]
        file[place] = link

    return change


@pytest.mark.parametrize("place", ["trial_3", "trial_0/step_7", NODES, f"{NODES}/env_0", f"{FORCES}/env_1"])
@pytest.mark.parametrize(
    "link",
    [h5py.SoftLink("/trial_0"), h5py.SoftLink("/nowhere"), h5py.SoftLink("/trial_3"), h5py.ExternalLink("x.h5", "/y")],
    ids=["soft", "dangling", "circle", "external"],
)
def test_links_are_refused_wherever_they_are(made, place, link):
    """Soft and external links are refused, whatever they lead to."""
    with pytest.raises(UnsafeContent, match="is a link"):
        made.spoil(linked(place, link)).read()


def test_data_of_other_files_are_refused(made, tmp_path):
    """Virtual data sets and external storage lie in other files, which are not read."""
    layout = h5py.VirtualLayout((20, 3), "f4")
    layout[:] = h5py.VirtualSource(str(tmp_path / "other.h5"), "x", (20, 3))

    def virtual(file):
        del file[f"{NODES}/env_0"]
        file.create_virtual_dataset(f"{NODES}/env_0", layout)

    with pytest.raises(UnsafeContent, match="lies in another file"):
        made.spoil(virtual).read()
    (tmp_path / "secret").write_bytes(bytes(240))
    with pytest.raises(UnsafeContent, match="lies in another file"):
        made.replaced(f"{NODES}/env_0", shape=(20, 3), dtype="f4", external=[(str(tmp_path / "secret"), 0, 240)]).read()


@pytest.mark.parametrize("kind", ["external", "soft"])
def test_looking_at_a_file_follows_no_link(tmp_path, kind):
    """A file of any name is looked into without following links: one to a pipe would wait for ever."""
    os.mkfifo(tmp_path / "pipe.h5")
    with h5py.File(tmp_path / "mine.h5", "w") as file:
        link = h5py.ExternalLink(str(tmp_path / "pipe.h5"), "/trial_0")
        file["trial_0"] = link if kind == "external" else h5py.SoftLink("/trial_0")
    assert not FORMAT.sniff(tmp_path / "mine.h5")


@pytest.mark.slow
def test_hard_links_that_repeat_are_refused(made):
    """90,000 steps of 100 meshes each, made of a few by hard links, are refused at once."""

    def repeat(file):
        for number in range(1, 300):
            file[f"trial_{number}"] = file["trial_0"]
        for number in range(3, 300):
            file[f"trial_0/step_{number}"] = file["trial_0/step_1"]
        for number in range(2, 100):
            file[f"{NODES}/env_{number}"] = file[f"{NODES}/env_0"]

    with pytest.raises(UnsafeContent, match="seems to hold more"):
        made.spoil(repeat).read()


@pytest.mark.slow
def test_empty_trials_that_repeat_are_refused(made):
    """Hard links to steps without a mesh ask for no numbers, and end as well."""

    def repeat(file):
        for number in range(300):
            file[f"trial_5/step_{number}"] = file.require_group("empty")
        for number in range(6, 300):
            file[f"trial_{number}"] = file["trial_5"]

    with pytest.raises(UnsafeContent, match="seems to hold more groups"):
        made.spoil(repeat).read()


def test_circles_of_groups_end(made):
    """Groups that contain themselves are read as deep as the layout goes."""

    def circle(file):
        file[f"{NODES}/env_7"] = file["trial_0"]
        file["trial_0/step_9"] = file["trial_0"]
        file["trial_8"] = file["/"]

    recording, _ = made.spoil(circle).read()
    assert {"value-missing", "trajectory-empty"} <= codes(recording)
    assert len(recording.trajectories) == 3


def test_numbers_that_were_never_written_are_counted(made):
    """Meshes of 200,000 vertices without stored data fill no disk: a small file holds no gigabyte."""

    def declare(file):
        for number in range(3, 60):
            place = f"trial_0/step_{number}/nodal_coords_digit/env_0"
            file.create_dataset(place, shape=(200_000, 3), dtype="f4", chunks=(200_000, 3))

    with pytest.raises(UnsafeContent, match="seems to hold more numbers"):
        made.spoil(declare).read()


@pytest.mark.slow
def test_chunks_that_unpack_to_more_than_they_hold(made):
    """A deflated chunk of 12 x 20 bytes of numbers that unpacks to 300 MB is not unpacked, and told."""
    bomb = zlib.compress(bytes(300_000_000), 9)
    place = f"{NODES}/env_0"

    def write(length):
        def change(file):
            del file[place]
            dataset = file.create_dataset(place, shape=(20, 3), dtype="f4", chunks=(20, 3), compression="gzip")
            dataset.id.write_direct_chunk((0, 0), bomb if length is None else zlib.compress(bytes(length), 9))

        return change

    messages = [f.message for f in made.spoil(write(None)).read()[0].findings if f.severity == "damage"]
    assert len(messages) == 1
    assert "bytes for 240 bytes of numbers" in messages[0]
    messages = [f.message for f in made.spoil(write(3_000_000)).read()[0].findings if f.severity == "damage"]
    assert len(messages) == 1
    assert "unpacks to more than its 240 bytes" in messages[0]


@pytest.mark.parametrize("filters", [(1, 1), (1, 32000)])
def test_chunks_packed_twice_are_not_read(made, filters):
    """Two packings multiply what a chunk may unpack to."""

    def change(file):
        plan = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        plan.set_chunk((20, 3))
        for number in filters:
            plan.set_filter(number, h5py.h5z.FLAG_OPTIONAL, (9,))
        space = h5py.h5s.create_simple((20, 3))
        del file[f"{NODES}/env_0"]
        h5py.h5d.create(file[NODES].id, b"env_0", h5py.h5t.IEEE_F32LE, space, plan)

    messages = [f.message for f in made.spoil(change).read()[0].findings if f.severity == "damage"]
    assert len(messages) == 1
    assert "packed more than once" in messages[0]


@pytest.mark.parametrize(
    "place", ["trial_0", "trial_0/step_0", "trial_0/step_1", NODES, NODES.replace("step_1", "step_0")]
)
@pytest.mark.parametrize("shape", [(4, 3), (10**12, 3)], ids=["small", "huge"])
def test_data_sets_in_the_place_of_groups(made, place, shape):
    """A data set where a group belongs, however large it claims to be, is a group without members."""
    made.replaced(place, shape=shape, dtype="f4", chunks=(2, 3))
    if place == "trial_0":
        with pytest.raises(BrokenLog, match="nothing to read"):
            made.read()
        return
    recording, _ = made.read()
    assert "value-missing" in codes(recording)
    assert len(recording.trajectories) == 2


def test_names_that_are_none(made):
    """Names that are no text, numbers of 5000 digits and names of 60,000 letters are left out, shortly."""

    def change(file):
        file.copy("trial_0", "trial_" + "9" * 5000)
        for place, name in (("/", b"trial_\xff"), ("trial_0", b"step_\xff\xfe"), (NODES, b"env_\xff")):
            file[place].create_group(name)
        file["trial_0/step_0"].create_group("x" * 60_000)
        for number in range(100):
            file["trial_0/step_0"].create_group(f"other_{number}")

    recording, sink = made.spoil(change).read()
    assert len(sink.images) == 6
    (said,) = [finding.message for finding in recording.findings if finding.code == "not-read"]
    assert said == "other_0, other_1, other_10 and 98 more in steps: not read"


@pytest.mark.parametrize("name", ["a\nb\x1b[31m", "z" * 4000])
def test_sensors_that_are_no_names(made, name, tmp_path, capsys):
    """The sensor's name comes from the file: one that is none is refused by ingest in one short line."""

    def rename(file):
        for step in range(3):
            for kind in ("nodal_coords_", "net_force_vecs_"):
                file[f"trial_0/step_{step}"].move(f"{kind}digit", f"{kind}{name}")

    made.spoil(rename)
    code, out, err = run_command(capsys, "ingest", made.path, "--store", tmp_path / "x.zarr")
    assert code == 1
    assert "does not fit schema 'log': at $.sensors" in out
    assert "\x1b" not in out + err
    assert max(map(len, (out + err).splitlines())) < 2000


def test_small_limits_are_held(made, monkeypatch):
    """The limits at their borders: as many bytes and members as are allowed are read, one less is too much."""
    size = made.path.stat().st_size
    with open_hdf5(made.path) as members:
        group = members.group(members.group(members.group(members.root, "trial_0"), "step_1"), "nodal_coords_digit")
        monkeypatch.setattr(hdf5_members, "MOST_GROWN", 0)
        monkeypatch.setattr(hdf5_members, "FREE_BYTES", 480)
        assert members.numbers(group, "env_0", 60).shape == (20, 3)
        with pytest.raises(ValueError, match="of shape"):
            members.numbers(group, "env_1", 59)
        with pytest.raises(UnsafeContent, match="more numbers"):
            members.numbers(group, "env_1", 60)
    monkeypatch.setattr(hdf5_members, "MEMBER_BYTES", size)
    with open_hdf5(made.path) as members:
        assert members.group(members.group(members.root, "trial_0"), "step_1") is not None
        assert members.group(members.root, "nothing") is None
        with pytest.raises(UnsafeContent, match="more groups"):
            members.group(members.root, "trial_0")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_flipped_bytes_end_in_words(made, seed):
    """Some bytes of the file changed, or its end cut: it is read, or refused by one of three errors of ours."""
    rng = np.random.default_rng(seed)
    content = made.path.read_bytes()
    for _ in range(40):
        spoilt = bytearray(content)
        for place in rng.integers(0, len(content), rng.integers(1, 6)):
            spoilt[place] = rng.integers(256)
        made.path.write_bytes(bytes(spoilt[: rng.integers(1, len(spoilt)) if rng.random() < 0.2 else None]))
        with suppress(BrokenLog, UnsafeContent, SchemaError):
            made.read()
