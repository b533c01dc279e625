"""The table of domain alignment: its command, its laws on planted transfers, and what it refuses."""

import dataclasses
import json

import numpy as np
import pytest
import torch
import yaml
from cli.command import run_command
from store.random_takes import random_take
from touch_world import UNSEEN, tiny_recipe

from split_models.learning.data import TouchFrames
from split_models.recipe.recipe import load_recipe
from split_models.recipe.recipe_run import RecipeRun
from split_models.tables.alignment_pictures import AS_RECORDED
from split_models.tables.domain_alignment import alignment_rows, prepare_alignment
from split_models.tables.paired_truth import overlap, paired_values
from split_models.tables.recorded_title import recorded_row
from split_models.tables.unit_frames import UnitFrames, paired_frames, spread_evenly
from tactiledata.errors import MissingFile, UnknownName, UsageError
from tactiledata.store.layout.places import staging_folder
from tactiledata.store.write.commit import commit, create
from tactiledata.store.write.spool import Spool
from tactiledata.store.write.writer import stage

SOURCES = ["D20001", "D20002"]
ROWS = {
    "sources": SOURCES,
    "targets": {"A": UNSEEN},
    "frames": 6,
    "pairs": 6,
    "parts": ["train", "test", "test_unseen"],
}


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    return tmp_path_factory.mktemp("aligned")


def recipe_file(folder, store, **changes):
    document = tiny_recipe(store, "domain_alignment", **{**ROWS, **changes})
    document["data"]["image_size"] = [40, 40]  # style distances need 32 px a side
    document["variants"] = {"other": {"image_vae": {"latent": 6}}}
    path = folder / "alignment.yaml"
    path.write_text(yaml.safe_dump(document))
    return path


def recipe_run(folder, store, out, **changes):
    return RecipeRun(load_recipe(recipe_file(folder, store, **changes)), out, torch.device("cpu"))


@pytest.mark.slow
def test_the_command_makes_table_and_pictures(touch_store, out, capsys):
    """Every method against the target, over all sources and by source, both style names never together."""
    code, printed, err = run_command(capsys, "run", str(recipe_file(out, touch_store)), "--out", str(out), "--json")
    assert code == 0, err
    document = json.loads(printed)
    rows = {(row["part"], row["method"]): row["scores"] for row in document["rows"]}
    part = f"A: {UNSEEN}, mean over sources"
    real, synth = rows[part, "as recorded (simulated recordings)"], rows[part, "background swap (Synth.)"]
    compared = {
        f"{name}{where}"
        for name in ("histogram_intersection", "histogram_correlation", "gram_style_random")
        for where in ("", "_contact")
    }
    assert set(real) == compared
    assert set(synth) == compared | {"strength_kept", "change_correlation", "mask_overlap"}
    assert synth["mask_overlap"]["value"] > 0.9
    lost = rows[part, "target background without contact (Synth.)"]
    assert lost["strength_kept"]["value"] == 0.0
    assert synth["histogram_intersection"]["value"] > real["histogram_intersection"]["value"]
    assert synth["gram_style_random"]["value"] < real["gram_style_random"]["value"]
    by_source = [row for row in document["rows"] if row["part"].endswith("by source")]
    assert [row["source"] for row in by_source] == [name for name in SOURCES for _ in range(13)]
    kept = out / "alignment" / "small"
    assert (kept / "tsne.png").stat().st_size > 0
    assert (kept / f"strip-D20001-{UNSEEN}.png").stat().st_size > 0
    latent = [row for row in document["rows"] if row["part"] == "latent vectors"]
    assert {name for row in latent for name in row["scores"]} == {"silhouette", "knn_mixing", "mmd"}
    assert any("Z_image, D20001 to A against A" in row["method"] for row in latent)


@pytest.mark.slow
def test_a_variant_has_rows_of_its_own(touch_store, out):
    """Its own model transfers, and its latent vectors stand beside the recipe's."""
    rows = alignment_rows(recipe_run(out, touch_store, out, methods=["latent", "other:latent"]))
    words = [row["method"] for row in rows if row["part"].endswith("over sources")]
    assert words == [
        "as recorded (simulated recordings)",
        "latent arithmetic (Synth.)",
        "latent arithmetic, other (Synth.)",
    ]
    kinds = {row["method"].partition(",")[0] for row in rows if row["part"] == "latent vectors"}
    assert kinds == {"Z_deform", "Z_image", "Z_deform (other)", "Z_image (other)"}
    values = [row["scores"]["gram_style_random"]["value"] for row in rows if row["part"].endswith("over sources")]
    assert len(set(values)) == 3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kinds", "title"),
    [
        (["simulated"] * 2, "as recorded (simulated recordings)"),
        (["simulated", "real"], "as recorded (simulated recordings: 1 of 2)"),
        (["real"] * 2, "as recorded (Real)"),
        (["real", None], "as recorded"),
        ([], "as recorded"),
    ],
)
def test_rows_are_real_only_where_recordings_are(tmp_path, kinds, title):
    """The paper's word stands over recordings that all state it, never over simulated ones or those that do not say."""
    create(tmp_path / "ds.zarr")
    for number, kind in enumerate(kinds):
        spool = Spool(staging_folder(tmp_path / "ds.zarr", f"{number:064x}"))
        stated = {} if kind is None else {"recorded_by": {"contact": kind}}
        take = dataclasses.replace(random_take(number, spool), sha256=f"{number:064x}", description=stated)
        commit(tmp_path / "ds.zarr", [stage(tmp_path / "ds.zarr", spool, take)])
    assert recorded_row(tmp_path / "ds.zarr") == title


@pytest.mark.slow
def test_the_table_says_what_it_was_recorded_of(touch_store, out):
    """The rig's touches are no real ones: the row of pictures as recorded says so."""
    rows = alignment_rows(recipe_run(out, touch_store, out, methods=["no_contact"]))
    assert {row["method"].rpartition(", ")[2] for row in rows if row.get("transfer") == AS_RECORDED} == {
        "as recorded (simulated recordings)"
    }


@pytest.mark.slow
def test_a_mean_over_sources_is_their_mean(touch_store, out):
    """Rows by source and the row over them tell of the same frames."""
    rows = alignment_rows(recipe_run(out, touch_store, out, methods=["no_contact"]))
    part = f"A: {UNSEEN}, "
    of = {
        (row["part"].removeprefix(part), row["source"]): row["scores"]["histogram_correlation"]
        for row in rows
        if row["part"].startswith(part) and row["transfer"] == AS_RECORDED
    }
    each = [of["by source", name] for name in SOURCES]
    total = sum(one["value"] * one["frames"] for one in each) / sum(one["frames"] for one in each)
    assert of["mean over sources", ""]["value"] == pytest.approx(total)


@pytest.mark.slow
def test_rows_are_compared_with_the_swap_frame_by_frame(touch_store, out):
    """Differences of means are means of differences, for both kinds of rows; a recipe's titles name them."""
    run = recipe_run(out, touch_store, out, methods=["no_contact", "background_swap"], titles={"no_contact": "nothing"})
    rows = alignment_rows(run)
    less = [row for row in rows if row["part"].endswith("each row less background swap (Synth.)")]
    assert {row["transfer"] for row in less} == {AS_RECORDED, "no_contact"}
    assert {row["part"].partition(", each row")[0] for row in less} >= {f"A: {UNSEEN}, mean over sources"}
    of = {(row["part"], row.get("transfer")): row["scores"] for row in rows}
    for row in less:
        part = row["part"].partition(", each row")[0]
        score = "histogram_correlation" if "mean" in part else "l1"
        own, swap = (of[part, name][score]["value"] for name in (row["transfer"], "background_swap"))
        assert row["scores"][score]["value"] == pytest.approx(own - swap)
        if row["transfer"] == "no_contact":
            assert row["method"] == "nothing (Synth.)"


@pytest.mark.parametrize(
    ("changes", "error", "says"),
    [
        ({"sources": None}, UsageError, "no sources"),
        ({"targets": None}, UsageError, "no targets"),
        ({"targets": {"A": "D20002"}}, UsageError, "D20002 as source and as target"),
        ({"methods": ["background_swop"]}, UnknownName, "Did you mean background_swap"),
        ({"methods": ["none:latent"]}, UnknownName, "variant"),
        ({"methods": ["other:background_swap"]}, UnknownName, "with a model"),
        ({"sources": ["D2001"]}, UnknownName, "Did you mean D20001"),
        ({"weights": "nowhere.pth"}, MissingFile, "nowhere.pth"),
    ],
)
def test_wrong_recipes_are_refused_in_words(touch_store, out, tmp_path, changes, error, says):
    """Before anything is learned or scored."""
    made = recipe_run(tmp_path, touch_store, out, **changes)
    with pytest.raises(error, match=says):
        _ = prepare_alignment(made).units


def test_the_same_moment_of_the_same_touch_is_paired(touch_store):
    """A unit is paired with itself frame by frame, with others only where touches have one name and one length."""
    parts = [TouchFrames(touch_store, f"default/{part}", size=(40, 40), mesh="") for part in ("train", "test_unseen")]
    one, other = UnitFrames(parts, "D20001"), UnitFrames(parts, UNSEEN)
    mine, same = paired_frames(one, one, 10_000)
    assert np.array_equal(mine, np.arange(len(one)))
    assert np.array_equal(same, mine)
    ours, theirs = paired_frames(one, other, 10_000)
    assert (one.touches[ours] == other.touches[theirs]).all()
    assert (one.moments[ours] == other.moments[theirs]).all()
    numbers = spread_evenly(len(one), 5)
    assert (numbers[0], numbers[-1], len(numbers)) == (0, len(one) - 1, 5)
    everything = np.concatenate([frames.pictures(np.flatnonzero(frames.sensors == "D20001")) for frames in parts])
    assert np.array_equal(one.pictures(numbers[::-1]), everything[numbers[::-1]])


def test_truth_scores_best_and_no_contact_has_no_geometry():
    """The truth itself is perfect; a background is far off and overlaps nothing; a wrong shade costs no geometry."""
    background = np.full((40, 40, 3), 90, np.uint8)
    truth = np.stack([background] * 2)
    truth[:, 10:20, 12:24] += 60
    perfect = paired_values(truth, truth, background, background)
    assert all((perfect[name] == 1).all() for name in ("ssim", "ssim_contact", "overlap", "overlap_of_change"))
    nothing = paired_values(np.stack([background] * 2), truth, background, background)
    assert (nothing["overlap"] == 0).all()
    assert (nothing["l1_contact"] > nothing["l1"]).all()
    darker = paired_values(truth - 20, truth, background, background - 20)
    assert (darker["overlap_of_change"] == 1).all()
    assert (darker["overlap"] < 0.3).all()


def test_overlap_of_nothing_has_no_value():
    """A truth without a contact has nothing to overlap with."""
    empty, whole = np.zeros((1, 4, 4), bool), np.ones((1, 4, 4), bool)
    assert np.isnan(overlap(whole, empty)).all()
    assert overlap(empty, whole) == 0
