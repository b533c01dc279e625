"""The commands `train`, `evaluate` and `run`, and the registration of all commands of this package."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import typer

from split_models.commands import export as export_command
from split_models.commands import fine_tune as fine_tune_command
from split_models.commands import score as score_command
from split_models.commands import transfer as transfer_command
from split_models.commands.device_option import DEVICE
from tactiledata.cli.documents import wrong_document_is_wrong_usage
from tactiledata.cli.output import JSON_OPTION, emit, progress, say
from tactiledata.contract.extras import need_packages
from tactiledata.contract.progress import Progress
from tactiledata.errors import UsageError

RECIPE = typer.Argument(..., help="A recipe file, or the name of a bundled one.")
SCALE_HELP = "small, for two CPU cores, or paper, the paper's sizes, for a GPU."
OUT = typer.Option(Path("runs"), "--out", help="Folder for data, models and tables. Recipes share models.")
WORKERS = typer.Option(1, "--workers", min=1, help="Local processes that record and replay a world.")


def register(app: typer.Typer) -> None:
    """Add all commands of this package to the application; PyTorch is not imported until one of them runs."""
    app.command("train")(train)
    app.command("evaluate")(evaluate)
    app.command("run")(run)
    transfer_command.register(app)
    score_command.register(app)
    fine_tune_command.register(app)
    export_command.register(app)


def train(
    recipe: str = RECIPE,
    scale: str = typer.Option("small", "--scale", help=SCALE_HELP),
    device: str = DEVICE,
    out: Path = OUT,
    workers: int = WORKERS,
    as_json: bool = JSON_OPTION,
) -> None:
    """Train all models of a recipe. A run that was killed continues where it stopped.

    To use several processes, start `torchrun -m split_models train RECIPE`.

    Example: tactiledata train table_digit_images --scale small
    """
    with opened_run(recipe, scale, device, out, workers, as_json) as recipe_run:
        trained = _prepare(recipe_run)
        if recipe_run.ranks.is_first:
            _print_models(trained, as_json)


def evaluate(
    recipe: str = RECIPE,
    scale: str = typer.Option("small", "--scale", help=SCALE_HELP),
    device: str = DEVICE,
    out: Path = OUT,
    as_json: bool = JSON_OPTION,
) -> None:
    """Make the table of a recipe with trained models.

    Example: tactiledata evaluate table_digit_images --scale small
    """
    with opened_run(recipe, scale, device, out, 1, as_json, may_train=False) as recipe_run:
        if recipe_run.ranks.is_first:
            _table(recipe_run, as_json)


def run(
    recipe: str = RECIPE,
    scale: str = typer.Option("small", "--scale", help=SCALE_HELP),
    device: str = DEVICE,
    out: Path = OUT,
    workers: int = WORKERS,
    as_json: bool = JSON_OPTION,
) -> None:
    """Make a table of the paper, from data to scores.

    Example: tactiledata run table_digit_images --scale small --workers 2
    """
    with opened_run(recipe, scale, device, out, workers, as_json) as recipe_run:
        trained = _prepare(recipe_run)
        if not recipe_run.ranks.is_first:
            return
        if recipe_run.recipe.table is None:
            _print_models(trained, as_json)
        else:
            _table(recipe_run, as_json)


@contextmanager
def opened_run(
    recipe: str, scale: str, device: str, out: Path, workers: int, as_json: bool, may_train: bool = True
) -> Iterator[Any]:
    """The run of a recipe, as a context; wrong usage is refused before anything is made.

    Parameters
    ----------
    recipe : str
        A recipe file, or the name of a bundled recipe.
    scale : "small" or "paper"
    device : "cpu" or "cuda"
    out : Path
        Folder for data, models and tables.
    workers : int
        Local processes that record and replay a world.
    as_json : bool
        Whether the command prints JSON, and so no bars of progress.
    may_train : bool
        Whether models that are not trained yet are trained; else they are an error.

    Raises
    ------
    UsageError
        PyTorch is not installed, or has no GPU for ``cuda``.
    UnknownName
        There is no such recipe, scale or device.
    """
    from split_models.recipe.recipe import load_recipe

    with wrong_document_is_wrong_usage():
        loaded = load_recipe(recipe, scale)
    need_packages("a recipe", "torch")
    from split_models.learning.device import find_device, processes
    from split_models.recipe.recipe_run import RecipeRun

    place = find_device(device)
    with processes(place) as ranks, _by_steps(as_json or not ranks.is_first) as tell:
        yield RecipeRun(loaded, out, place, ranks, tell, workers, may_train)


@contextmanager
def _by_steps(quiet: bool) -> Iterator[Progress]:
    """A function that reports progress; the words before a colon name a step, and each step has its own bar."""
    with ExitStack() as bars:
        current: list[Any] = ["", None]

        def tell(done: int, total: int, what: str = "") -> None:
            step, _, words = what.partition(": ")
            if step != current[0]:
                bars.close()
                current[:] = [step, bars.enter_context(progress(step, quiet))]
            current[1](done, total, words)

        yield tell


def _prepare(recipe_run: Any) -> dict[str, str]:
    """Folders of the models that a recipe needs, by name, after all of them have been trained."""
    from split_models.tables.tables import PREPARE

    table = recipe_run.recipe.table
    if table is None:
        recipe_run.train_backbone()
    else:
        PREPARE[table](recipe_run)
    return dict(recipe_run.kept.folders)


def _print_models(trained: dict[str, str], as_json: bool) -> None:
    """Print the folder of each model."""
    if as_json:
        emit({"models": trained})
        return
    for name, folder in trained.items():
        say(f"{name}: {folder}")
    if "image_vae" in trained:
        model = Path(trained["image_vae"]) / "best.pt"
        say(f"a transfer with this image VAE: tactiledata transfer STORE --to SENSOR --method latent --model {model}")


def _table(recipe_run: Any, as_json: bool) -> None:
    """Make, write and print the table of a recipe."""
    from split_models.networks.latent_normal import drawn_alike
    from split_models.tables.results import result_document, write_result
    from split_models.tables.tables import ROWS
    from tactiledata.store.read.reader import Store
    from tactiledata.store.read.simulated import simulated_recordings

    recipe = recipe_run.recipe
    if recipe.table is None:
        raise UsageError(
            f"the recipe {recipe.name} has no table", "`table: …` in the recipe", "Use `tactiledata train` for it."
        )
    with drawn_alike(recipe.seed):
        rows = ROWS[recipe.table](recipe_run)
    store = Store.open(recipe_run.store)
    document = result_document(recipe, rows, store.digest, simulated_recordings(store))
    paths = write_result(recipe_run.tables, document)
    if as_json:
        emit({**document, "files": {name: str(path) for name, path in paths.items()}})
        return
    say(paths["markdown"].read_text(encoding="utf-8"))
    say(f"{paths['markdown']} and {paths['json']}")
