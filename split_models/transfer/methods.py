"""Transfer methods by name: by pixels, or by an image VAE."""

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
    "latent_relit": "mean of latent arithmetic and of the touch in the target's light",
    "adain": "AdaIN in the VAE's feature space",
}
"""Methods that need an image VAE, with titles for people."""
BUNDLED_MODEL = Path(__file__).parents[1] / "weights" / "image_vae.ckpt"
"""Checkpoint of the image VAE that is used unless another is named."""


class TransferMethod(Protocol):
    """A method that transfers pictures of one sensor to the style of another."""

    @property
    def name(self) -> str:
        """Name of the method, as on the command line."""

    def transfer(
        self, images: PictureArray, source_background: PictureArray, target_background: PictureArray
    ) -> PictureArray:
        """Pictures (n, H, W, 3) uint8 as the target sensor might have recorded them.

        Parameters
        ----------
        images : (n, H, W, 3) uint8 RGB
            Pictures of the source sensor.
        source_background, target_background : (H, W, 3) uint8 RGB
            Source and target without contact.
        """


def transfer_method(name: str, model: Path | None = None, device: str = "cpu") -> TransferMethod:
    """The transfer method of a name, in which ``-`` and ``_`` are equivalent.

    Parameters
    ----------
    name : str
        A name in `LATENT` or in `PIXEL_TRANSFERS`.
    model : Path, optional
        Checkpoint of an image VAE; the bundled one unless given.
    device : "cpu" or "cuda"
        Device that the image VAE runs on; methods by pixels run on the CPU.

    Raises
    ------
    UnknownName
        There is no such method or device.
    UsageError
        A model is given for a method that takes none, or PyTorch has no GPU for ``cuda``.
    MissingFile
        The model does not exist.
    CheckpointError
        The file holds no image VAE.
    """
    key = name.replace("-", "_")
    if key not in LATENT:
        if key not in PIXEL_TRANSFERS:
            raise UnknownName("transfer method", name, [*LATENT, *PIXEL_TRANSFERS])
        if model is not None:
            latent = ", ".join(method.replace("_", "-") for method in LATENT)
            raise UsageError(
                f"--model {model} with --method {name}",
                f"a method that uses a model: {latent}",
                "Leave out --model, or take one of these methods.",
            )
        return PIXEL_TRANSFERS[key]
    from split_models.transfer.latent_transfer import load_image_vae

    return vae_transfer(key, *load_image_vae(model_file(model, f"--method {name}"), device))


def model_file(model: Path | None, wanted_by: str) -> Path:
    """The checkpoint that was given, or the bundled one; ``wanted_by`` names the command in the message.

    Raises
    ------
    MissingFile
        None was given, and none is bundled.
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
    """A method of `LATENT` that uses an image VAE in memory.

    Parameters
    ----------
    name : str
        A name in `LATENT`.
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
    """Title of a transfer method for people."""
    return LATENT.get(name) or str(PIXEL_TRANSFERS[name].title)
