"""Writers that are killed, that find a full disk or another writer, and what they leave: for tests of any writer."""

import hashlib
import os
import resource
import signal

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


def on_a_full_disk(work, limit):
    """The exit code of work in a forked process whose files cannot grow beyond a limit, bytes; 3: an error of ours."""

    def limited():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        work()

    return os.waitstatus_to_exitcode(in_child(limited))
