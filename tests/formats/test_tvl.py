"""TVL: swapped folders are found by their pictures and only there; train and test of one sequence stay together."""

import json
from pathlib import Path

import numpy as np
import pytest
from generators import tvl
from generators.collect import codes, read

from tactiledata.contract.image_bytes import decode_rgb
from tactiledata.errors import BrokenLog, UnsafeContent
from tactiledata.formats.reading.modality import DECISION, look_of, votes_tactile
from tactiledata.formats.tvl import TvlFormat

FORMAT = TvlFormat()
BACKGROUNDS = Path(__file__).resolve().parents[2] / "tactiledata" / "sensors" / "digit_backgrounds"


def first(folder, settings=None, **faults):
    """The part hct/data1 of a fake."""
    return read(FORMAT, tvl.write(folder, np.random.default_rng(4), ssvtp=0, **(settings or {}), **faults) / "hct")[0]


def test_parts_and_pairs(tmp_path):
    """One source per part; every tactile image once, its photograph at the same moment, nominal clock said."""
    root = tvl.write(tmp_path, np.random.default_rng(4), parts=("data1", "data2"))
    taken = read(FORMAT, root)
    assert [recording.source.key for recording, _ in taken] == [
        "tvl_dataset/hct/data1",
        "tvl_dataset/hct/data2",
        "tvl_dataset/ssvtp",
    ]
    recording, sink = taken[0]
    assert len(sink.of("digit")) == len(sink.of("vision")) == 18
    assert [image.log_ns for image in sink.of("digit")] == [image.log_ns for image in sink.of("vision")]
    assert len(recording.trajectories) == 3
    assert "nominal-rate" in codes(recording)
    for image in sink.images:
        assert image.payload == (root / "hct/data1" / image.name).read_bytes()
    names = [image.name.rsplit("/")[-1].split("-")[0] for image in sink.of("digit")[:6]]
    assert names == ["0", "1", "2", "3", "4", "5"]


@pytest.mark.parametrize("above", range(4))
def test_all_parts_are_found_from_above(tmp_path, above):
    """From a folder above the corpus every part is found or none, which is then looked for further below.

    From one level above, the parts below ``hct`` were passed over without a word.
    """
    root = tvl.write(tmp_path / "a" / "b", np.random.default_rng(4), parts=("data1", "data2"))
    named = [root, *root.parents][above]
    found = {Path(source.path).name for source in FORMAT.sources(named)} if FORMAT.sniff(named) else set()
    assert found == ({"data1", "data2", "ssvtp"} if above <= 1 else set())


def test_published_split_is_undone_and_kept(tmp_path):
    """Sequences that train.csv and test.csv share are one trajectory; the published part stays as a value."""
    recording, sink = first(tmp_path)
    assert "published-split-leaks" in codes(recording)
    part = recording.frame_values["published_part"].values[:, 0]
    touch = np.array([image.trajectory for image in sink.images])
    for name in set(touch):
        assert {0.0, 1.0} <= set(part[(touch == name) & np.isfinite(part)])
    contact = recording.frame_values["in_contact"].values[:, 0]
    is_digit = np.array([image.camera == "digit" for image in sink.images])
    assert (contact[is_digit] == 0).sum() == 3
    captions = json.loads(recording.trajectories[0].extra["captions"])
    assert captions == ["smooth, soft, cool"]


def test_planted_swap_is_found_and_put_right(tmp_path):
    """Of three sequences the swapped one is reported and read the other way round; the others are not touched."""
    plain, sink_plain = first(tmp_path / "a")
    recording, sink = first(tmp_path / "b", {"swapped": (1,)})
    found = [finding for finding in recording.findings if finding.code == "modality-swapped"]
    assert [finding.trajectory for finding in found] == [recording.trajectories[1].name]
    assert [touch.extra.get("modality_swapped") for touch in recording.trajectories] == [None, 1, None]
    assert [(image.camera, image.payload) for image in sink.images] == [
        (image.camera, image.payload) for image in sink_plain.images
    ]
    assert "modality-swapped" not in codes(plain)


def test_a_swapped_first_sequence_gives_no_photograph_as_reference(tmp_path):
    """The reference picture is a touch even where the first sequence is swapped."""
    recording, _ = first(tmp_path, {"swapped": (0,)})
    (reference,) = recording.references.values()
    assert reference.shape == (320, 240, 3)
    assert look_of([reference]).colour_field > 0.2


def test_no_swap_is_seen_where_there_is_none():
    """Negative control: neither two sets of touches nor two sets of photographs are called swapped, in any draw."""
    rng = np.random.default_rng(0)
    for _ in range(8):
        touches = [look_of([tvl.touch_picture(rng, press) for press in (0.0, 1.0, 1.0)]) for _ in range(2)]
        photographs = [look_of([tvl.photograph(rng) for _ in range(3)]) for _ in range(2)]
        assert abs(votes_tactile(*touches)) < DECISION
        assert abs(votes_tactile(*photographs)) < DECISION
        assert votes_tactile(touches[0], photographs[0]) > DECISION
        assert votes_tactile(photographs[0], touches[0]) < -DECISION


def test_photographs_of_a_touch_s_size_are_still_told_apart():
    """The picture's size is one vote of four: photographs of 320 x 240 are told from touches too."""
    rng = np.random.default_rng(1)
    touches = look_of([tvl.touch_picture(rng, press) for press in (0.0, 1.0, 1.0)])
    photographs = look_of([tvl.photograph(rng, (240, 320)) for _ in range(3)])
    assert votes_tactile(touches, photographs) > DECISION


def test_real_digit_pictures_look_tactile():
    """Real DIGIT pictures of every unit are told from photographs."""
    rng = np.random.default_rng(2)
    photographs = look_of([tvl.photograph(rng, (240, 320)) for _ in range(3)])
    for path in sorted(BACKGROUNDS.glob("*.jpg")):
        assert votes_tactile(look_of([decode_rgb(path.read_bytes())]), photographs) > DECISION, path.name


def test_ssvtp_presses_stand_alone(tmp_path):
    """Each press is a trajectory; one that no table names is read from the folders with its caption."""
    recording, sink = read(FORMAT, tvl.write(tmp_path, np.random.default_rng(4)) / "ssvtp")[0]
    assert [touch.name for touch in recording.trajectories] == [f"image_{number}" for number in range(4)]
    assert len(sink.of("digit")) == len(sink.of("vision")) == 4
    assert {touch.extra["captions"] for touch in recording.trajectories} == {'["rough, fabric"]'}


def test_without_tables_the_lists_are_read(tmp_path):
    """Without CSVs contact.json gives the pairs, as the corpus' own loader does."""
    recording, sink = first(tmp_path, no_csv=True)
    assert len(sink.of("digit")) == 18
    assert "published-split-leaks" not in codes(recording)


@pytest.mark.parametrize("cell", ["tactile", "vision", "caption"])
def test_empty_cells_are_said(tmp_path, cell):
    """An empty cell is a finding; the rest of its row is kept."""
    recording, sink = first(tmp_path, empty_cell=cell)
    (found,) = [finding for finding in recording.findings if finding.code == "csv-cell-empty"]
    assert found.severity == "warning"
    missing = {finding.severity for finding in recording.findings if finding.code == "image-missing"}
    assert missing == ({"damage"} if cell == "tactile" else set())
    assert len(sink.of("vision")) >= 17
    if cell == "tactile":
        assert "missing" in {image.encoding for image in sink.of("digit")}


@pytest.mark.parametrize("name", ["../../../etc/passwd", "/etc/passwd", "C:\\secret.jpg", "a/../../../x.jpg"])
def test_paths_out_of_the_folder_are_refused(tmp_path, name):
    """A row that points outside is refused."""
    with pytest.raises(UnsafeContent):
        first(tmp_path, escape=name)


def test_links_out_of_the_folder_are_refused(tmp_path):
    """An image that is a link to a file outside is refused."""
    root = tvl.write(tmp_path / "corpus", np.random.default_rng(4))
    secret = tmp_path / "secret.jpg"
    secret.write_bytes(b"secret")
    image = next((root / "hct/data1").glob("*/tactile/3-*.jpg"))
    image.unlink()
    image.symlink_to(secret)
    with pytest.raises(UnsafeContent):
        read(FORMAT, root)


@pytest.mark.slow
def test_damage_is_said(tmp_path):
    """A missing image, lists of unequal length and a broken list are findings, and the rest is read."""
    recording, sink = first(tmp_path / "a", drop_image=True)
    assert "image-missing" in codes(recording)
    assert [image.encoding for image in sink.of("digit")].count("missing") == 1
    recording, _ = first(tmp_path / "b", short_list=True)
    assert "count-mismatch" in codes(recording)
    recording, sink = first(tmp_path / "c", broken_json=True)
    assert "list-broken" in codes(recording)
    assert len(sink.of("digit")) == 15


def test_a_table_without_rows_is_a_broken_log(tmp_path):
    """A part that names nothing is a clear error."""
    home = tmp_path / "data1"
    home.mkdir()
    (home / "train.csv").write_text("vision,tactile,background,caption\n")
    with pytest.raises(BrokenLog, match="nothing to read"):
        read(FORMAT, home)
