"""Ways to transfer pictures between sensors, by name: by pixels, or by a model's latent vectors."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from split_models.transfer.pixels import PIXEL_TRANSFERS
from tactiledata.arrays import PictureArray
from tactiledata.errors import MissingFile, UnknownName, UsageError

if TYPE_CHECKING:
    from split_models.networks.image_vae import ImageVae

LATENT = {
    "latent": "latent arithmetic",
    "latent_on_background": "latent arithmetic, its change on the target background",
    "latent_ratio_on_background": "latent arithmetic, its ratio on the target background",
    "adain": "AdaIN in the VAE's feature space",
}
"""Methods that need a model, with titles for people."""
BUNDLED_MODEL = Path(__file__).parents[1] / "weights" / "image_vae.ckpt"
"""The model that is taken where none is named."""


class TransferMethod(Protocol):
    """What a store is transferred by."""

    @property
    def name(self) -> str:
        """As on the command line."""

    def transfer(
        self, images: PictureArray, source_background: PictureArray, target_background: PictureArray
    ) -> PictureArray:
        """Pictures (n, H, W, 3) uint8 of a source sensor, as the target might have seen them."""


def transfer_method(name: str, model: Path | None = None) -> TransferMethod:
    """The method of a name; ``-`` is as good as ``_``.

    Parameters
    ----------
    name : str
        One of `LATENT`, or one of the table of pixel transfers.
    model : Path, optional
        Checkpoint of an image VAE; the bundled one by default.

    Raises
    ------
    UnknownName
        No such method.
    UsageError, MissingFile
        A model for a method that takes none; a model that is not there.
    CheckpointError
        A file that is no image VAE.
    """
    key = name.replace("-", "_")
    if key not in LATENT:
        if key not in PIXEL_TRANSFERS:
            raise UnknownName("transfer method", name, [*LATENT, *PIXEL_TRANSFERS])
        if model is not None:
            raise UsageError(f"--model {model} with --method {name}", "a method that uses a model: latent", "")
        return PIXEL_TRANSFERS[key]
    from split_models.transfer.latent_transfer import load_image_vae

    return vae_transfer(key, *load_image_vae(model_file(model, f"--method {name}")))


def model_file(model: Path | None, wanted_by: str) -> Path:
    """The checkpoint of a name, or the bundled one.

    Raises
    ------
    MissingFile
        None was named, and none is bundled.
    """
    if model is None and not BUNDLED_MODEL.is_file():
        raise MissingFile(
            f"{wanted_by} needs a model of pictures, and none is bundled with this version",
            "a checkpoint of an image VAE",
            "Train one (`tactiledata train RECIPE`) and name it with --model, or transfer by pixels: "
            "--method background-swap.",
        )
    return model or BUNDLED_MODEL


def vae_transfer(name: str, vae: ImageVae, model: str = "", recipe: str = "") -> TransferMethod:
    """A method of `LATENT` by an image VAE that is at hand.

    Parameters
    ----------
    name : str
    vae : ImageVae
    model, recipe : str
        SHA-256 of the checkpoint's file and of the recipe that it was trained by, where they are known.
    """
    from split_models.transfer.adain_transfer import AdainTransfer
    from split_models.transfer.latent_transfer import LAID, LatentTransfer

    if name == "adain":
        return AdainTransfer(name, vae, model, recipe)
    return LatentTransfer(name, vae, LAID[name], model, recipe)


def title_of(name: str) -> str:
    """A method's name for people."""
    return LATENT.get(name) or str(PIXEL_TRANSFERS[name].title)
