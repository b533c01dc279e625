"""The command `fine-tune`: an image VAE that learns another sensor's pictures."""

from __future__ import annotations

from pathlib import Path

import typer

from split_models.commands.device_option import DEVICE, require_device
from tactiledata.cli.explain import damage_explains
from tactiledata.cli.output import JSON_OPTION, emit, progress, say
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store
from tactiledata.contract.extras import need_packages
from tactiledata.errors import UsageError

MODEL = typer.Option(None, "--model", help="Checkpoint of the image VAE to start from [default: the bundled one].")
OUT = typer.Option(Path("fine-tuned"), "--out", help="Folder for checkpoints and the curve.")


def register(app: typer.Typer) -> None:
    """Add the command `fine-tune` to the application."""
    app.command("fine-tune")(fine_tune)


def fine_tune(
    store: str = STORE_ARGUMENT,
    model: Path = MODEL,
    split: str = typer.Option("default", "--split", help="Split whose parts train and val are used."),
    camera: str = typer.Option(None, "--camera", help="The stream of pictures [default: the store's only one]."),
    epochs: int = typer.Option(30, "--epochs", min=1, help="Number of passes over the part train."),
    learning_rate: float = typer.Option(3e-4, "--learning-rate", min=1e-8, max=1.0, help="Learning rate of Adam."),
    out: Path = OUT,
    device: str = DEVICE,
    as_json: bool = JSON_OPTION,
) -> None:
    """Train an image VAE further, on pictures of another sensor.

    Mesh VAE and projections are not changed.

    Example: tactiledata fine-tune gelsight.zarr --epochs 30
    """
    need_packages("fine-tuning", "torch")
    from split_models.learning.data import TouchFrames
    from split_models.learning.train_options import TrainOptions
    from split_models.transfer.fine_tune import fine_tune as learn
    from split_models.transfer.latent_transfer import load_image_vae
    from split_models.transfer.methods import model_file
    from tactiledata.store.read.reader import Store

    location = working_store(store)
    require_device(device)
    vae, digest, _ = load_image_vae(model_file(model, "fine-tune"))
    with damage_explains(location):
        cameras = Store.open(location).cameras
        if camera is None and len(cameras) != 1:
            raise UsageError(
                f"{location} holds pictures of {', '.join(cameras) or 'no camera'}",
                "one camera",
                "Name one with --camera.",
            )
        parts = [TouchFrames(location, f"{split}/{part}", camera=camera or cameras[0]) for part in ("train", "val")]
        options = TrainOptions(epochs, batch_size=16, learning_rate=learning_rate, decay=0.97)
        with progress("fine-tuning", quiet=as_json) as tell:
            tuned = learn(vae, digest, parts[0], parts[1], options, out, device, tell)
    if as_json:
        emit({**vars(tuned), "checkpoint": str(tuned.checkpoint), "model": digest, "is_worse": tuned.is_worse})
        return
    say(f"learned from {tuned.pictures} pictures, starting from model {digest[:12]}")
    say(f"decoded pictures of the val part differ by {tuned.after:.2f} grey levels; before, by {tuned.before:.2f}")
    if tuned.is_worse:
        say(
            f"wrote {tuned.checkpoint}; but it draws these pictures worse than the model it began with: keep that one,"
            " or try more pictures, more --epochs or a smaller --learning-rate"
        )
        return
    say(f"wrote {tuned.checkpoint}: name it with --model")
