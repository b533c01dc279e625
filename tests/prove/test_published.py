"""Published proofs: an archive with all but the readings is checked as the folder is, and nothing else is read."""

import io
import json
import zipfile

import pytest
from command import run_command
from sealed_proofs import answered_proof, sealed_proof

from tactiledata.contract.sealed import sealed_json
from tactiledata.errors import StoreError, TactileDataError, UnsafeContent, UsageError
from tactiledata.prove.seal import published
from tactiledata.prove.seal.compare import compare
from tactiledata.prove.seal.published import opened_proof, publish
from tactiledata.prove.seal.verify import verify


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """An answered proof, and its archive; read only."""
    folder = answered_proof(tmp_path_factory.mktemp("whole") / "proof")
    publish(folder, folder.path.with_suffix(".zip"))
    return folder


def contents(path):
    """The files of an archive, by name."""
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def faults_of(folder):
    """What a check finds, or why nothing could be checked."""
    try:
        return verify(folder).faults
    except TactileDataError as error:
        return (str(error),)


def archived(path, files, kind=zipfile.ZIP_DEFLATED):
    """An archive of files (name, bytes)."""
    with zipfile.ZipFile(path, "w", kind) as archive:
        for name, content in files:
            archive.writestr(name, content)
    return path


def test_an_archive_is_checked_as_its_folder_is(whole):
    """An archive gives the score of its folder and no fault, holds no readings, and says that they were not checked."""
    archive = whole.path.with_suffix(".zip")
    with opened_proof(archive) as folder:
        found, place = verify(folder, look_for_leaks=True), folder.path
        assert compare(folder, whole).differences == ()
    assert found.faults == ()
    assert found.score == verify(whole).score
    assert [note for note in found.notes if "eadings" in note] == [
        "Readings are not in the archive: whether they fit their digests was not looked at."
    ]
    assert not place.exists()
    assert {name.partition("/")[0] for name in contents(archive)} == {
        "answers", "attempts", "proof.json", "score.json", "seal.json", "sealed",
    }  # fmt: skip


def test_the_same_proof_gives_the_same_bytes(whole, tmp_path):
    """Published again, from the folder or from its archive, it is the same file."""
    first = whole.path.with_suffix(".zip")
    publish(whole, tmp_path / "again.zip")
    with opened_proof(first) as folder:
        publish(folder, tmp_path / "copy.zip")
    assert first.read_bytes() == (tmp_path / "again.zip").read_bytes() == (tmp_path / "copy.zip").read_bytes()


@pytest.mark.parametrize(
    "part", ["answers/", "attempts/", "sealed/labels.json", "score.json", "seal.json", "proof.json"]
)
def test_what_was_changed_in_an_archive_is_found(whole, tmp_path, part):
    """Any change to an answer, an attempt, the labels, the score, the seal or the request is a fault."""
    files = contents(whole.path.with_suffix(".zip"))
    name = min(name for name in files if name.startswith(part))
    if part == "attempts/":
        del files[name]
    else:
        document = json.loads(files[name])
        _, last = max((str(type(value)), key) for key, value in document.items() if isinstance(value, dict | str))
        document[last] = {} if isinstance(document[last], dict) else "other"
        files[name] = sealed_json(document)
    with opened_proof(archived(tmp_path / "changed.zip", files.items())) as folder:
        assert faults_of(folder)


@pytest.mark.parametrize(
    "name", ["../answers/x.json", "/etc/passwd", "answers/", "answers/../proof.json", "cases/0123456789abcdef.npz", "x"]
)
def test_files_of_others_are_refused(whole, tmp_path, name):
    """A name that leads out of the folder, or that no proof has, is refused before anything is unpacked."""
    files = [*contents(whole.path.with_suffix(".zip")).items(), (name, b"{}")]
    with pytest.raises(UnsafeContent, match="none of ours"), opened_proof(archived(tmp_path / "odd.zip", files)):
        pass
    assert [place.name for place in tmp_path.iterdir()] == ["odd.zip"]


def test_damaged_and_odd_archives_are_refused(whole, tmp_path, monkeypatch):
    """Torn, changed, none at all, without a seal, with one twice, otherwise compressed, too large: said in words."""
    content, files = whole.path.with_suffix(".zip").read_bytes(), contents(whole.path.with_suffix(".zip"))
    place = tmp_path / "odd.zip"
    middle = bytearray(content)
    middle[len(content) // 3] ^= 0xFF
    for odd in (b"", b"no archive", content[: len(content) // 2], bytes(middle)):
        place.write_bytes(odd)
        with pytest.raises(StoreError, match="cannot be unpacked"), opened_proof(place):
            pass
    without = [one for one in files.items() if one[0] != "seal.json"]
    with pytest.warns(UserWarning, match="Duplicate"):
        twice = archived(tmp_path / "twice.zip", [*files.items(), ("seal.json", b"{}")])
    other = archived(tmp_path / "other.zip", files.items(), zipfile.ZIP_LZMA)
    for path, words in (
        (archived(place, without), "seal.json not at all"), (twice, "seal.json twice"), (other, "another way"),
    ):  # fmt: skip
        with pytest.raises(StoreError, match=words), opened_proof(path):
            pass
    for limit in ("MOST_FILES", "MOST_BYTES", "LARGEST"):
        with monkeypatch.context() as patch:
            patch.setattr(published, limit, 5)
            with pytest.raises(StoreError, match="at most"), opened_proof(whole.path.with_suffix(".zip")):
                pass


def test_more_than_an_entry_states_is_not_unpacked(whole, tmp_path):
    """An entry that states less than it holds ends in an error, and no more than it states is written."""
    files = contents(whole.path.with_suffix(".zip"))
    content = bytearray(archived(tmp_path / "small.zip", {**files, "proof.json": b" " * 10**6}.items()).read_bytes())
    stated = (10**6).to_bytes(4, "little")
    while (at := content.find(stated)) >= 0:
        content[at : at + 4] = (10).to_bytes(4, "little")
    (tmp_path / "small.zip").write_bytes(content)
    with pytest.raises(StoreError, match="cannot be unpacked"), opened_proof(tmp_path / "small.zip"):
        pass


def test_what_is_not_scored_is_not_published(tmp_path):
    """A proof without answers has nothing to publish, and no archive is written."""
    folder = sealed_proof(tmp_path / "proof")
    with pytest.raises(UsageError, match="no score yet"):
        publish(folder, tmp_path / "proof.zip")
    assert not (tmp_path / "proof.zip").exists()


def test_the_command_publishes_and_checks(whole, tmp_path, capsys):
    """`--publish` writes an archive, `--verify` reads it; one that does not fit is neither published nor passed."""
    archive = tmp_path / "proof.zip"
    code, out, _ = run_command(capsys, "prove", "--verify", whole.path, "--publish", archive)
    assert (code, f"written: {archive}" in out) == (0, True)
    root = json.loads(whole.seal.read_text())["root"]
    code, out, _ = run_command(capsys, "prove", "--verify", archive, "--root", root)
    assert (code, "All hashes and the score fit: 12 cases, 12 answers." in out) == (0, True)
    code, out, _ = run_command(
        capsys, "prove", "--verify", archive, "--root", "0" * 64, "--publish", tmp_path / "x.zip"
    )
    assert (code, "sealed anew" in out, (tmp_path / "x.zip").exists()) == (1, True, False)
    (tmp_path / "mine.zip").write_bytes(archived(tmp_path / "of-others.zip", [("a", b"b")]).read_bytes())
    for name, words in (("mine.zip", "tactiledata"), ("proof.tar", "ends in .zip")):
        code, _, error = run_command(capsys, "prove", "--verify", whole.path, "--publish", tmp_path / name)
        assert (code, words in error) == (2, True), error
    assert zipfile.ZipFile(io.BytesIO((tmp_path / "mine.zip").read_bytes())).namelist() == ["a"]
    assert run_command(capsys, "prove", "--out", tmp_path / "new", "--publish", archive)[0] == 2
