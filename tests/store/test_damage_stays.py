"""No command carries damage of a store into what it writes: it would get checksums that fit."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from copied_trees import copy_tree
from random_takes import SMALL, random_images, staged_take

from tactiledata.errors import StoreError, TactileDataError
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.replay.attach import replay
from tactiledata.replay.options import ReplayOptions
from tactiledata.store.change.merge import merge
from tactiledata.store.change.pieces import Origin, pieces_of
from tactiledata.store.change.replace import replace_takes
from tactiledata.store.check.check import check
from tactiledata.store.layout.sensors_table import image_crc
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit, create

Damage = Callable[[Path], None]


def edited(path: str, old: bytes, new: bytes) -> Damage:
    """Damage that changes some bytes of a document."""

    def damage(folder: Path) -> None:
        content = (folder / path).read_bytes()
        assert old in content
        (folder / path).write_bytes(content.replace(old, new))

    return damage


def lost(array: str) -> Damage:
    """Damage by which the first chunk of an array is gone: it reads as numbers that nobody recorded."""

    def damage(folder: Path) -> None:
        min(place for place in (folder / array).iterdir() if place.name.startswith("c.")).unlink()

    return damage


def turned(array: str) -> Damage:
    """Damage by which a byte of the first chunk is another."""

    def damage(folder: Path) -> None:
        place = min(place for place in (folder / array).iterdir() if place.name.startswith("c."))
        content = bytearray(place.read_bytes())
        content[len(content) // 2] ^= 1
        place.write_bytes(content)

    return damage


DAMAGES = {
    "a fact of a sensor": edited("sensors.json", b'"digit"', b'"tigid"'),
    "sensors that are gone": lambda folder: (folder / "sensors.json").unlink(),
    "origin of a picture": edited("reference/D1/image/zarr.json", b"planted", b"painted"),
    "attributes of a signal": edited("signals/wrench/value/zarr.json", b'"units"', b'"unitz"'),
    "a picture that is gone": lost("reference/D1/image"),
    "a picture that was changed": turned("reference/D1/image"),
    "a chunk of a signal": lost("signals/wrench/value"),
    "a chunk of stamps": lost("signals/wrench/log_ns"),
    "a chunk of aligned values": lost("aligned/wrench/value"),
    "a chunk of frame values": lost("frame_values/centre/value"),
    "a byte of a signal": turned("signals/wrench/value"),
}

WITHOUT_PICTURE, WITH_PICTURE = 12, 11
"""Seeds of a random take that brings no picture without contact, and of one that brings that of D1."""
NEED_DIGESTS = ("origin of a picture", "attributes of a signal")
"""Damages that a store which was written before documents had digests cannot tell."""


@pytest.fixture(scope="module")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store with every kind of content."""
    folder = tmp_path_factory.mktemp("damage") / "healthy"
    create(folder, SMALL)
    rng = np.random.default_rng(0)
    commit(folder, [staged_take(folder, seed, images=random_images(rng, 8))[0] for seed in range(3)])
    assert Store.open(folder).frame_value_names
    return folder


@pytest.fixture
def folder(healthy: Path, tmp_path: Path) -> Path:
    """A copy to damage."""
    return copy_tree(healthy, tmp_path / "ds.zarr")


@pytest.mark.parametrize(
    ("damage", "with_digests"),
    [(damage, True) for damage in DAMAGES] + [(damage, False) for damage in DAMAGES if damage not in NEED_DIGESTS],
)
def test_merge_refuses_what_check_calls_damage(folder: Path, damage: str, with_digests: bool) -> None:
    """No damage of documents or numbers comes into a merged store, nor in one that was written without digests."""
    if not with_digests:
        without_digests(folder)
    DAMAGES[damage](folder)
    assert any(found.severity == "damage" for found in check(folder))
    new = folder.parent / "new.zarr"
    with pytest.raises(TactileDataError, match=r"damaged|missing|does not hold"):
        merge([folder], new)
    assert not new.exists() or Store.open(new).n_frames == 0


def without_digests(folder: Path) -> None:
    """The store as it was written before there were digests of documents."""
    document = json.loads((folder / "manifest.json").read_text())
    document.pop("file_sha256")
    document.pop("documents")
    (folder / "manifest.json").write_text(json.dumps(document, sort_keys=True, indent=2, ensure_ascii=False) + "\n")


@pytest.mark.parametrize("damage", DAMAGES)
def test_replace_refuses_damage_of_what_stays(folder: Path, damage: str) -> None:
    """A store whose documents, or numbers that stay, are damaged is left as it is."""
    DAMAGES[damage](folder)
    before = (folder / "manifest.json").read_bytes()
    last = Store.open(folder).manifest["sources"][-1]
    with pytest.raises(TactileDataError, match=r"damaged|missing|does not hold"):
        replace_takes(folder, {last: staged_take(folder, WITHOUT_PICTURE)[0]})
    assert (folder / "manifest.json").read_bytes() == before


@pytest.mark.parametrize("damage", [name for name in DAMAGES if name.startswith("a picture")])
def test_a_damaged_picture_is_mended_by_a_recording_that_brings_one(folder: Path, damage: str) -> None:
    """A picture without contact that comes with what is put in a place stands for the damaged one of its sensor."""
    DAMAGES[damage](folder)
    store = Store.open(folder)
    taken = staged_take(folder, WITH_PICTURE)[1]
    assert "D1" in taken.references
    replace_takes(folder, {store.manifest["sources"][-1]: staged_take(folder, WITH_PICTURE)[0]})
    assert check(folder) == []
    assert np.array_equal(Store.open(folder).reference("D1").image, taken.references["D1"].image)


@pytest.mark.slow
def test_a_damaged_recording_may_be_replaced(folder: Path) -> None:
    """Numbers of the recording that goes may be lost: the way out of such damage stays open."""
    store = Store.open(folder)
    chunk = store.array("signals/wrench/value").chunks[0]
    spans = [(piece, piece.contents["signals"]["wrench"]["rows"]) for piece in pieces_of(Origin.of(store))]
    piece, index = next(
        (piece, -(-start // chunk)) for piece, (start, stop) in spans if (-(-start // chunk) + 1) * chunk <= stop
    )
    (folder / f"signals/wrench/value/c.{index}.0").unlink()
    with pytest.raises(StoreError, match="--replace"):
        merge([folder], folder.parent / "new.zarr")
    replace_takes(folder, {piece.facts["sha256"]: staged_take(folder, 11)[0]})
    assert check(folder) == []


@pytest.mark.parametrize("damage", [name for name in DAMAGES if name.endswith("signal") or "sensor" in name])
def test_replay_refuses_damage(folder: Path, damage: str) -> None:
    """Nothing is played by poses that nobody recorded, nor in a gel of another sensor."""
    DAMAGES[damage](folder)
    before = (folder / "manifest.json").read_bytes()
    with pytest.raises(TactileDataError, match=r"damaged|missing|does not hold"):
        replay(folder, ReplayOptions(material=GelMaterial(2e6, 0.4, 0.5)))
    assert (folder / "manifest.json").read_bytes() == before


@pytest.mark.slow
def test_a_whole_store_goes_on(folder: Path) -> None:
    """Negative control: without damage both succeed, and a picture is the one that was written."""
    merge([folder], folder.parent / "new.zarr")
    assert check(folder.parent / "new.zarr") == []
    replace_takes(folder, {Store.open(folder).manifest["sources"][-1]: staged_take(folder, 11)[0]})
    assert check(folder) == []
    store = Store.open(folder)
    assert image_crc(store.reference("D1").image) == store.manifest["references"]["D1"]
