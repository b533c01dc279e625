"""The PyTorch dataset: what was stored as tensors, the same from any workers, resumable, parted between ranks."""

import itertools
import json
import os
import pickle
import socket

import loader_stores as made
import numpy as np
import pytest

torch = pytest.importorskip("torch")

from torch.utils.data import DataLoader  # noqa: E402

from tactiledata.errors import MissingSplit, StoreError, UsageError  # noqa: E402
from tactiledata.loaders.numpy import TactileArrays  # noqa: E402
from tactiledata.loaders.torch import ResumableSampler, TactileDataset, TactileLoader, collate  # noqa: E402

STREAMS = ("digit", "wrench", "background", "centre")


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A store of raw frames, whose reading is the more delicate across forks, with a split."""
    folder = tmp_path_factory.mktemp("torch") / "ds.zarr"
    made.split_store(folder, encoding="raw", damaged=(1, 2, 9))
    return folder


def assert_same(one, other):
    """Two items or batches hold the same."""
    assert one.keys() == other.keys()
    for name, value in one.items():
        if isinstance(value, torch.Tensor):
            assert value.dtype == other[name].dtype
            torch.testing.assert_close(value, other[name], rtol=0, atol=0, equal_nan=True)
        else:
            assert value == other[name]


def negated(item):
    """A transform that can be pickled."""
    return {**item, "wrench": -item["wrench"]}


@pytest.mark.slow
def test_tensors_are_the_arrays(place):
    """Pictures are channels first and in [0, 1], or bytes; all else is what the arrays hold."""
    arrays = TactileArrays(place, "default/train", STREAMS)
    dataset = TactileDataset(place, "default/train", STREAMS)
    bytes_ = TactileDataset(place, "default/train", STREAMS, image_dtype="uint8")
    item, expected = dataset[3], arrays[3]
    assert item["digit"].shape == (3, made.HEIGHT, made.WIDTH)
    assert item["digit"].is_contiguous()
    torch.testing.assert_close(item["digit"], bytes_[3]["digit"] / 255)
    for name in ("digit", "background"):
        np.testing.assert_array_equal(item[name].permute(1, 2, 0).numpy(), expected[name])
    for name in ("wrench", "centre"):
        assert item[name].dtype == torch.float32
        np.testing.assert_array_equal(item[name].numpy(), expected[name])
    assert [item[name] for name in ("sensor", "indenter", "trajectory")] == [
        expected[name] for name in ("sensor", "indenter", "trajectory")
    ]
    assert (int(item["frame"]), int(item["t_ns"])) == (expected["frame"], expected["t_ns"])
    assert_same(dataset[-1], dataset[len(dataset) - 1])
    with pytest.raises(IndexError):
        dataset[len(dataset)]


def test_a_missing_split_is_an_error(place):
    """Nobody gets data without saying which part of which split."""
    with pytest.raises(MissingSplit, match="tactiledata split"):
        TactileDataset(place)
    with pytest.raises(UsageError, match="allow_leaks"):
        TactileDataset(place, "all")


@pytest.mark.slow
@pytest.mark.parametrize("unit", ["frame", "trajectory"])
def test_workers_change_nothing(place, unit):
    """0, 1 and 2 forked workers give the same batches, also after the parent has read from the store."""
    dataset = TactileDataset(place, "default/train", STREAMS, unit=unit, normalise=True, missing="keep")
    _ = dataset[0]
    batches = [
        list(DataLoader(dataset, batch_size=4, num_workers=n, collate_fn=collate, multiprocessing_context=context))
        for n, context in ((0, None), (1, "fork"), (2, "fork"))
    ]
    for several in batches[1:]:
        assert len(several) == len(batches[0])
        for one, other in zip(batches[0], several, strict=True):
            assert_same(one, other)
    assert_same(dataset[0], batches_first(batches[0][0], unit, dataset))


def batches_first(batch, unit, dataset):
    """The first item of a batch, its padding cut off."""
    if unit == "frame":
        return {name: value[0] for name, value in batch.items()}
    cut = {}
    for name in dataset[0]:
        group = next((group for group in ("wrench",) if name in (group, group + "_t_ns")), "frames")
        value = batch[name][0]
        keeps = not isinstance(value, torch.Tensor) or name == "background"
        cut[name] = value if keeps else value[: batch[f"{group}_lengths"][0]]
    return cut


@pytest.mark.slow
def test_spawned_workers_change_nothing(place):
    """Spawned workers, which get the dataset pickled, give the same batches."""
    dataset = TactileDataset(place, "default/train", STREAMS, transform=negated)
    here = list(TactileLoader(dataset, 8, seed=3))
    there = list(TactileLoader(dataset, 8, seed=3, num_workers=2, multiprocessing_context="spawn"))
    for one, other in zip(here, there, strict=True):
        assert_same(one, other)


def test_one_store_call_a_batch(place, monkeypatch):
    """A batch is read with one call for its pictures, whatever its size."""
    dataset = TactileDataset(place, "default/train", "digit")
    calls = []
    images = type(dataset.arrays.store).images
    monkeypatch.setattr(
        type(dataset.arrays.store),
        "images",
        lambda self, rows, **options: calls.append(rows) or images(self, rows, **options),
    )
    next(iter(DataLoader(dataset, batch_size=16)))
    assert [len(rows) for rows in calls] == [16]


@pytest.mark.slow
def test_collating_frames_is_stacking(place):
    """The quick way of `collate` gives what torch's own collate gives."""
    dataset = TactileDataset(place, "default/train", STREAMS)
    items = dataset.__getitems__([0, 7, 2])
    quick, slow = collate(items), torch.utils.data.default_collate(list(items))
    assert_same(quick, slow)
    assert_same(quick, collate(list(items)))


def test_trajectories_are_padded_and_masked(place):
    """Padding is zero and masked; under the mask stands exactly each item."""
    dataset = TactileDataset(place, "default/train", STREAMS, unit="trajectory", missing="keep")
    items = dataset.__getitems__(range(len(dataset)))
    batch = collate(items)
    assert len(set(batch["wrench_lengths"].tolist())) > 2
    for name, group in (("digit", "frames"), ("centre", "frames"), ("wrench", "wrench"), ("wrench_t_ns", "wrench")):
        lengths, mask = batch[f"{group}_lengths"], batch[f"{group}_mask"]
        assert lengths.tolist() == [len(item[name]) for item in items]
        assert mask.sum(1).tolist() == lengths.tolist()
        for place_, item in enumerate(items):
            assert torch.equal(batch[name][place_][mask[place_]], item[name])
            assert not batch[name][place_][~mask[place_]].any()
    assert batch["background"].shape == (len(items), 3, made.HEIGHT, made.WIDTH)


def test_transforms_come_last(place):
    """A transform sees each item and what it returns is batched."""
    plain, other = (TactileDataset(place, "default/val", "wrench", transform=one) for one in (None, negated))
    batch = collate(other.__getitems__([0, 1]))
    torch.testing.assert_close(batch["wrench"], -torch.stack([plain[0]["wrench"], plain[1]["wrench"]]))


def test_pickled_it_is_the_same(place):
    """A dataset travels to other processes and gives the same there."""
    dataset = TactileDataset(place, "default/train", STREAMS, normalise=("digit", "wrench"))
    assert_same(pickle.loads(pickle.dumps(dataset))[5], dataset[5])
    assert abs(float(collate(dataset.__getitems__(range(len(dataset))))["digit"].mean())) < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("num_workers", [0, 2])
def test_interrupted_and_resumed_training_sees_the_same(place, num_workers):
    """Killed at any batch and resumed from the loader's state, two epochs are those of an uninterrupted run."""
    dataset = TactileDataset(place, "default/train", "centre")

    def loader():
        return TactileLoader(dataset, 8, seed=5, num_workers=num_workers)

    def frames(batches):
        return [batch["frame"].tolist() for batch in batches]

    whole = loader()
    uninterrupted = [frames(whole), frames(whole)]
    assert uninterrupted[0] != uninterrupted[1]
    n = len(uninterrupted[0])
    for stop in (0, 1, n - 1, n, n + 2) if num_workers == 0 else (2,):
        walker = loader()
        seen = frames(itertools.islice((batch for _ in range(2) for batch in walker), stop))
        resumed = loader()
        resumed.load_state_dict(json.loads(json.dumps(walker.state_dict())))
        rest = [step for _ in range(resumed.epoch, 2) for step in frames(resumed)]
        assert seen + rest == uninterrupted[0] + uninterrupted[1]


def test_an_epoch_goes_on_with_other_batches(place):
    """Resumed in the middle with another batch size and with workers, the rest of the epoch is that of the order."""
    dataset = TactileDataset(place, "default/train", "centre")
    whole = [frame for batch in TactileLoader(dataset, 4, seed=1) for frame in batch["frame"].tolist()]
    begun = TactileLoader(dataset, 4, seed=1)
    seen = [frame for batch in itertools.islice(begun, 3) for frame in batch["frame"].tolist()]
    resumed = TactileLoader(dataset, 7, seed=1, num_workers=1)
    resumed.load_state_dict(begun.state_dict())
    rest = [frame for batch in resumed for frame in batch["frame"].tolist()]
    assert seen + rest == whole


@pytest.mark.parametrize("num_workers", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_an_image_damaged_in_the_middle_of_an_epoch_is_named(tmp_path, num_workers):
    """Bytes that turn bad after the dataset was made end the epoch with the frame's number, not with other pixels."""
    folder = tmp_path / "ds.zarr"
    made.split_store(folder, encoding="jpeg")
    dataset = TactileDataset(folder, "default/train", "digit")
    row = int(dataset.arrays.index.rows[-1])
    facts = dataset.arrays.store.frames(["offset", "length"]).slice(row, 1).to_pylist()[0]
    batches = iter(TactileLoader(dataset, 4, shuffle=False, num_workers=num_workers))
    next(batches)
    with (folder / "streams" / "digit" / "heap" / "c.0").open("r+b") as heap:
        heap.seek(facts["offset"] + facts["length"] // 2)
        byte = heap.read(1)
        heap.seek(-1, os.SEEK_CUR)
        heap.write(bytes([byte[0] ^ 0xFF]))
    with pytest.raises(StoreError, match=f"^the image of frame {row} ") as caught:
        list(batches)
    assert "Traceback" not in str(caught.value)


def test_items_are_asked_for_by_whole_numbers(place):
    """Halves, words, numbers beyond the end and empty batches are refused."""
    dataset = TactileDataset(place, "default/train", "centre")
    for number in (1.5, "a", None):
        with pytest.raises(TypeError):
            dataset[number]
    with pytest.raises(IndexError, match=f"of {len(dataset)}"):
        dataset[len(dataset)]
    with pytest.raises(UsageError, match="no items"):
        dataset.__getitems__([])
    assert dataset[np.int64(-1)]["frame"] == dataset[len(dataset) - 1]["frame"]


def test_the_sampler_serves_a_plain_loader(place):
    """`ResumableSampler` works as sampler and as batch sampler of a `DataLoader`, and refuses another part's state."""
    dataset = TactileDataset(place, "default/train", "centre")
    singles = DataLoader(dataset, batch_size=4, sampler=ResumableSampler(dataset, seed=1), collate_fn=collate)
    batches = DataLoader(dataset, batch_sampler=ResumableSampler(dataset, seed=1, batch_size=4), collate_fn=collate)
    assert len(batches) == len(singles)
    for one, other in zip(singles, batches, strict=True):
        assert_same(one, other)
    sampler = ResumableSampler(dataset, seed=1)
    with pytest.raises(UsageError, match="does not belong"):
        ResumableSampler(TactileDataset(place, "default/val", "centre"), seed=1).load_state_dict(sampler.state_dict())
    sampler.set_epoch(4)
    assert sampler.state_dict()["epoch"] == 4


def _rank(rank, port, place, results):
    torch.distributed.init_process_group("gloo", f"tcp://127.0.0.1:{port}", rank=rank, world_size=2)
    try:
        dataset = TactileDataset(place, "default/train", "centre")
        loader = TactileLoader(dataset, 4, seed=2)
        seen = []
        for batch in loader:
            seen += batch["frame"].tolist()
            total = batch["centre"].sum().clone()
            torch.distributed.all_reduce(total)  # waits for the other rank: unequal numbers of steps would hang
        results.put((rank, seen, loader.state_dict()))
    finally:
        torch.distributed.destroy_process_group()


@pytest.mark.slow
def test_two_processes_part_the_data(place):
    """Two gloo ranks take equal numbers of steps, share no frame, and leave the same state."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    context = torch.multiprocessing.get_context("spawn")
    results = context.Queue()
    ranks = [context.Process(target=_rank, args=(rank, port, place, results)) for rank in range(2)]
    for process in ranks:
        process.start()
    answers = sorted((results.get(timeout=120) for _ in ranks), key=lambda answer: answer[0])
    for process in ranks:
        process.join()
    (_, first, state), (_, second, other_state) = answers
    everything = TactileDataset(place, "default/train", "centre").arrays.index.rows.tolist()
    assert len(first) == len(second)
    assert not set(first) & set(second)
    assert set(first) | set(second) <= set(everything)
    assert len(everything) - len(first) - len(second) < 8
    assert state == other_state
