"""Copies of folders that leave holes as they are: a store's chunk of images is 64 MiB, and nearly all of it a hole."""

import os
import shutil
from pathlib import Path

BLOCK = 2**20


def copy_file(source, target):
    """The target, with the content of the source and holes where the source has them."""
    with Path(source).open("rb", buffering=0) as old, Path(target).open("wb", buffering=0) as new:
        size = os.fstat(old.fileno()).st_size
        new.truncate(size)
        start = 0
        while start < size:
            try:
                start = os.lseek(old.fileno(), start, os.SEEK_DATA)
            except OSError:  # only a hole is left
                break
            stop = os.lseek(old.fileno(), start, os.SEEK_HOLE)
            while start < stop:
                content = os.pread(old.fileno(), min(BLOCK, stop - start), start)
                start += os.pwrite(new.fileno(), content, start)
    shutil.copystat(source, target)
    return target


def copy_tree(source, target):
    """A copy of a folder and of all that is in it; returns its path."""
    return Path(shutil.copytree(source, target, copy_function=copy_file))
