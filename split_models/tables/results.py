"""A finished table: a JSON document for programs, and a page of Markdown for people."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from split_models.methods.methods import title_of
from split_models.recipe.prepare import MATERIAL, is_calibrated
from split_models.recipe.recipe import Recipe
from split_models.tables.evaluate import MASKED
from tactiledata.contract.atomic import write_atomic, write_json_atomic
from tactiledata.contract.provenance import provenance
from tactiledata.contract.simulated import NOTHING_STATED, SimulatedCount

RESULT = "table"
"""Stem of both files."""
ARROWS = {"higher": "↑", "lower": "↓", "nearest": "→ 1"}


def result_document(
    recipe: Recipe,
    rows: Sequence[Mapping[str, Any]],
    store_digest: str,
    simulated: SimulatedCount = NOTHING_STATED,
) -> dict[str, Any]:
    """The table as a document, with the digests of recipe and store that it was made from.

    Parameters
    ----------
    recipe : Recipe
    rows : sequence of dict
        Rows of the table.
    store_digest : str
        Digest of the store.
    simulated : SimulatedCount
        How many of the store's recordings are simulated.
    """
    return {
        "format": "tactiledata-table/1",
        "recipe": recipe.name,
        "command": f"tactiledata run {shlex.quote(recipe.asked)} --scale {recipe.scale}",
        "title": recipe.title,
        "scale": recipe.scale,
        "seed": recipe.seed,
        "table": recipe.table,
        "simulated_recordings": simulated.document(),
        "rows": [dict(row) for row in rows],
        "titles": dict(recipe.rows["titles"]),
        "meshes": mesh_facts(recipe.data),
        "published": dict(recipe.document["published"]),
        "provenance": provenance("run", {"recipe": recipe.digest, "store": store_digest}),
    }


def mesh_facts(data: Mapping[str, Any]) -> str:
    """Resolution, nodes, strains and material of a recipe's meshes in words; empty for a store that it did not make.

    The paper gives Taxim and FOTS the high resolution. Whether a table does is to be read from it.
    """
    if not data["world"]:
        return ""
    section = data["replay"]
    nodes = "surface nodes" if section["keep"] == "surface" else "all nodes"
    stated = [f"{name.replace('_', ' ')} {section[name]:g}" for name in MATERIAL if section[name] is not None]
    if len(stated) < len(MATERIAL):
        planted = "the material with which the world was recorded, which nobody knows of real touches"
        stated.append("a material calibrated on the recorded forces" if is_calibrated(section) else planted)
    return f"{section['resolution']} resolution, {nodes}, {section['fidelity']}, {', '.join(stated)}"


def write_result(folder: Path, document: Mapping[str, Any]) -> dict[str, Path]:
    """Write ``table.json`` and ``table.md`` into a folder; their paths by ``json`` and ``markdown``."""
    paths = {"json": folder / f"{RESULT}.json", "markdown": folder / f"{RESULT}.md"}
    write_json_atomic(paths["json"], document)
    write_atomic(paths["markdown"], markdown(document).encode())
    return paths


def markdown(document: Mapping[str, Any]) -> str:
    """The page of a table: each part of the split, followed by the paper's own figures where the recipe has them."""
    lines = [
        f"# {document['title']}",
        "",
        f"`{document['command']}`, seed {document['seed']}.",
    ]
    if sentence := SimulatedCount(**document["simulated_recordings"]).sentence:
        lines += ["", sentence]
    if document["meshes"]:
        lines += ["", f"Meshes, of all rows: {document['meshes']}."]
    titles = document["titles"]
    for part in dict.fromkeys(row["part"] for row in document["rows"]):
        rows = [row for row in document["rows"] if row["part"] == part]
        lines += ["", f"## {part}: {_size(rows)}", "", *table_lines(rows, titles)]
        published = document["published"].get(part)
        if published:
            lines += ["", "The paper's own figures, of another data set:", "", *_published_lines(published)]
    return "\n".join([*lines, ""])


def table_lines(rows: Sequence[Mapping[str, Any]], titles: Mapping[str, str] | None = None) -> list[str]:
    """Lines of a Markdown table with a column for each score; ``titles`` as in `row_title`."""
    names = list(dict.fromkeys(name for row in rows for name in row["scores"]))
    heads = [_head(name, next(row["scores"][name] for row in rows if name in row["scores"])) for name in names]
    return [
        f"| | {' | '.join(heads)} |",
        f"|---|{'---|' * len(heads)}",
        *(
            f"| {row_title(row, titles)} | {' | '.join(cell(row['scores'].get(name)) for name in names)} |"
            for row in rows
        ),
    ]


def row_title(row: Mapping[str, Any], titles: Mapping[str, str] | None = None) -> str:
    """Title of a row for people, with its cycle where it has one; ``titles`` are those that a recipe gives."""
    title = title_of(row["method"], titles)
    return f"{title}, cycle {row['cycle']}" if "cycle" in row else title


def cell(score: Mapping[str, Any] | None) -> str:
    """A score as text: its value with its interval, or with its standard deviation over seeds."""
    if score is None or score["value"] is None:
        return "–"
    text = f"{score['value']:.4g}"
    if score.get("deviation") is not None:
        return f"{text} ({score['deviation']:.2g})"
    if score.get("low") is not None and score.get("high") is not None:
        return f"{text} [{score['low']:.4g}, {score['high']:.4g}]"
    return text


def _head(name: str, score: Mapping[str, Any]) -> str:
    """Heading of a score: name, region, unit, and an arrow towards better values."""
    where = " in contact" if name.endswith(MASKED) else ""
    unit = f", {score['unit']}" if score["unit"] else ""
    return f"{name.removesuffix(MASKED)}{where}{unit} {ARROWS[score['better']]}"


def _size(rows: Sequence[Mapping[str, Any]]) -> str:
    """Numbers of frames and trajectories, or of seeds, behind the rows of a part."""
    score = next(iter(rows[0]["scores"].values()))
    if "seeds" in score:
        counts = {row["method"]: next(iter(row["scores"].values()))["seeds"] for row in rows}
        seeds = [
            f"{count} ({', '.join(title_of(method) for method, own in counts.items() if own == count)})"
            for count in sorted(set(counts.values()))
        ]
        return (
            f"mean and standard deviation over seeds: {'; '.join(seeds) if seeds[1:] else next(iter(counts.values()))}"
        )
    trajectories = (
        f" of {score['trajectories']} trajectories, 95 % over trajectories" if "trajectories" in score else ""
    )
    return f"{score['frames']} frames{trajectories}"


def _published_lines(published: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Lines of a Markdown table with the paper's own figures, under the paper's names."""
    names = list(dict.fromkeys(name for row in published.values() for name in row))
    return [
        f"| | {' | '.join(names)} |",
        f"|---|{'---|' * len(names)}",
        *(
            f"| {title_of(method)} | {' | '.join(str(row.get(name, '–')) for name in names)} |"
            for method, row in published.items()
        ),
    ]
