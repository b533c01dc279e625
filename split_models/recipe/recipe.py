"""A recipe: which data, which models, which table; what it leaves out is as in the paper."""

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


@dataclass(frozen=True)
class Recipe:
    """A recipe at one scale, with nothing left open.

    Parameters
    ----------
    name : str
        The file's stem.
    scale : "small" or "paper"
    title : str
    document : dict
        As in ``schemas/recipe.json``, all sections complete.
    """

    name: str
    scale: str
    title: str
    document: Mapping[str, Any]

    @property
    def seed(self) -> int:
        """Of weights and of the order of items."""
        return int(self.document["seed"])

    @property
    def table(self) -> str | None:
        """Which table; None for models only."""
        found: str | None = self.document["table"]
        return found

    @property
    def data(self) -> Mapping[str, Any]:
        """Store or world, split, sizes."""
        found: Mapping[str, Any] = self.document["data"]
        return found

    @property
    def models(self) -> Mapping[str, Any]:
        """Sizes and training of the networks."""
        found: Mapping[str, Any] = self.document["models"]
        return found

    @property
    def rows(self) -> Mapping[str, Any]:
        """What the table shows."""
        found: Mapping[str, Any] = self.document["rows"]
        return found

    @property
    def digest(self) -> str:
        """Of everything in it."""
        return digest_of({"scale": self.scale, **self.document})

    def variant(self, name: str) -> Recipe:
        """The same recipe with its models as a variant shapes them.

        Raises
        ------
        UnknownName
            It has no such variant.
        """
        variants = self.document["variants"]
        if name not in variants:
            raise UnknownName(f"variant of the recipe {self.name}", name, sorted(variants))
        models = laid_over(self.models, variants[name])
        return replace(self, document={**self.document, "models": models, "variants": {}})

    def training(self, model: str, seed: int | None = None, settle: int = 0) -> TrainOptions:
        """How a network learns."""
        section = self.models[model]["training"]
        return TrainOptions(**section, settle=settle, seed=self.seed if seed is None else seed)


def load_recipe(name: str | Path, scale: str = "small") -> Recipe:
    """A recipe from a file, or one of the bundled ones by its name.

    Raises
    ------
    UnknownName
        Neither a file nor a bundled recipe; a scale that does not exist.
    SchemaError
        It does not fit ``schemas/recipe.json``: unknown keys are refused.
    UsageError
        It names no data, or both a store and a world.
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
            "`store: ds.zarr` for recordings of your own, `world: NAME` for one that is recorded first.",
        )
    return Recipe(stem, scale, title, complete)


def bundled_recipes() -> list[str]:
    """Names of the recipes that come with the toolkit."""
    folder = shipped_folder("recipes")
    return sorted(entry.name.removesuffix(".yaml") for entry in folder.iterdir() if entry.name.endswith(".yaml"))


def laid_over(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """A document over another, section by section; a list or a value replaces.

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
    """Stem, document and folder (None for a bundled one) of a recipe."""
    path = Path(name)
    if path.is_file() or path.suffix in {".yaml", ".yml", ".json"}:
        return path.stem, read_document(path, "recipe"), path.parent
    known = bundled_recipes()
    if str(name) not in known:
        raise UnknownName("recipe", str(name), known, "Or name a recipe's file.")
    file = shipped_folder("recipes") / f"{name}.yaml"
    where = f"recipes/{name}.yaml"
    document = parse_document(file.read_text(encoding="utf-8"), where)
    check_document(document, "recipe", where)
    return str(name), document, None


def _with_included(document: Mapping[str, Any], folder: Path | None) -> dict[str, Any]:
    """The document over the one that it includes."""
    own = dict(document)
    included = own.pop("include", None)
    if included is None:
        return own
    _, below, _ = _read(Path(included).stem if folder is None else folder / included)
    if "include" in below:
        raise SchemaError(f"{included}, which is included, includes another recipe", "one level", path="$.include")
    return laid_over(below, own)
