"""Methods of the tables by name, each built from a recipe's run, and SPLIT, NOSPLIT and the end-to-end network."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from split_models.networks.latent import (
    AtRest,
    DirectMeshToImage,
    LatentImageToMesh,
    LatentMeshToImage,
    NoContact,
    SplitOnBackground,
)
from split_models.recipe.recipe_run import RecipeRun
from tactiledata.arrays import PictureArray, SingleArray
from tactiledata.registry import Registry


class MeshToImage(Protocol):
    """A method that makes pictures of deformed meshes.

    A method that is calibrated for each unit also has ``for_sensor(sensor)``, which gives the method for that unit.
    """

    @property
    def name(self) -> str:
        """Name of the method's row in tables."""

    def predict(self, displacements: SingleArray, background: PictureArray) -> PictureArray:
        """Pictures (n, h, w, 3), uint8, of displacements (n, v, 3), m, on a background (h, w, 3)."""


class ImageToMesh(Protocol):
    """A method that makes deformed meshes of pictures."""

    @property
    def name(self) -> str:
        """Name of the method's row in tables."""

    def predict(self, pictures: PictureArray, background: PictureArray) -> SingleArray:
        """Displacements (n, v, 3), m, of pictures (n, h, w, 3) of a sensor with a background (h, w, 3)."""


MESH_TO_IMAGE = Registry(
    "mesh-to-image method",
    {
        "no_contact": "split_models.methods.methods:no_contact",
        "end_to_end": "split_models.methods.methods:end_to_end",
        "taxim_published": "split_models.methods.baselines:taxim_published",
        "taxim_registered": "split_models.methods.baselines:taxim_registered",
        "taxim_calibrated": "split_models.methods.baselines:taxim_calibrated",
        "fots_published": "split_models.methods.baselines:fots_published",
        "fots_calibrated": "split_models.methods.baselines:fots_calibrated",
        "across": "split_models.methods.baselines:across",
        "nosplit": "split_models.methods.methods:nosplit",
        "split": "split_models.methods.methods:split",
        "split_on_background": "split_models.methods.methods:split_on_background",
        "split_cycle": "split_models.methods.cycle:split_cycle",
        "split_onnx": "split_models.onnx.export:split_onnx",
    },
    group="split_models.mesh_to_image",
)
"""Methods by name; each is a function of a `RecipeRun` that gives a `MeshToImage`."""

IMAGE_TO_MESH = Registry(
    "image-to-mesh method",
    {
        "at_rest": "split_models.methods.methods:at_rest",
        "zhu": "split_models.methods.zhu_row:zhu",
        "nosplit": "split_models.methods.methods:nosplit_mesh",
        "split": "split_models.methods.methods:split_mesh",
        "split_cycle": "split_models.methods.cycle:split_cycle_mesh",
        "split_onnx": "split_models.onnx.export:split_onnx_mesh",
    },
    group="split_models.image_to_mesh",
)
"""Methods by name; each is a function of a `RecipeRun` that gives an `ImageToMesh`."""

TITLES = {
    "no_contact": "target background, no contact",
    "at_rest": "undeformed mesh",
    "end_to_end": "end-to-end autoencoder",
    "nosplit": "NOSPLIT",
    "split": "SPLIT",
    "split_on_background": "SPLIT on the recorded background (beyond the paper)",
    "split_onnx": "SPLIT by onnxruntime",
    "split_sampled": "SPLIT, latent vectors drawn, as in the paper",
    "split_cycle_only": "SPLIT, projections learned together by their cycle (beyond the paper)",
    "split_cycle": "SPLIT, projections learned together by their cycle and on their own outputs (beyond the paper)",
    "faded": "background and undeformed mesh: where fading ends",
    "taxim_published": "Taxim, published calibration",
    "taxim_calibrated": "Taxim, calibrated and registered per unit",
    "taxim_registered": "Taxim, published table, camera registered per unit",
    "fots_published": "FOTS's network, taught by Taxim's published table",
    "fots_calibrated": "FOTS, calibrated and registered per unit",
    "zhu": "Zhu et al. 2022",
    "across": "ACROSS",
    "raw_mesh": "raw vertices",
    "raw_image": "raw images",
    "mesh": "mesh latent",
    "image": "image latent (NOSPLIT)",
    "deformation": "image latent (SPLIT)",
    "projected_nosplit": "projected mesh (NOSPLIT)",
    "projected_split": "projected mesh (SPLIT)",
}
"""Titles of rows for people; some rows are inputs of force heads."""


def mesh_to_image(recipe_run: RecipeRun, row: str) -> MeshToImage:
    """The mesh-to-image method of a row; ``VARIANT:METHOD`` is a method with the networks of a recipe variant."""
    variant, _, name = row.rpartition(":")
    method: MeshToImage = MESH_TO_IMAGE[name](recipe_run.variant(variant))
    return method


def image_to_mesh(recipe_run: RecipeRun, row: str) -> ImageToMesh:
    """The image-to-mesh method of a row; ``VARIANT:METHOD`` is a method with the networks of a recipe variant."""
    variant, _, name = row.rpartition(":")
    method: ImageToMesh = IMAGE_TO_MESH[name](recipe_run.variant(variant))
    return method


def title_of(row: str, titles: Mapping[str, str] | None = None) -> str:
    """Title of a row for people, followed by its variant.

    Parameters
    ----------
    row : str
        ``METHOD`` or ``VARIANT:METHOD``.
    titles : dict, optional
        Titles of rows that a recipe gives, which go before the usual ones.
    """
    if titles and row in titles:
        return titles[row]
    variant, _, name = row.rpartition(":")
    title = TITLES.get(name, name)
    return f"{title}, {variant}" if variant else title


def no_contact(recipe_run: RecipeRun) -> MeshToImage:
    """The method that gives the background for every mesh."""
    return NoContact()


def at_rest(recipe_run: RecipeRun) -> ImageToMesh:
    """The method that gives the undeformed mesh for every picture."""
    return AtRest(recipe_run.topology.n_vertices)


def end_to_end(recipe_run: RecipeRun) -> MeshToImage:
    """The method that uses the end-to-end autoencoder."""
    return DirectMeshToImage("end_to_end", recipe_run.end_to_end)


def nosplit(recipe_run: RecipeRun) -> MeshToImage:
    """NOSPLIT: the mesh's latent vector is projected onto the picture's."""
    return _mesh_to_image(recipe_run, is_split=False)


def split(recipe_run: RecipeRun) -> MeshToImage:
    """SPLIT: the mesh's latent vector is projected onto the deformation's, and the background's is added."""
    return _mesh_to_image(recipe_run, is_split=True)


def split_on_background(recipe_run: RecipeRun) -> MeshToImage:
    """SPLIT's change of the picture, added to the recorded background."""
    return SplitOnBackground("split_on_background", _mesh_to_image(recipe_run, is_split=True))


def nosplit_mesh(recipe_run: RecipeRun) -> ImageToMesh:
    """NOSPLIT: the picture's latent vector is projected onto the mesh's."""
    return _image_to_mesh(recipe_run, is_split=False)


def split_mesh(recipe_run: RecipeRun) -> ImageToMesh:
    """SPLIT: the picture's latent vector minus the background's is projected onto the mesh's."""
    return _image_to_mesh(recipe_run, is_split=True)


def _mesh_to_image(recipe_run: RecipeRun, is_split: bool) -> LatentMeshToImage:
    """SPLIT or NOSPLIT from meshes to pictures, with the recipe's trained networks."""
    projection = recipe_run.projection("mesh_to_image", is_split)
    name, latents = "split" if is_split else "nosplit", recipe_run.recipe.models["latents"]
    return LatentMeshToImage(name, recipe_run.mesh_vae, recipe_run.image_vae, projection, is_split, latents)


def _image_to_mesh(recipe_run: RecipeRun, is_split: bool) -> LatentImageToMesh:
    """SPLIT or NOSPLIT from pictures to meshes, with the recipe's trained networks."""
    projection = recipe_run.projection("image_to_mesh", is_split)
    name, latents = "split" if is_split else "nosplit", recipe_run.recipe.models["latents"]
    return LatentImageToMesh(name, recipe_run.image_vae, recipe_run.mesh_vae, projection, is_split, latents)


def for_sensor(method: Any, sensor: str) -> Any:
    """The method for a unit: its calibration for that unit where it has one, else the method itself."""
    chosen = getattr(method, "for_sensor", None)
    return method if chosen is None else chosen(sensor)
