"""Writers that are killed, that find a full disk or another writer, and what they leave: for tests of any writer."""

import contextlib
import ctypes
import hashlib
import io
import json
import os
import resource
import signal

from tactiledata.cli.failure import report_failure
from tactiledata.errors import TactileDataError

MOMENTS = ("pwrite", "replace", "rename", "fsync", "ftruncate", "unlink", "rmdir", "open")
"""Calls that change the disk, at each of which a writer may be killed."""


def files(folder):
    """Digest of every file of a folder but its locks, by its path inside."""
    return {
        str(place.relative_to(folder)): hashlib.sha256(place.read_bytes()).hexdigest()
        for place in sorted(folder.rglob("*"))
        if place.is_file() and not place.name.endswith(".lock")
    }


def counting(at_call):
    """Make every later call of this process that changes the disk call a function first."""

    def counted(call):
        def run(*arguments, **options):
            at_call()
            return call(*arguments, **options)

        return run

    for name in MOMENTS:
        setattr(os, name, counted(getattr(os, name)))


def in_child(work):
    """Run work in a forked process; its wait status.

    It ends with 3 by an error of the toolkit or of the system, which the command line tells in a sentence, and with 4
    by any other.
    """
    child = os.fork()
    if child == 0:
        code = 4
        try:
            work()
            code = 0
        except (TactileDataError, OSError):
            code = 3
        finally:
            os._exit(code)
    return os.waitpid(child, 0)[1]


def begun(work):
    """Begin work in a forked process; how to wait for its end.

    What is returned gives, once called, the exit code of the command line, and the error as it prints it for machines:
    ``error``, ``expected`` and ``hint``. There is no error where it ended well.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        code = 4
        with contextlib.suppress(BaseException), contextlib.redirect_stdout(io.StringIO()) as printed:
            os.close(reading)
            # the files that pytest makes of what is printed may be limited, too
            for stream in (1, 2):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
            try:
                work()
                code = 0
            except Exception as error:  # noqa: BLE001 - the command line tells whatever comes out, too
                printed.seek(0)
                printed.truncate()
                code = report_failure(error, as_json=True)
                os.write(writing, printed.getvalue().encode())
        os._exit(code)
    os.close(writing)

    def wait():
        with os.fdopen(reading, "rb") as stream:
            said = stream.read()
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), json.loads(said) if said else {}

    return wait


def ended(work):
    """How work in a forked process ends: see `begun`."""
    return begun(work)()


def moments_of(work):
    """How many calls that change the disk a piece of work makes, counted in a forked process that does it."""
    reading, writing = os.pipe()

    def counted():
        number = 0

        def count():
            nonlocal number
            number += 1

        counting(count)
        work()
        os.write(writing, str(number).encode())

    status = in_child(counted)
    os.close(writing)
    with os.fdopen(reading) as stream:
        assert status == 0, os.waitstatus_to_exitcode(status)
        return int(stream.read())


def is_killed(work, moment):
    """Whether work in a forked process came to its n-th call that changes the disk, and was ended there by SIGKILL."""
    left = moment

    def last():
        nonlocal left
        left -= 1
        if left < 0:
            os.kill(os.getpid(), signal.SIGKILL)

    def killed():
        counting(last)
        work()

    return os.WIFSIGNALED(in_child(killed))


def fill_disk(limit):
    """Make files of this process grow no further than some bytes from now on."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))


def obey_modes():
    """Make the modes of files hold for this process from now on, also where root runs it."""
    library, version, override = ctypes.CDLL(None, use_errno=True), 0x20080522, 0b111
    header, sets = (ctypes.c_uint32 * 2)(version, 0), (ctypes.c_uint32 * 6)()
    assert library.capget(header, sets) == 0
    sets[0] &= ~override
    assert library.capset(header, sets) == 0


@contextlib.contextmanager
def read_only(folder):
    """Take the right to write away from a folder and all that it holds, inside the block."""
    places = [folder, *folder.rglob("*")]
    for place in places:
        place.chmod(0o555 if place.is_dir() else 0o444)
    try:
        yield
    finally:
        for place in places:
            place.chmod(0o755 if place.is_dir() else 0o644)
