"""Loads of a force sensor that stay at a few levels, for tests of rules at their borders."""

import numpy as np

START = 1_700_000_000_000_000_000
MS = 1_000_000


def made(levels, step=10 * MS):
    """Times and loads whose fz is at a level for so many samples each."""
    fz = np.concatenate([np.full(count, float(level)) for level, count in levels])
    load = np.zeros((len(fz), 6))
    load[:, 2] = fz
    return START + np.arange(len(fz)) * step, load
