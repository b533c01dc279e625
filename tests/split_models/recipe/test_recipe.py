"""Recipes are checked word by word, complete after loading, and the bundled ones load at both scales."""

import pytest
import yaml
from touch_world import tiny_recipe

from split_models.recipe.recipe import DEFAULTS, SCALES, bundled_recipes, laid_over, load_recipe
from tactiledata.contract.schema import check_document, load_schema
from tactiledata.errors import MissingFile, SchemaError, UnknownName, UsageError


def written(folder, document, name="r.yaml"):
    path = folder / name
    path.write_text(yaml.safe_dump(document))
    return path


def test_what_is_left_out_is_as_in_the_paper(tmp_path):
    """Sizes, weights, rates and batches are those of the paper's appendix."""
    document = {"format": "tactiledata-recipe/1", "title": "t", "data": {"store": "ds.zarr"}}
    recipe = load_recipe(written(tmp_path, document), "paper")
    models = recipe.models
    assert recipe.data["image_size"] == [320, 240]
    assert models["image_vae"]["blocks"] == [3, 3, 5, 5, 3, 3]
    assert models["image_vae"]["down"] == [2, 2, 2, 2, 5]
    assert (models["image_vae"]["latent"], models["image_vae"]["anneal"]) == (256, 50)
    assert models["image_vae"]["divergence_weight"] == 0.001
    assert models["image_vae"]["training"]["weight_decay"] == 1e-5
    assert models["mesh_vae"]["filters"] == [16, 16, 16, 32]
    assert (models["mesh_vae"]["order"], models["mesh_vae"]["latent"]) == (6, 128)
    assert models["mesh_vae"]["divergence_weight"] == 0.005
    assert recipe.training("mesh_vae").batch_size == 128
    assert {recipe.training(name).batch_size for name in ("projection", "force_head")} == {512}
    assert models["projection"]["dropout"] == [0.2, 0.4]
    for name in ("image_vae", "mesh_vae"):
        options = recipe.training(name)
        assert (options.learning_rate, options.decay, options.epochs) == (0.001, 0.99, 300)


def test_defaults_fit_the_schema():
    """Every default has its place in schemas/recipe.json, and every model's section there its default."""
    document = {name: value for name, value in DEFAULTS.items() if name not in ("table", "rows")}
    rows = {name: value for name, value in DEFAULTS["rows"].items() if value is not None}
    whole = {"format": "tactiledata-recipe/1", "title": "t", **document, "rows": rows}
    check_document(whole, "recipe", "defaults")
    schema = load_schema("recipe")["$defs"]
    for section in ("data", "models", "rows"):
        assert set(schema[section]["properties"]) == set(DEFAULTS[section])


@pytest.mark.parametrize(
    ("change", "path"),
    [
        ({"sede": 3}, r"\$: .*'sede'"),
        ({"models": {"image_vae": {"chanels": [1]}}}, r"\$\.models\.image_vae: .*'chanels'"),
        ({"data": {"store": "ds.zarr", "split": {"by": ["sensor"]}}}, r"\$\.data\.split\.by"),
        ({"table": "fources"}, r"\$\.table"),
        ({"scales": {"large": {}}}, r"\$\.scales"),
    ],
)
def test_unknown_words_are_refused(tmp_path, change, path):
    """Unknown words are refused with their place in the document."""
    with pytest.raises(SchemaError, match=path):
        load_recipe(written(tmp_path, {**tiny_recipe("ds.zarr", "mesh"), **change}))


def test_scales_and_included_recipes_are_laid_over(tmp_path):
    """The recipe lies over the included one, and its scale on top; lists replace."""
    below = tiny_recipe("ds.zarr", "mesh")
    del below["table"]
    below["scales"] = {"small": {"seed": 7, "data": {"image_size": [80, 60]}}}
    written(tmp_path, below, "below.yaml")
    above = {
        "format": "tactiledata-recipe/1", "title": "above", "include": "below.yaml", "table": "force",
        "models": {"mesh_vae": {"latent": 9}}, "scales": {"small": {"seed": 8}},
    }  # fmt: skip
    path = written(tmp_path, above, "above.yaml")
    small, paper = load_recipe(path, "small"), load_recipe(path, "paper")
    assert (small.seed, paper.seed) == (8, 0)
    assert (small.data["image_size"], paper.data["image_size"]) == ([80, 60], [40, 30])
    assert small.models["mesh_vae"]["latent"] == 9
    assert small.models["mesh_vae"]["filters"] == [4, 4, 4, 8]
    assert small.table == "force"
    assert small.digest != paper.digest
    above["include"] = "above.yaml"
    with pytest.raises(SchemaError, match="includes another recipe"):
        load_recipe(written(tmp_path, above, "above.yaml"))


def test_held_out_units_replace(tmp_path):
    """Units to hold out are a value, not a section to be merged."""
    assert laid_over({"hold_out": {"sensor": ["A"]}}, {"hold_out": {"indenter": ["x"]}}) == {
        "hold_out": {"indenter": ["x"]}
    }


def test_data_are_named_once(tmp_path):
    """Neither store nor world, or both, is wrong usage; so are names and scales that do not exist."""
    for data in ({}, {"store": "ds.zarr", "world": "tiny"}):
        with pytest.raises(UsageError, match="store"):
            load_recipe(written(tmp_path, {"format": "tactiledata-recipe/1", "title": "t", "data": data}))
    with pytest.raises(UnknownName, match="unknown scale 'huge'"):
        load_recipe("x", "huge")
    with pytest.raises(UnknownName, match="unknown recipe 'tabel_mesh'"):
        load_recipe("tabel_mesh")
    with pytest.raises(MissingFile):
        load_recipe(tmp_path / "none.yaml")


def test_a_recipe_file_named_without_its_ending_is_proposed(tmp_path, monkeypatch):
    """The stem of a file that is there is no recipe; the message says to name the file with its ending."""
    monkeypatch.chdir(tmp_path)
    file = written(
        tmp_path, {"format": "tactiledata-recipe/1", "title": "t", "data": {"store": "ds.zarr"}}, "mine.yaml"
    )
    with pytest.raises(UnknownName, match=r"A file mine\.yaml is there: name it with its ending\."):
        load_recipe("mine")
    assert load_recipe("mine.yaml").asked == "mine.yaml"
    assert load_recipe(file).name == "mine"


@pytest.mark.parametrize("name", bundled_recipes())
@pytest.mark.parametrize("scale", SCALES)
def test_bundled_recipes_load(name, scale):
    """Bundled recipes load at both scales, and those of tables share one backbone."""
    recipe = load_recipe(name, scale)
    assert recipe.name == name
    if recipe.table:
        backbone = load_recipe("split_backbone", scale)
        assert recipe.data == backbone.data
        assert recipe.models == backbone.models
