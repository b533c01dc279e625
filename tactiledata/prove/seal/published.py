"""A published proof: one archive with all that a reader needs to check it, without the readings.

The readings are the bulk of a proof. Without them nobody can diagnose again; but labels, salts, answers, attempts, seal
and score suffice to check that nothing was changed since the root was published, and to score anew.
"""

from __future__ import annotations

import io
import re
import tempfile
import zipfile
import zlib
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.own_files import MARKS
from tactiledata.contract.wording import counted
from tactiledata.errors import StoreError, UnsafeContent, UsageError
from tactiledata.prove.seal.folder import LARGEST, ProofFolder

SUFFIX = ".zip"
MOST_FILES = 20_000
"""Largest number of files in an archive."""
MOST_BYTES = 512 * 1024 * 1024
"""Largest size, bytes, of all its files once they are unpacked."""
_SINGLE = ("proof.json", "seal.json", "score.json", "sealed/labels.json")
_NUMBERED = re.compile(r"(attempts|answers)/[0-9a-f]{16}-[1-9][0-9]{0,5}\.json")
_SAME_TIME = (1980, 1, 1, 0, 0, 0)


def publish(folder: ProofFolder, path: Path) -> None:
    """Write a proof without its readings into an archive, whole or not at all; the same proof gives the same bytes.

    Parameters
    ----------
    folder : ProofFolder
        A proof whose answers are scored.
    path : Path
        The archive.

    Raises
    ------
    UsageError
        Cases of the proof are not answered and scored yet.
    """
    if not folder.score.is_file():
        raise UsageError(
            f"{folder.path} has no score yet", "a proof whose cases are all answered",
            "Go on with `tactiledata prove --out` first.",
        )  # fmt: skip
    numbered = [place for part in ("attempts", "answers") for place in (folder.path / part).glob("*.json")]
    names = [*_SINGLE, *(place.relative_to(folder.path).as_posix() for place in numbered)]
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in sorted(names):
            entry = zipfile.ZipInfo(name, _SAME_TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, (folder.path / name).read_bytes())
        archive.comment = MARKS[SUFFIX]
    write_atomic(path, content.getvalue())


@contextmanager
def opened_proof(path: Path) -> Iterator[ProofFolder]:
    """The proof in a folder, or in an archive that `publish` made: that is unpacked for as long as the block lasts.

    Parameters
    ----------
    path : Path
        A folder, or a file.

    Raises
    ------
    StoreError
        The file is no archive, is damaged, or holds too much.
    UnsafeContent
        The archive holds a file that no proof has.
    """
    if path.is_dir():
        yield ProofFolder(path)
        return
    with tempfile.TemporaryDirectory(prefix="tactiledata-proof-") as place:
        folder = ProofFolder(Path(place), is_published=True)
        _unpack(path, folder.path)
        yield folder


def _unpack(path: Path, folder: Path) -> None:
    """Write the files of an archive into an empty folder, after all their names and sizes were looked at."""
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            _need_ours(path, entries)
            for entry in entries:
                place = folder / entry.filename
                place.parent.mkdir(exist_ok=True)
                # a reader stops at the size that the archive states
                place.write_bytes(archive.read(entry))
    except (OSError, EOFError, RuntimeError, NotImplementedError, zipfile.BadZipFile, zlib.error) as error:
        raise StoreError(
            f"{path} cannot be unpacked ({error})", f"a {SUFFIX} that `tactiledata prove --publish` made",
            "Fetch it again.",
        ) from error  # fmt: skip


def _need_ours(path: Path, entries: list[zipfile.ZipInfo]) -> None:
    """Refuse an archive with files of others, without those of a proof, or with more than a proof can have."""
    names = [entry.filename for entry in entries]
    strangers = [name for name in names if name not in _SINGLE and not _NUMBERED.fullmatch(name)]
    if strangers:
        raise UnsafeContent(f"{path} holds {strangers[0]!r}", "files of a proof", "This archive is none of ours.")
    whole = sum(entry.file_size for entry in entries)
    if len(entries) > MOST_FILES or whole > MOST_BYTES or any(entry.file_size > LARGEST for entry in entries):
        raise StoreError(
            f"{path} holds {counted(len(entries), 'file')} of {whole} bytes together",
            f"at most {MOST_FILES} files of {MOST_BYTES} bytes",
            "This archive is none of ours.",
        )
    if any(entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) for entry in entries):
        raise StoreError(f"{path} is compressed in another way", "deflated files", "This archive is none of ours.")
    counts = Counter(names)
    odd = sorted(name for name in {*names, *_SINGLE} if counts[name] != 1)
    if odd:
        found = "twice" if counts[odd[0]] else "not at all"
        raise StoreError(f"{path} holds {odd[0]} {found}", "each file of a proof once", "Fetch it again.")
