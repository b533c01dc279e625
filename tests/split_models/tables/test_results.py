"""A finished table reads as what it is."""

import json
from dataclasses import replace

from split_models.recipe.recipe import load_recipe
from split_models.recipe.recipe_defaults import DEFAULTS
from split_models.tables.results import cell, markdown, mesh_facts, result_document, write_result


def row(part, method, **scores):
    return {"part": part, "method": method, "scores": scores}


def score(value, **more):
    return {"value": value, "unit": "mm", "better": "lower", "frames": 7, "trajectories": 3, **more}


def test_cells_say_what_is_known():
    """A cell has a value, its interval or its deviation over seeds, and a dash for nothing."""
    assert cell(score(0.123456)) == "0.1235"
    assert cell(score(0.5, low=0.4, high=0.6)) == "0.5 [0.4, 0.6]"
    assert cell(score(0.5, low=None, high=None)) == "0.5"
    assert cell(score(1.0, deviation=0.0123)) == "1 (0.012)"
    assert cell(score(None)) == cell(None) == "–"


def test_the_page_has_every_part_and_the_papers_own_figures_apart(tmp_path):
    """Ours with units and arrows; the paper's said to be of another data set, only where a part has them."""
    recipe = load_recipe("table_mesh")
    rows = [
        row("test", "split", rmse=score(0.02, low=0.01, high=0.03)),
        row("test_unseen", "split", rmse=score(0.05), rmse_contact=score(0.07)),
    ]
    document = result_document(recipe, rows, "d" * 64)
    text = markdown(document)
    assert "`tactiledata run table_mesh --scale small`, seed 0." in text
    assert "| SPLIT with our image VAE | 0.02 [0.01, 0.03] |" in text
    assert "rmse in contact, mm ↓" in text
    seen, unseen = text.split("## test_unseen")
    assert "another data set" not in seen
    assert "| SPLIT | 0.075 | 0.028 | 0.061 |" in unseen
    own = replace(recipe, asked="my recipes/mine.yaml")
    assert "`tactiledata run 'my recipes/mine.yaml' --scale small`" in markdown(result_document(own, rows, "d" * 64))
    paths = write_result(tmp_path, document)
    assert json.loads(paths["json"].read_text())["rows"] == rows
    assert paths["markdown"].read_text() == text


def test_titles_of_a_recipe_go_before_the_usual_ones():
    """At small scale the paper's names are of rows with the paper's image VAE, and of the paper's own figures."""
    recipe = load_recipe("table_digit_images")
    rows = [row("test", "plain:split", l1=score(2.0)), row("test", "split", l1=score(1.0))]
    text = markdown(result_document(recipe, rows, "d" * 64))
    assert "| SPLIT | 2 |" in text
    assert "| SPLIT with our image VAE | 1 |" in text
    assert "| SPLIT | 5.911 |" in text
    assert "Meshes, of all rows: low resolution, surface nodes, finite-strain, a material calibrated on" in text
    paper = load_recipe("table_digit_images", "paper")
    assert "plain:split" not in paper.rows["methods"]
    assert "| SPLIT | 1 |" in markdown(result_document(paper, rows[1:], "d" * 64))


def test_a_store_of_ones_own_has_its_meshes_page():
    """Of a store that a recipe did not make, nothing is said about its meshes; a planted material is called that."""
    assert mesh_facts({"world": None, "store": "ds.zarr"}) == ""
    replay = {**DEFAULTS["data"]["replay"], "material": "planted"}
    assert "with which the world was recorded" in mesh_facts({"world": "tiny", "replay": replay})
    stated = {**replay, "youngs_modulus": 9e5, "poisson_ratio": 0.48, "friction": 0.7}
    assert mesh_facts({"world": "tiny", "replay": stated}).endswith(
        "youngs modulus 900000, poisson ratio 0.48, friction 0.7"
    )


def test_seeds_are_counted_by_row():
    """Rows that differ in their number of seeds say how many each had."""
    one, other = ({"value": 1.0, "unit": "N", "better": "lower", "seeds": count, "deviation": 0.1} for count in (3, 20))
    document = result_document(load_recipe("table_force"), [row("test", "raw_mesh", fx=one)], "d" * 64)
    assert "## test: mean and standard deviation over seeds: 3\n" in markdown(document)
    rows = [row("test", "raw_mesh", fx=one), row("test", "mesh", fx=other), row("test", "image", fx=other)]
    text = markdown(result_document(load_recipe("table_force"), rows, "d" * 64))
    assert "over seeds: 3 (raw vertices); 20 (mesh latent, image latent (NOSPLIT))\n" in text
