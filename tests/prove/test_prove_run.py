"""A proof end to end by the command: killed at any moment it goes on, and its parts fit."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from sealed_proofs import REQUEST, said, sealed_proof
from typer.testing import CliRunner

from tactiledata.cli import prove as prove_command
from tactiledata.cli.main import app
from tactiledata.diagnose.touches.variant_plays import variants_of
from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.simulator import unbalanced
from tactiledata.errors import UsageError
from tactiledata.prove.answers import tasks
from tactiledata.prove.answers.failed import failed_answer
from tactiledata.prove.cases.configuration import Configuration
from tactiledata.prove.cases.draw import is_of_kind
from tactiledata.prove.cases.kinds import Sight
from tactiledata.prove.cases.oracle import PaperCalibration
from tactiledata.prove.cases.strengths import drawn_parameters
from tactiledata.prove.request import QUICK, ProofRequest
from tactiledata.prove.run import ProofRun
from tactiledata.prove.seal.folder import ProofFolder
from tactiledata.prove.seal.published import opened_proof
from tactiledata.prove.seal.verify import scored_cases, verify
from tactiledata.prove.worlds import played_plan
from tactiledata.prove.worlds.plan_names import named_plan
from tactiledata.rig.hidden.effects import HIDDEN_EFFECTS

PROOFS = Path(__file__).parents[2] / "docs" / "proofs"
COMMAND = [sys.executable, "-c", "from tactiledata.cli.main import run; run()", "prove"]
CASES = ["--generators", "analytic", "--plans", "coarse-0", "--mismatch", "0", "--nulls", "1", "--drawn", "1"]
CASES += ["--no-variants"]  # of a coarse plan, no candidate needs another gel


def killed_after(words, environment, is_reached, limit=900):
    """Start the command, and kill it once something is reached."""
    process = subprocess.Popen(words, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    end = time.monotonic() + limit
    while not is_reached() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.05)
    assert process.poll() is None, "the command ended before it could be killed"
    os.kill(process.pid, signal.SIGKILL)
    process.wait()


@pytest.mark.slow
def test_a_killed_proof_goes_on_and_fits(tmp_path, monkeypatch):
    """Killed while it draws, and while it diagnoses, a proof keeps what it has, lists attempts, and verifies."""
    folder = ProofFolder(tmp_path / "proof")
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path / "cache"))
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    words = [*COMMAND, "--out", str(folder.path), *CASES, "--effects", "lag"]
    killed_after(words, environment, folder.draw(0).exists)
    first = folder.draw(0).read_bytes()
    killed_after(words, environment, lambda: len(list((folder.path / "attempts").glob("*.json"))) == 2)
    root = json.loads(folder.seal.read_text())["root"]
    # in this process, which need not import everything once more
    done = CliRunner().invoke(app, words[len(COMMAND) - 1 :])
    assert done.exit_code == 0, done.output
    assert "Targets" in done.output
    assert folder.draw(0).read_bytes() == first
    found = verify(folder, root)
    assert found.faults == ()
    assert found.answers == 2
    assert any("begun 2 times" in note for note in found.notes)
    assert "simulated recordings" in folder.page.read_text()
    # once more with the same options: nothing is diagnosed again; a case that is asked for again is listed
    case = sorted(json.loads(folder.labels.read_text()))[0]
    before = len(list((folder.path / "attempts").glob("*.json")))
    for more, count in (([], 0), (["--again", case], 1)):
        done = CliRunner().invoke(app, ["prove", "--out", str(folder.path), *more])
        assert done.exit_code == 0, done.output
        assert len(list((folder.path / "attempts").glob("*.json"))) == before + count
    assert any(case in note and "answered 2 times" in note for note in verify(folder).notes)


@pytest.mark.slow
def test_the_root_is_known_before_the_first_answer(tmp_path, monkeypatch):
    """The option --seal-only prints the root and gives no answer; a later run answers under the same root."""
    folder = ProofFolder(tmp_path / "proof")
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path / "cache"))
    words = ["prove", "--out", str(folder.path)]
    done = CliRunner().invoke(app, [*words, *CASES, "--effects", "lag", "--seal-only"])
    assert done.exit_code == 0, done.output
    root = json.loads(folder.seal.read_text())["root"]
    assert root in done.output
    assert "next: publish the root" in done.output
    assert not list(folder.path.glob("answers/*"))
    assert not list(folder.path.glob("attempts/*"))
    done = CliRunner().invoke(app, [*words, "--seal-only", "--json"])
    assert json.loads(done.output) == {"root": root, "cases": 2}
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    found = verify(folder, root)
    assert (found.faults, found.answers) == ((), 2)


@pytest.mark.slow
def test_other_gels_are_played_where_effects_take_part_that_need_them(tmp_path, monkeypatch):
    """A proof plays the other gels of all effects if it is told to, and no other gel if it is not."""
    asked = []

    def play(*given, estimates, full):
        asked.append(set(given[-1]))
        raise KeyboardInterrupt

    monkeypatch.setattr(played_plan, "play_touches", play)
    for with_variants in (True, False):
        with pytest.raises(KeyboardInterrupt):
            played_plan.PlayedPlan.of(named_plan("coarse-0"), tmp_path, with_variants)
    assert asked == [set(variants_of(EFFECTS)), set()]
    assert len(asked[0]) > 5


@pytest.mark.slow
def test_a_diagnosis_that_fails_is_an_answer_and_the_others_go_on(tmp_path, monkeypatch):
    """Its case is never right, its error is told, it says no probability, and the score is made; a check finds it."""
    folder, told = sealed_proof(tmp_path / "proof"), []
    seal = json.loads(folder.seal.read_text())
    failing = sorted(seal["cases"])[:2]

    def named(played, readings, pairs, in_full):
        if played in failing:
            raise unbalanced(0.017, 30)
        return SimpleNamespace(document=said([]))

    monkeypatch.setattr(tasks, "named_world", named)
    monkeypatch.setattr(tasks, "case_readings", lambda folder, name: [])
    for name in seal["cases"]:
        monkeypatch.setattr(tasks, "played_plan", lambda plan, bank, with_variants, name=name: name)
        tasks.answer(tasks.AnswerTask(folder, name, 1, "coarse-0", tmp_path, seal["tool"]["digest"], True, True, False))
    run = ProofRun(folder, REQUEST, tmp_path, tell=told.append)
    score = run.score()
    assert sum(row.get("failed", 0) for row in score["outcomes"].values()) == 2
    assert score["cases"] == 12
    assert sum(row["count"] for row in score["probabilities"]["rows"]) == 10
    failed = [line for line in score["misses"] if "failed" in line]
    assert len(failed) == 2
    assert all("the diagnosis ended in an error: gel and springs find no balance" in line for line in failed)
    assert {line.split()[0] for line in failed} == set(failing)
    # a run whose cases all have answers diagnoses none of them again, and `--verify` finds the same score
    run.answer(seal)
    assert not told
    assert not verify(folder).faults


def test_an_answer_after_an_error_has_the_keys_of_every_answer():
    """What reads answers finds in it whatever an answer of a published proof has."""
    with opened_proof(max(PROOFS.glob("*.zip"))) as folder:
        found = [case.answer for case in scored_cases(folder)]
    assert found
    assert all(set(failed_answer(unbalanced(0.017, 30))) == set(answer) for answer in found)


@pytest.mark.slow
def test_what_failed_is_printed(tmp_path, monkeypatch):
    """The line of a case says by which error its diagnosis ended, where an answer says that it has no name."""
    folder = sealed_proof(tmp_path / "proof")
    name = sorted(json.loads(folder.labels.read_text()))[0]
    task = tasks.AnswerTask(folder, name, 1, "coarse-0", tmp_path, "0" * 64, True, True, False)

    def named(played, readings, pairs, in_full):
        raise unbalanced(0.017, 30)

    monkeypatch.setattr(tasks, "played_plan", lambda plan, bank, with_variants: plan)
    monkeypatch.setattr(tasks, "named_world", named)
    assert tasks.answer(task)["said"].startswith("the diagnosis ended in an error: gel and springs")
    # asked again, it is read from its file
    assert tasks.answer(task)["said"].startswith("the diagnosis ended in an error: gel and springs")
    assert tasks._printed({"case": name, "seconds": 1.0, "answer": said([])})["said"] == "no name"


@pytest.mark.slow
def test_a_diagnosis_sees_readings_and_plan_alone(tmp_path, monkeypatch):
    """The task of a diagnosis works in a folder without labels, draws and seal: it reads the case, and no more."""
    folder = sealed_proof(tmp_path / "proof")
    name = sorted(json.loads(folder.labels.read_text()))[0]
    shutil.rmtree(folder.path / "sealed")
    folder.seal.unlink()
    seen = []

    def named(played, readings, pairs, in_full):
        seen.append((played, [one.values.shape for one in readings]))
        return SimpleNamespace(document=said([]))

    monkeypatch.setattr(tasks, "played_plan", lambda plan, bank, with_variants: plan)
    monkeypatch.setattr(tasks, "named_world", named)
    task = tasks.AnswerTask(folder, name, 1, "coarse-0", tmp_path, "0" * 64, True, True, False)
    assert tasks.answer(task)["verdict"] == "nothing found"
    assert seen == [("coarse-0", [(50, 6)])]
    assert {path.name for path in folder.path.iterdir()} == {"proof.json", "cases", "attempts", "answers"}


@pytest.mark.slow
def test_wrong_usage_is_refused(tmp_path):
    """Unknown generators, plans, effects and folders with other files are refused before any work."""
    out = ["prove", "--out", str(tmp_path / "x")]
    for words in (
        ["prove"],
        ["prove", "--out", "a", "--verify", "b"],
        out,
        [*out, "--nulls", "1", "--generators", "magic"],
        [*out, "--nulls", "1", "--plans", "wedge-2x3"],
        [*out, "--nulls", "1", "--plans", "../../etc"],
        [*out, "--nulls", "1", "--effects", "magic"],
        [*out, "--nulls", "1", "--mismatch", "nan"],
        [*out, "--nulls", "1", "--noise", "much"],
        [*out, "--root", "0"],
        [*out, "--seal-only", "--again", "0a"],
    ):
        assert isinstance(CliRunner().invoke(app, words).exception, UsageError), words
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / "letter.txt").write_text("mine")
    done = CliRunner().invoke(app, [*out, "--nulls", "1", "--plans", "coarse-0"])
    assert "other files" in str(done.exception)


@pytest.mark.parametrize(
    ("words", "counts"),
    [
        ([], QUICK.counts),
        (["--nulls", "5"], {**QUICK.counts, "nulls": 5}),
        (["--pairs", "0", "--drawn", "2"], {"nulls": 4, "visible": 3, "concealed": 1, "outside": 1, "drawn": 2}),
    ],
)
def test_counts_beside_quick_keep_its_other_cases(tmp_path, monkeypatch, words, counts):
    """A count that is typed is that of its kind; kinds that are not typed keep their number."""
    asked = []
    monkeypatch.setattr(prove_command, "_run", lambda folder, request, *given: asked.append(request.counts))
    done = CliRunner().invoke(app, ["prove", "--out", str(tmp_path / "x"), "--quick", *words])
    assert done.exit_code == 0, done.exception
    assert asked == [counts]


def test_requests_survive_their_document():
    """A request is the same after it was written and read; its cases are those that were asked for."""
    for request in (QUICK, ProofRequest(mismatches=(0.0, 2.0), counts={"nulls": 2, "pairs": 1}, only=("lag",))):
        assert ProofRequest.of(json.loads(json.dumps(request.document))).document == request.document
    requests = QUICK.requests("bank")
    assert len(requests) == 20
    assert len({one.configuration for one in requests}) == 2
    assert [one.number for one in requests] == list(range(20))


def test_strengths_are_drawn_over_and_beyond_the_range():
    """Half of a wide range of strengths lies outside the rig's own, and the logarithm is even."""
    member = HIDDEN_EFFECTS["lag"]
    name = next(iter(member.STRENGTHS["weak"]))
    weak, strong = member.STRENGTHS["weak"][name], member.STRENGTHS["strong"][name]
    inside = [drawn_parameters("lag", seed)[name] for seed in range(200)]
    wide = [drawn_parameters("lag", seed, 2.0)[name] for seed in range(200)]
    assert min(weak, strong) <= min(inside) <= max(inside) <= max(weak, strong)
    assert min(wide) < min(weak, strong)
    assert max(wide) > max(weak, strong)
    assert min(weak, strong) / 2 <= min(wide) <= max(wide) <= 2 * max(weak, strong)


@pytest.mark.parametrize(
    ("kind", "signal", "absorbed", "ratio", "expected"),
    [
        ("visible", 20.0, 0.1, 2.0, True),
        ("visible", 20.0, 0.9, 1.0, True),
        ("visible", 5.0, 0.1, 2.0, False),
        ("concealed", 20.0, 0.1, 1.1, True),
        ("concealed", 20.0, 0.1, 2.0, False),
        ("concealed", 5.0, 0.9, 1.0, False),
        ("outside", 20.0, 0.9, 1.0, True),
        ("drawn", 0.1, 0.9, 1.0, True),
    ],
)
def test_kinds_are_decided_by_what_can_be_seen(kind, signal, absorbed, ratio, expected):
    """Visible needs a signal, concealed one that a calibration hides as well; neither is too weak."""
    assert is_of_kind(kind, Sight(signal, absorbed, ratio), [], ["lag"]) is expected


def test_pairs_and_ambiguous_effects_need_more():
    """Both of a pair must be seen alone; an ambiguous effect needs another one that data cannot tell from it.

    With a cosine of 0.99 a signal of 20 leaves 2.8, and one of 30 leaves 4.2, of which 4 tell effects apart.
    """
    seen, weak = Sight(20.0, 0.1, 2.0), Sight(4.0, 0.1, 2.0)
    assert is_of_kind("pairs", seen, [seen, seen], ["lag", "dome"])
    assert not is_of_kind("pairs", seen, [seen, weak], ["lag", "dome"])
    assert not is_of_kind("ambiguous", Sight(20.0, 0.1, 2.0, {"lag": 1.0}), [], ["lag"])
    assert is_of_kind("ambiguous", Sight(20.0, 0.1, 2.0, {"lag": 1.0, "clock_skew": 0.99}), [], ["lag"])
    assert not is_of_kind("ambiguous", Sight(30.0, 0.1, 2.0, {"lag": 1.0, "clock_skew": 0.99}), [], ["lag"])


def test_the_papers_calibration_finds_the_best_modulus():
    """The weighted median gives the smallest mean difference of norms of all moduli."""
    import numpy as np

    chance = np.random.default_rng(0)
    norms = chance.uniform(0.0, 1e-6, size=(1, 40))
    wrench = np.concatenate(
        [1e6 * norms[0][:, None] * [0, 0, 1] + chance.normal(0, 0.05, (40, 3)), np.zeros((40, 3))], 1
    )
    measured = np.linalg.norm(wrench[:, :3], axis=1)
    least = min(np.abs(measured - modulus * norms[0]).mean() for modulus in np.linspace(5e5, 1.5e6, 4001))
    assert PaperCalibration(norms).loss([wrench]) == pytest.approx(least, rel=1e-3)


def test_a_configuration_says_what_it_does_not_draw():
    """Solvers leave out what they would solve anew for every world; closed forms draw everything."""
    assert Configuration("analytic", "wedge-2").not_drawn == ()
    assert "thickness" in Configuration("layer", "wedge-2").not_drawn


def test_plans_have_names():
    """A plan of fewer touches has the first ones of the whole plan."""
    whole, part = named_plan("wedge-2").touches, named_plan("wedge-2x14").touches
    assert len(whole) == 36
    assert [one["steps"] for one in part] == [one["steps"] for one in whole[:14]]
    assert {one["sensor"] for one in part} == {"D20542", "D20571"}
