"""A recipe: which data, which networks, which table; what it leaves out is the paper's protocol."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from split_models.learning.train_options import TrainOptions
from split_models.recipe.recipe_defaults import DEFAULTS
from tactiledata.contract.provenance import digest_of
from tactiledata.contract.schema import check_document, parse_document, read_document, shipped_folder
from tactiledata.errors import SchemaError, UnknownName, UsageError

FORMAT = "tactiledata-recipe/1"
SCALES = ("small", "paper")
"""Sizes of a recipe: for two CPU cores, and as in the paper."""


@dataclass(frozen=True)
class Recipe:
    """A recipe at one scale, with every key filled in.

    Parameters
    ----------
    name : str
        The file's stem.
    scale : "small" or "paper"
    title : str
        Title of its page, for people.
    document : dict
        As in ``schemas/recipe.json``, all sections complete.
    asked : str
        The file or the bundled name by which the recipe was asked for.
    """

    name: str
    scale: str
    title: str
    document: Mapping[str, Any]
    asked: str

    @property
    def seed(self) -> int:
        """Seed of weights and of the order of items."""
        return int(self.document["seed"])

    @property
    def table(self) -> str | None:
        """Name of the table that the recipe makes; None for a recipe that only trains."""
        name: str | None = self.document["table"]
        return name

    @property
    def data(self) -> Mapping[str, Any]:
        """Section ``data``: store or world, split, sizes."""
        section: Mapping[str, Any] = self.document["data"]
        return section

    @property
    def models(self) -> Mapping[str, Any]:
        """Section ``models``: sizes and training of the networks."""
        section: Mapping[str, Any] = self.document["models"]
        return section

    @property
    def rows(self) -> Mapping[str, Any]:
        """Section ``rows``: methods, parts, scores and counts of the table."""
        section: Mapping[str, Any] = self.document["rows"]
        return section

    @property
    def digest(self) -> str:
        """Digest of the scale and of the whole document."""
        return digest_of({"scale": self.scale, **self.document})

    def variant(self, name: str) -> Recipe:
        """A copy of the recipe with the networks of one of its variants.

        Raises
        ------
        UnknownName
            The recipe has no such variant.
        """
        variants = self.document["variants"]
        if name not in variants:
            raise UnknownName(f"variant of the recipe {self.name}", name, sorted(variants))
        models = laid_over(self.models, variants[name])
        return replace(self, document={**self.document, "models": models, "variants": {}})

    def training(self, model: str, seed: int | None = None, settle: int = 0) -> TrainOptions:
        """Training options of a network.

        Parameters
        ----------
        model : str
            Key of the network's section under ``models``.
        seed : int, optional
            Seed; the recipe's own unless given.
        settle : int
            Epochs before patience begins to count.
        """
        section = self.models[model]["training"]
        return TrainOptions(**section, settle=settle, seed=self.seed if seed is None else seed)


def load_recipe(name: str | Path, scale: str = "small") -> Recipe:
    """A recipe from a file, or a bundled recipe by its name.

    Raises
    ------
    UnknownName
        The name is neither a file nor a bundled recipe, or the scale does not exist.
    SchemaError
        The document does not fit ``schemas/recipe.json``; unknown keys are refused.
    UsageError
        The document names no data, or both a store and a world.
    """
    if scale not in SCALES:
        raise UnknownName("scale", scale, SCALES)
    stem, document, folder = _read(name)
    document = _with_included(document, folder)
    at_scale = document.pop("scales", {}).get(scale, {})
    title = document.pop("title")
    document.pop("format")
    complete = laid_over(laid_over(DEFAULTS, document), at_scale)
    data = complete["data"]
    if bool(data["store"]) == bool(data["world"]):
        raise UsageError(
            f"the recipe {stem} names {'both a store and a world' if data['store'] else 'neither a store nor a world'}",
            "one of them under `data`",
            "`store: ds.zarr` for your own recordings, `world: NAME` for a simulated world that is recorded first.",
        )
    return Recipe(stem, scale, title, complete, str(name))


def bundled_recipes() -> list[str]:
    """Sorted names of the recipes that come with the toolkit."""
    folder = shipped_folder("recipes")
    return sorted(entry.name.removesuffix(".yaml") for entry in folder.iterdir() if entry.name.endswith(".yaml"))


def laid_over(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """A document merged with another one above it, section by section; lists and values are replaced.

    Examples
    --------
    >>> laid_over({"a": {"b": 1, "c": [1, 2]}}, {"a": {"c": [3]}})
    {'a': {'b': 1, 'c': [3]}}
    """
    merged = copy.deepcopy(dict(below))
    for key, value in above.items():
        is_section = isinstance(value, Mapping) and isinstance(merged.get(key), Mapping) and key != "hold_out"
        merged[key] = laid_over(merged[key], value) if is_section else copy.deepcopy(value)
    return merged


def _read(name: str | Path) -> tuple[str, dict[str, Any], Path | None]:
    """Stem, document and folder of a recipe; the folder of a bundled recipe is None."""
    path = Path(name)
    if path.is_file() or path.suffix in {".yaml", ".yml", ".json"}:
        return path.stem, read_document(path, "recipe"), path.parent
    known = bundled_recipes()
    if str(name) not in known:
        beside = [str(path.with_name(path.name + ending)) for ending in (".yaml", ".yml", ".json")]
        there = [file for file in beside if Path(file).is_file()]
        remedy = f"A file {there[0]} is there: name it with its ending." if there else "Or name a recipe's file."
        raise UnknownName("recipe", str(name), known, remedy)
    file = shipped_folder("recipes") / f"{name}.yaml"
    where = f"recipes/{name}.yaml"
    document = parse_document(file.read_text(encoding="utf-8"), where)
    check_document(document, "recipe", where)
    return str(name), document, None


def _with_included(document: Mapping[str, Any], folder: Path | None) -> dict[str, Any]:
    """The document merged over the one that it includes; without ``include`` a copy of it."""
    own = dict(document)
    included = own.pop("include", None)
    if included is None:
        return own
    _, below, _ = _read(Path(included).stem if folder is None else folder / included)
    if "include" in below:
        raise SchemaError(f"the included {included} includes another recipe", "one level", path="$.include")
    return laid_over(below, own)
