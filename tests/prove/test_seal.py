"""A sealed proof: one changed label, reading, answer, attempt, threshold or score is found, and named."""

import dataclasses
import json
import shutil

import numpy as np
import pytest
from command import run_command
from sealed_proofs import REQUEST, answer_case, answered_proof, said, sealed_proof

from tactiledata.cli.main import app
from tactiledata.contract.sealed import sealed_json
from tactiledata.diagnose.naming import options as naming_options
from tactiledata.errors import StoreError, TactileDataError, UnsafeContent, UsageError
from tactiledata.prove.run import ProofRun
from tactiledata.prove.seal import sealing
from tactiledata.prove.seal.compare import compare
from tactiledata.prove.seal.folder import ProofFolder
from tactiledata.prove.seal.leak import find_leak, leak_of
from tactiledata.prove.seal.merkle import commitment, merkle_root, new_salt
from tactiledata.prove.seal.verify import verify


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """An answered proof; read only."""
    return answered_proof(tmp_path_factory.mktemp("whole") / "proof")


@pytest.fixture
def proof(whole, tmp_path):
    """A copy of it that a test may change."""
    shutil.copytree(whole.path, tmp_path / "proof")
    return ProofFolder(tmp_path / "proof")


def changed(path, change, seal=False):
    """Change the document in a file; with ``seal`` its own digest is made to fit again."""
    document = json.loads(path.read_text())
    change(document)
    path.write_bytes(sealed_json(document) if seal else json.dumps(document).encode())


def a_name(proof):
    """Name of a case."""
    return sorted(json.loads(proof.labels.read_text()))[3]


def test_a_whole_proof_fits(whole):
    """Nothing is found where nothing was changed, and the score follows from labels and answers."""
    found = verify(whole)
    assert found.faults == ()
    assert (found.cases, found.answers) == (12, 12)
    assert found.score["outcomes"] == {"nulls": {"nothing found": 6}, "visible": {"missed": 1, "named": 5}}
    assert len(found.score["misses"]) == 1


@pytest.mark.parametrize("field", ["truth", "kind", "seed", "salt"])
def test_a_changed_label_is_found(proof, field):
    """A changed label or salt does not fit its commitment, and its case is named."""
    name = a_name(proof)

    def change(labels):
        if field == "salt":
            labels[name]["salt"] = new_salt()
        else:
            labels[name]["label"][field] = "other"

    changed(proof.labels, change)
    assert any(name in fault and "label" in fault for fault in verify(proof).faults)


def test_a_changed_answer_is_found(proof):
    """A changed answer is named, whether or not its own digest was made to fit again."""
    name = a_name(proof)
    for seal in (False, True):
        changed(proof.answer(name, 1), lambda document: document["answer"].update(verdict="not explained"), seal)
        faults = verify(proof).faults
        assert any(name in fault for fault in faults) or seal
        assert any("The answers are not those that were scored" in fault for fault in faults)


def test_a_changed_threshold_in_the_seal_is_found(proof):
    """A threshold that was changed in the seal is named with both values, even if the file's digest fits again."""

    def change(document):
        document["tool"]["numbers"]["thresholds"]["usual_claim"] = 1.0

    changed(proof.seal, change, seal=True)
    faults = verify(proof).faults
    assert any("usual_claim" in fault and "1.0" in fault for fault in faults)


def test_a_changed_threshold_of_the_tool_is_found(proof, monkeypatch):
    """A proof is not gone on with after a threshold was changed; a check says which one differs here."""
    other = dataclasses.replace(naming_options.DEFAULT_THRESHOLDS, usual_claim=3.0)
    options = naming_options.NamingOptions
    monkeypatch.setattr(naming_options, "NamingOptions", lambda: options(thresholds=other))
    with pytest.raises(UsageError, match=r"usual_claim is 3\.0, was 12\.0"):
        sealing.need_frozen_tool(sealing.read_seal(proof))
    assert any("usual_claim is 3.0" in note for note in verify(proof).notes)
    answer_case(proof, a_name(proof), said([]), 2)
    changed(proof.answer(a_name(proof), 2), lambda document: document.update(tool="0" * 64), seal=True)
    assert any("another tool" in fault for fault in verify(proof).faults)


def test_changed_readings_and_requests_are_found(proof):
    """Readings, the request and the order of cases belong to the seal."""
    name = a_name(proof)
    content = bytearray(proof.case(name).read_bytes())
    content[len(content) // 2] ^= 1
    proof.case(name).write_bytes(content)
    changed(proof.proof, lambda document: document["request"].update(seed=5))
    faults = verify(proof).faults
    assert any(f"readings of case {name} were changed" in fault for fault in faults)
    assert any("proof.json" in fault for fault in faults)


def test_a_changed_score_is_found(proof):
    """A score that does not follow from labels and answers is found, also with a digest that fits."""
    changed(proof.score, lambda document: document["score"].update(misses=[]), seal=True)
    assert any("does not follow" in fault for fault in verify(proof).faults)


def test_reruns_and_broken_attempts_are_listed(proof):
    """A case that was answered twice, and one whose attempt gave no answer, are named; a lost attempt is a fault."""
    name, other, third = sorted(json.loads(proof.labels.read_text()))[:3]
    answer_case(proof, name, said(["lag"]), 2)
    (proof.path / "attempts" / f"{other}-2.json").write_text("{}")
    proof.attempt(third, 1).unlink()
    found = verify(proof)
    assert any(name in note and "answered 2 times" in note for note in found.notes)
    assert any(other in note and "begun 2 times" in note for note in found.notes)
    assert any(third in fault and "no attempt" in fault for fault in found.faults)


def test_a_published_root_finds_a_proof_that_was_sealed_anew(proof):
    """Whoever rewrites labels, commitments and root is found by the root that was published before."""
    root = json.loads(proof.seal.read_text())["root"]
    name = a_name(proof)
    changed(proof.labels, lambda labels: labels[name]["label"].update(seed=99))
    label = json.loads(proof.labels.read_text())[name]

    def seal_anew(document):
        document["cases"][name]["commitment"] = commitment(label["salt"], label["label"])
        entries = document["cases"].items()
        document["root"] = merkle_root(
            [f"{each} {one['commitment']} {one['readings_sha256']}" for each, one in sorted(entries)]
        )

    changed(proof.seal, seal_anew, seal=True)
    changed(proof.score, lambda score: score.update(root=json.loads(proof.seal.read_text())["root"]), seal=True)
    assert not any("root" in fault.lower() for fault in verify(proof).faults)
    assert any("published" in fault for fault in verify(proof, root).faults)


@pytest.mark.parametrize(
    ("change", "error"),
    [
        (lambda seal: seal.update(format="other"), StoreError),
        (lambda seal: seal.pop("cases"), StoreError),
        (lambda seal: seal["cases"].update({"0" * 16: 5}), StoreError),
        (lambda seal: seal["cases"].update({"../../x": dict(next(iter(seal["cases"].values())))}), UnsafeContent),
        (lambda seal: seal.update(tool=[]), StoreError),
        (lambda seal: seal["tool"].update(numbers=5), StoreError),
        (lambda seal: seal["tool"]["numbers"].update(thresholds=2.5), StoreError),
    ],
)
def test_a_seal_that_is_none_is_refused(proof, change, error):
    """Fields that are missing, of another type, or lead out of the folder are refused with a sentence."""
    changed(proof.seal, change, seal=True)
    with pytest.raises(error):
        verify(proof)


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'"text"', b"null", b"\xff\xfe", b"[" * 100_000])
def test_files_that_are_no_documents_are_refused(proof, content):
    """Labels, seals and answers that hold anything else end in an error of ours, or are named as faults."""
    for path in (proof.answer(a_name(proof), 1), proof.score, proof.labels, proof.seal):
        path.write_bytes(content)
        try:
            assert verify(proof).faults
        except TactileDataError:
            continue


@pytest.mark.parametrize("number", ["NaN", "-Infinity", "1e999", '"\\ud800"'], ids=["nan", "infinite", "large", "half"])
@pytest.mark.parametrize("which", ["proof", "seal", "labels", "answer"])
def test_values_that_have_no_digest_are_refused(proof, which, number):
    """Numbers that are not finite, and halves of letters, are refused with the file's name."""
    path = proof.answer(a_name(proof), 1) if which == "answer" else getattr(proof, which)
    document = path.read_text().rstrip()
    path.write_text(f'{document[:-1].rstrip()}, "more": {number}}}')
    with pytest.raises(StoreError, match=f"{path.name} is no JSON"):
        verify(proof)


@pytest.mark.slow
def test_the_command_exits_with_1_where_something_does_not_fit(proof):
    """`prove --verify` prints what does not fit and exits with 1; a whole proof gives 0."""
    from typer.testing import CliRunner

    done = CliRunner().invoke(app, ["prove", "--verify", str(proof.path)])
    assert done.exit_code == 0, done.output
    assert "All hashes and the score fit" in done.output
    changed(proof.labels, lambda labels: labels[a_name(proof)]["label"].update(seed=99))
    done = CliRunner().invoke(app, ["prove", "--verify", str(proof.path), "--json"])
    assert done.exit_code == 1
    assert a_name(proof) in json.loads(done.output)["faults"][0]


def test_answers_of_two_machines_are_compared_case_by_case(proof, tmp_path):
    """Verdicts, names and sets that differ are counted and told; the order of names does not count, nor old answers."""
    other = ProofFolder(tmp_path / "other")
    shutil.copytree(proof.path, other.path)
    null, *_ = names = [name for name, one in json.loads(proof.labels.read_text()).items() if not one["label"]["truth"]]
    two = ["lag", "rate_friction"]
    answer_case(proof, null, said(two), 2)
    answer_case(other, null, said(["dome"]), 2)
    answer_case(other, null, said(two[::-1]), 3)
    same = compare(proof, other)
    assert (same.cases, same.agreed, same.differences) == (12, {"verdict": 12, "names": 12, "set": 12}, ())
    answer_case(other, names[1], said(["dome"]), 2)
    answer_case(other, names[2], {**said([]), "set": two[::-1]}, 2)
    found = compare(proof, other)
    assert found.agreed == {"verdict": 11, "names": 11, "set": 10}
    assert found.differences == tuple(sorted([
        f"{names[1]}: verdict: nothing found in the first, explained in the second; named effects: none in the first,"
        " dome in the second; effects in the set: none in the first, dome in the second.",
        f"{names[2]}: effects in the set: none in the first, lag and rate_friction in the second.",
    ]))  # fmt: skip
    low, high = found.document["agreed"]["set"]["interval"]
    assert low < 10 / 12 < high


@pytest.mark.slow
def test_the_command_compares_answers_and_refuses_another_proof(whole, proof, tmp_path, capsys):
    """Differences are printed, as JSON too; folders of two proofs, or without answers, are not compared."""
    name = a_name(proof)
    answer_case(proof, name, said(["dome"]), 2)
    check = ("prove", "--verify", whole.path, "--against")
    code, printed, _ = run_command(capsys, *check, proof.path)
    assert code == 0
    assert "11 of 12" in printed
    assert f"differs: {name}: " in printed
    code, printed, _ = run_command(capsys, *check, proof.path, "--json")
    assert json.loads(printed)["compared"]["agreed"]["names"]["count"] == 11
    for other, words in (
        (sealed_proof(tmp_path / "anew").path, "two copies of one sealed proof"),
        (tmp_path, "missing"),
    ):
        code, _, error = run_command(capsys, *check, other)
        assert code != 0
        assert words in error
    assert run_command(capsys, "prove", "--out", tmp_path / "new", "--against", whole.path)[0] == 2
    shutil.rmtree(proof.path / "answers")
    with pytest.raises(UsageError, match="no case is answered"):
        compare(whole, proof)


def test_sealing_goes_on_where_it_was_killed(tmp_path, whole):
    """A second call after a kill keeps the names and salts of the first, and gives the same root."""
    folder = sealed_proof(tmp_path / "proof")
    before = json.loads(folder.seal.read_text())
    labels = json.loads(folder.labels.read_text())
    drawn = [{"number": one["draw"], "label": one["label"]} for one in labels.values()]
    folder.seal.unlink()
    folder.case(sorted(labels)[0]).unlink()
    after = sealing.seal_cases(folder, drawn, {str(number): "coarse-0" for number in range(12)}, {})
    assert after["root"] == before["root"]
    assert after["cases"] == before["cases"]


def test_another_request_is_refused(whole):
    """A folder goes on with its own request only."""
    with pytest.raises(UsageError, match="another request"):
        ProofRun(whole, dataclasses.replace(REQUEST, seed=7), whole.path).ask()


def test_a_merkle_root_depends_on_every_leaf():
    """Any changed, swapped, added or removed leaf gives another root; a leaf is no inner node."""
    chance = np.random.default_rng(0)
    for count in range(1, 9):
        leaves = [chance.bytes(8).hex() for _ in range(count)]
        root = merkle_root(leaves)
        for place in range(count):
            assert merkle_root([*leaves[:place], "x", *leaves[place + 1 :]]) != root
        assert merkle_root([*leaves, leaves[-1]]) != root
        assert merkle_root(leaves[:-1]) != root
        if count > 1:
            assert merkle_root([*leaves[1:], leaves[0]]) != root


@pytest.mark.slow
def test_sealed_cases_tell_nothing_by_their_files(tmp_path, monkeypatch):
    """A classifier stays at chance on names, sizes, stamps and order, and finds a leak that was planted.

    Names are drawn by a seed here: of truly random ones, one in twenty looks telling at this level.
    """
    chance = np.random.default_rng(0)
    monkeypatch.setattr(sealing.secrets, "token_hex", lambda count: chance.bytes(count).hex())
    clean = leak_of(sealed_proof(tmp_path / "clean"), draws=40)
    assert clean.p > 0.05
    leaking = leak_of(sealed_proof(tmp_path / "leaking", lambda kind: 50 if kind == "nulls" else 51), draws=40)
    assert leaking.p < 0.05
    assert leaking.accuracy > 0.9


@pytest.mark.slow
def test_a_leak_in_many_facts_is_found():
    """One telling fact among twenty is found; without it, nothing is."""
    chance = np.random.default_rng(1)
    kinds = ["nulls", "visible"] * 20
    facts = chance.normal(size=(40, 20))
    assert find_leak(facts, kinds, 40).p > 0.05
    facts[:, 7] = [kind == "nulls" for kind in kinds]
    assert find_leak(facts, kinds, 40).p < 0.05
