"""`diagnose STORE` on recorded touches, and what it says of stores that it cannot use."""

import html
import json
import sys

import pytest
import yaml
from recorded_touches import recorded_store

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.cli.main import run
from tactiledata.contract.schema import check_document
from tactiledata.diagnose import store as diagnose_store
from tactiledata.diagnose.options import DiagnosisOptions
from tactiledata.diagnose.touches.store_touches import store_touches
from tactiledata.diagnose.touches.variant_plays import design_variants, variants_of
from tactiledata.diagnose.zeros.causes import ZeroCause
from tactiledata.effects import EFFECTS
from tactiledata.gel.mesh import structured_pad
from tactiledata.gel.mesh.structured_pad import GridPlan
from tactiledata.replay.opened import OpenedStore
from tactiledata.store.read.reader import Store

COARSE = GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0))


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return recorded_store(tmp_path_factory.mktemp("world"))


@pytest.fixture(scope="module")
def few(tmp_path_factory):
    """A store of the same world with too few touches for a diagnosis."""
    return recorded_store(tmp_path_factory.mktemp("few"), generate={"count": 3, "depth": [0.0004, 0.0005]})


@pytest.fixture(autouse=True)
def coarse_and_kept(tmp_path_factory, monkeypatch):
    monkeypatch.setitem(structured_pad.PLANS, "low", COARSE)
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path_factory.getbasetemp() / "cache"))


def diagnosed(capsys, monkeypatch, *arguments):
    """Exit code, standard output and standard error."""
    monkeypatch.setattr(sys, "argv", ["tactiledata", "diagnose", *map(str, arguments)])
    with pytest.raises(SystemExit) as stop:
        run()
    printed = capsys.readouterr()
    return stop.value.code, printed.out, printed.err


@pytest.mark.slow
def test_a_store_is_diagnosed_from_end_to_end(store, tmp_path, capsys, monkeypatch):
    """A store gives sentences, a page and a document, the same bytes again, and the gate's exit code."""
    pytest.importorskip("matplotlib")
    given = (store, "--fidelity", "linear", "--effects", "lag,thickness", "--no-pairs")
    code, printed, _ = diagnosed(capsys, monkeypatch, *given, "--out", tmp_path / "first")
    assert code == 0
    document = json.loads((tmp_path / "first" / "diagnosis.json").read_text())
    check_document(document, "diagnosis", "the diagnosis")
    assert document["source"]["kind"] == "store"
    assert document["source"]["groups"] == 10
    assert document["sentences"][0] in printed
    page = (tmp_path / "first" / "report.html").read_text()
    assert page.count("data:image/png") >= 3
    assert page.count("Simulated recordings.</figcaption>") == page.count("<figcaption>")
    assert "(simulated recordings)</h1>" in page
    assert "Simulated recordings: all 10 trajectories." in printed
    assert document["simulated_recordings"] == {"simulated": 10, "real": 0, "not_stated": 0}
    assert document["zeros"] == []
    notes = " ".join(document["notes"])
    assert "not tried, because the gel plays this effect at --fidelity finite-strain only: " in notes
    assert "thickness of the gel" in notes
    for scenario in (tmp_path / "first").glob("next/*.yaml"):
        check_document(yaml.safe_load(scenario.read_text()), "scenario", scenario.name)
    code, printed, _ = diagnosed(capsys, monkeypatch, *given, "--out", tmp_path / "second", "--gate", "--json")
    assert code == (0 if document["answer"] in ("nothing found", "below detection") else 1)
    assert json.loads(printed) == document
    for name in ("report.html", "diagnosis.json"):
        assert (tmp_path / "first" / name).read_bytes() == (tmp_path / "second" / name).read_bytes()


@pytest.mark.slow
def test_the_page_says_all_that_the_document_says(store, tmp_path, capsys, monkeypatch):
    """Every sentence of the document is on the page, those on causes of the zero that matter first."""
    pytest.importorskip("matplotlib")
    cause = ZeroCause("tool_weight", 0.003, 0.4, 0.16, 0.1, {"mass": 0.03}, "In free air, a planted cause.")
    harmless = ZeroCause("sensor_drift", 0.003, 0.4, 0.1, 0.08, {"time": 300.0}, "In free air, a planted drift.", 0.004)
    monkeypatch.setattr(diagnose_store, "zero_causes", lambda zeros, seed, band: [harmless, cause])
    given = (store, "--fidelity", "linear", "--effects", "lag", "--no-pairs", "--gate")
    code, _, _ = diagnosed(capsys, monkeypatch, *given, "--out", tmp_path)
    assert code == 1
    document = json.loads((tmp_path / "diagnosis.json").read_text())
    assert document["sentences"][0] == cause.words
    assert document["sentences"].index(harmless.words) > 1
    assert [one["matters"] for one in document["zeros"]] == [False, True]
    page = html.unescape((tmp_path / "report.html").read_text())
    assert [sentence for sentence in document["sentences"] if sentence not in page] == []


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--trajectories", "5"), "at least 8"),
        (("--effects", "lagg"), "lag"),
        (("--fidelity", "fine"), "finite-strain or linear"),
        (("--bounds", "narrow"), "paper, wide"),
        (("--sensor", "D99999"), "D20542"),
        (("--indenter", "cube"), "ball3"),
        (("--seed", "-1"), "0 or more"),
    ],
)
def test_wrong_options_are_wrong_usage(few, capsys, monkeypatch, options, words):
    """A wrong option is wrong usage: the message names what may be given, even where the store holds too little."""
    code, _, said = diagnosed(capsys, monkeypatch, few, *options)
    assert code == 2
    assert words in said
    assert "Traceback" not in said


def test_too_few_trajectories_are_told_with_what_is_needed(few, capsys, monkeypatch):
    """A store with three trajectories exits with 1 and says that at least eight are needed."""
    code, _, said = diagnosed(capsys, monkeypatch, few, "--fidelity", "linear")
    assert code == 1
    assert "3 trajectories can be diagnosed" in said
    assert "at least 8" in said


def test_variants_are_those_that_effects_ask_for():
    """Variants of the gel are those at the design points of the chosen effects, each once."""
    asked = variants_of(EFFECTS)
    assert len(asked) == len(set(asked)) == sum(len(design_variants(EFFECTS[name]())) for name in EFFECTS)
    assert variants_of(["lag", "relaxation"]) == ()


@pytest.mark.parametrize("bounds", ["paper", "wide"])
def test_bounds_are_those_of_what_is_played(bounds):
    """E only multiplies plays: whatever the bounds of nu and mu, a diagnosis may move it as far as any gel goes."""
    stated, free = find_bounds(bounds), find_bounds(bounds).with_free_modulus
    assert (free.low[0], free.high[0]) == (find_bounds("wide").low[0], find_bounds("wide").high[0])
    assert (free.low[1:], free.high[1:], free.friction_nodes) == (
        stated.low[1:],
        stated.high[1:],
        stated.friction_nodes,
    )


@pytest.mark.slow
def test_a_store_is_diagnosed_with_e_free(store):
    """A store is diagnosed within the paper's bounds of nu and mu, and with E free beyond what a durometer reads."""
    options = DiagnosisOptions(fidelity="linear", effects=("lag",), pairs=False)
    box = store_touches(
        OpenedStore.planned(Store.open(store), options.calibration().pads), options.calibration()
    ).touch_set.box
    assert box == find_bounds("paper").with_free_modulus
