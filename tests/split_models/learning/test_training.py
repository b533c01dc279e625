"""The loop learns, stops, goes on where it was killed, and says at once what it cannot learn from."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from learner import STAMPS, items, learn, objective

from split_models.learning.checkpoint import Checkpoint, TrainedOn, load_checkpoint, save_checkpoint
from split_models.learning.device import find_device
from split_models.learning.items import TensorItems
from split_models.learning.objectives import Regression
from split_models.learning.train import train
from split_models.learning.train_options import TrainOptions
from split_models.networks.projection import Projection
from tactiledata.errors import CheckpointError, MissingFile, NotFinite, UnknownName, UsageError

LEARNER = Path(__file__).parents[1] / "learner.py"


def losses(trained):
    return [(row["train_loss"], row["val_loss"]) for row in trained.rows]


def environment(**more):
    root = LEARNER.resolve().parents[2]
    return {**os.environ, "PYTHONPATH": f"{root}{os.pathsep}{LEARNER.parent}", "OMP_NUM_THREADS": "1", **more}


@pytest.mark.slow
def test_it_learns_and_writes_its_curve(tmp_path):
    """Loss falls; curve.csv and curve.json hold a row an epoch; the learning rate decays by its factor."""
    trained = learn(tmp_path, epochs=12)
    assert trained.rows[-1]["train_loss"] < 0.5 * trained.rows[0]["train_loss"]
    with (tmp_path / "curve.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["train_loss"]) for row in rows] == [row["train_loss"] for row in trained.rows]
    assert json.loads((tmp_path / "curve.json").read_text()) == trained.rows
    assert trained.rows[3]["learning_rate"] == pytest.approx(0.01 * 0.99**3)
    assert trained.best_epoch == min(range(12), key=lambda epoch: trained.rows[epoch]["val_loss"])


@pytest.mark.slow
def test_one_cycle_of_the_learning_rate(tmp_path):
    """Up over the first tenth of all epochs and down again to the end, step by step; a decay holds for an epoch."""
    once = TrainOptions(20, 8, learning_rate=0.01, schedule="one_cycle")
    rates = [once.rate_at(epoch) for epoch in np.linspace(0.0, 20.0, 201)]
    assert rates[0] == rates[-1] == pytest.approx(0.01 * 0.01)
    assert max(rates) == rates[20] == pytest.approx(0.01)
    assert (np.diff(rates[:21]) > 0).all()
    assert (np.diff(rates[20:]) < 0).all()
    assert TrainOptions(20, 8, decay=0.5).rate_at(1.9) == TrainOptions(20, 8, decay=0.5).rate_at(1.0) == 0.5e-3
    trained = learn(tmp_path, epochs=12, schedule="one_cycle")
    assert trained.rows[-1]["train_loss"] < 0.5 * trained.rows[0]["train_loss"]
    assert trained.rows[-1]["learning_rate"] < 0.2 * trained.rows[2]["learning_rate"]


@pytest.mark.slow
@pytest.mark.parametrize("pieces", [2, 3, 8, 50])
def test_a_batch_in_pieces_teaches_what_it_teaches_whole(tmp_path, pieces):
    """Losses and weights are the same to rounding, also where pieces differ in size; each piece is as small as said."""
    seen = []
    learner = objective(dropout=())
    learner.register_forward_pre_hook(
        lambda module, given: seen.append(len(given[0]["given"])) if module.training else None
    )
    whole = learn(tmp_path / "whole", dropout=())
    parted = learn(tmp_path / "parted", objective=learner, accumulate=pieces)
    np.testing.assert_allclose(losses(parted), losses(whole), rtol=1e-4)
    for one, other in zip(parted.network.parameters(), whole.network.parameters(), strict=True):
        torch.testing.assert_close(one, other, rtol=1e-3, atol=1e-5)
    assert max(seen) == -(-8 // min(pieces, 8))


def test_pieces_shape_a_model_and_one_piece_is_as_before():
    """The options that name a model's folder have pieces where there are several, and never the time between files."""
    plain = TrainOptions(3, 8)
    assert "accumulate" not in plain.shaping
    assert replace(plain, save_seconds=5.0).shaping == plain.shaping
    assert replace(plain, accumulate=2).shaping == {**plain.shaping, "accumulate": 2}


class Stop(Exception):
    """What a test interrupts with."""


def test_interrupted_it_ends_with_the_same_losses(tmp_path):
    """After an epoch and within one; with dropout, whose draws depend on seed, epoch and step alone."""
    whole = learn(tmp_path / "whole")

    def stop(done, total, what):
        if done == 2:
            raise Stop

    with pytest.raises(Stop):
        learn(tmp_path / "parted", tell=stop)
    assert losses(learn(tmp_path / "parted")) == losses(whole)

    class Torn(TensorItems):
        reads = 0

        def batch(self, numbers):
            self.reads += 1
            if self.reads == 10:
                raise Stop
            return super().batch(numbers)

    torn = items()
    torn = Torn(torn.tensors, torn.fingerprint)
    with pytest.raises(Stop):
        learn(tmp_path / "torn", items=torn, save_seconds=0.0)
    progress = load_checkpoint(tmp_path / "torn" / "last.pt").progress
    assert progress["order"]["consumed"] not in (0, 48)
    assert losses(learn(tmp_path / "torn")) == losses(whole)


@pytest.mark.slow
def test_killed_it_ends_with_the_same_losses(tmp_path):
    """A process that dies by SIGKILL and the same call again end with the same losses."""
    command = [sys.executable, str(LEARNER)]
    whole = subprocess.run(
        [*command, str(tmp_path / "whole"), "0", "0.2"], capture_output=True, check=True, env=environment()
    )
    folder = tmp_path / "killed"
    process = subprocess.Popen([*command, str(folder), "0.15", "0.2"], env=environment(), stdout=subprocess.DEVNULL)
    deadline = time.monotonic() + 120
    while time.monotonic() < deadline:
        time.sleep(0.05)
        if (folder / "last.pt").exists() and load_checkpoint(folder / "last.pt").progress["rows"]:
            break
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert not load_checkpoint(folder / "last.pt").progress["is_over"]
    again = subprocess.run([*command, str(folder), "0", "0.2"], capture_output=True, check=True, env=environment())
    assert json.loads(again.stdout) == json.loads(whole.stdout)


@pytest.mark.slow
def test_two_processes_learn_what_one_learns(tmp_path):
    """Two gloo processes under torchrun have the losses of one process, but for the last digits."""
    alone = subprocess.run(
        [sys.executable, str(LEARNER), str(tmp_path / "one"), "0", "0"],
        capture_output=True, check=True, env=environment(),
    )  # fmt: skip
    together = subprocess.run(
        [sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc-per-node", "2", str(LEARNER),
         str(tmp_path / "two"), "0", "0"],
        capture_output=True, check=True, env=environment(), timeout=300,
    )  # fmt: skip
    printed = [json.loads(line) for line in together.stdout.decode().splitlines() if line.startswith("[")]
    assert printed
    for line in printed:
        assert line == pytest.approx(json.loads(alone.stdout), rel=1e-4)


def test_it_stops_when_it_no_longer_gets_better(tmp_path):
    """Patience counts from the end of annealing; the best epoch's weights are what comes out."""

    class Frozen(Regression):
        def forward(self, batch, epoch):
            found = super().forward(batch, epoch)
            return {"loss": found["loss"] * 0.0 + 1.0}

    frozen = Frozen(Projection(6, 3, (8, 3), ()), "given", "target")
    options = TrainOptions(epochs=50, batch_size=16, patience=2, settle=3)
    trained = train(frozen, items(), items(16, 1), options, tmp_path, STAMPS, torch.device("cpu"))
    assert [row["epoch"] for row in trained.rows] == [0, 1, 2, 3, 4, 5]
    assert trained.best_epoch == 0


def test_nan_is_named_at_once(tmp_path):
    """The item that holds it, before any step is taken with it; likewise a loss that is none."""
    bad = items()
    bad.tensors["given"][7, 2] = float("nan")
    with pytest.raises(NotFinite, match="'given' of item 7"):
        learn(tmp_path / "batch", items=bad)

    class Broken(Regression):
        def forward(self, batch, epoch):
            return {"loss": super().forward(batch, epoch)["loss"] * float("inf")}

    with pytest.raises(NotFinite, match="the loss of the projection became inf in epoch 0"):
        learn(tmp_path / "loss", objective=Broken(Projection(6, 3, (8, 3), ()), "given", "target"))
    spoilt = items(16, 1)
    spoilt.tensors["target"][0] = float("nan")
    with pytest.raises(NotFinite, match="validation loss"):
        train(objective(), items(), spoilt, TrainOptions(1, 8), tmp_path / "val", STAMPS, torch.device("cpu"))


def test_weights_of_other_data_are_not_gone_on_with(tmp_path):
    """Another recipe, split, frames or topology is refused by name."""
    learn(tmp_path, epochs=1)
    for name in ("recipe", "split", "items", "topology"):
        with pytest.raises(CheckpointError, match="another state of") as caught:
            learn(tmp_path, stamps=TrainedOn(**{**vars(STAMPS), name: "other"}))
        assert caught.value.facts["differing"] == [name]


def test_a_finished_training_is_read(tmp_path):
    """The second call learns nothing and gives the same weights."""
    first = learn(tmp_path, epochs=2)
    second = learn(tmp_path, epochs=2, items=items(pause=100.0))
    state = second.network.state_dict()
    assert all(torch.equal(values, state[name]) for name, values in first.network.state_dict().items())


def test_saved_and_loaded_it_gives_the_same(tmp_path):
    """A model that was saved and loaded gives the same bit by bit, and has its settings."""
    network = objective().network.eval()
    save_checkpoint(tmp_path / "a.pt", Checkpoint.of(network, STAMPS))
    kept = load_checkpoint(tmp_path / "a.pt")
    given = torch.randn(4, 6)
    assert torch.equal(kept.network()(given), network(given))
    assert kept.stamps == STAMPS
    assert kept.network().settings == network.settings


def test_what_is_no_checkpoint_is_refused(tmp_path):
    """Missing, empty, torn, of another program; code in it is not run."""
    with pytest.raises(MissingFile, match="Train first"):
        load_checkpoint(tmp_path / "none.pt")
    good = tmp_path / "good.pt"
    save_checkpoint(good, Checkpoint.of(objective().network, STAMPS))
    (tmp_path / "empty.pt").touch()
    (tmp_path / "torn.pt").write_bytes(good.read_bytes()[:-500])
    torch.save({"weights": {}}, tmp_path / "other.pt")
    torch.save(Path("code"), tmp_path / "code.pt")
    for name in ("empty", "torn", "other", "code"):
        with pytest.raises(CheckpointError, match="cannot be read as a checkpoint"):
            load_checkpoint(tmp_path / f"{name}.pt")
    other = Checkpoint("projection", {"inputs": 6, "outputs": 4}, STAMPS, "", objective().network.state_dict(), {})
    with pytest.raises(CheckpointError, match="do not fit its settings"):
        other.network()


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_weights_that_are_no_numbers_are_refused(value):
    """One weight of NaN or infinity makes every picture one: the network is not made, and the weights are named."""
    checkpoint = Checkpoint.of(objective().network, STAMPS)
    name = next(iter(checkpoint.weights))
    checkpoint.weights[name].reshape(-1)[0] = value
    with pytest.raises(CheckpointError, match=f"weights {name} of the projection hold NaN or infinity"):
        checkpoint.network()


def test_a_device_that_is_not_there_is_refused():
    """Before anything else; the message says why."""
    assert find_device("cpu").type == "cpu"
    with pytest.raises(UnknownName, match="unknown device 'gpu'"):
        find_device("gpu")
    if not torch.cuda.is_available():
        with pytest.raises(UsageError, match="--device cuda, and"):
            find_device("cuda")


def test_nothing_to_learn_from_is_said(tmp_path):
    """No items is wrong usage, not an empty curve."""
    with pytest.raises(UsageError, match="nothing to validate"):
        train(objective(), items(), items(0), TrainOptions(1, 8), tmp_path, STAMPS, torch.device("cpu"))
