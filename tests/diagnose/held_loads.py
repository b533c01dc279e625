"""Tables of visits: a load steps from level to level and is held, and what is observed may creep while it is."""

import numpy as np
import pandas as pd

from tactiledata.diagnose.residuals.history import fading_memory

LAWS = {
    "normal": lambda rng, n: rng.normal(size=n),
    "heavy tails": lambda rng, n: rng.standard_t(3, n) / np.sqrt(3),
    "correlated": lambda rng, n: correlated(rng.normal(size=n), 0.6),
    "own offsets": lambda rng, n: (rng.normal(size=n) + rng.normal()) / np.sqrt(2),
}


def correlated(white, correlation):
    """First-order autoregressive noise of the same variance."""
    values = white.copy()
    for row in range(1, len(values)):
        values[row] = correlation * values[row - 1] + np.sqrt(1 - correlation**2) * white[row]
    return values


def held_loads(
    seed=0, groups=11, law="normal", creep=0.0, drift=0.0, relaxes=0.0, remembers=0.0, noise=0.05, jitter=0.02
):
    """A table of groups, each of which holds 4 loads for 1 to 3 min, a row each 6 s.

    Parameters
    ----------
    creep, drift : float
        N/min since the last step of the load, and since the first row of the group.
    relaxes : float
        N by which fz sinks after a step, with a time of 20 s.
    remembers : float
        N for each N of load, of a memory of 10 s.
    jitter : float
        N, of the load at a level.
    """
    rng = np.random.default_rng(seed)
    parts = []
    for group in range(groups):
        lengths = rng.integers(10, 31, 4)
        levels = np.repeat(rng.permutation([2.0, 5.0, 8.0, 11.0]), lengths)
        since = np.concatenate([np.arange(length) / 10.0 for length in lengths])
        minutes = np.arange(len(levels)) / 10.0
        load = levels + jitter * rng.normal(size=len(levels))
        moved = creep * since + drift * minutes - relaxes * (1 - np.exp(-since * 3.0))
        if remembers:
            moved = moved + remembers * fading_memory(levels, 60.0 * minutes, np.zeros(1, dtype=int), 10.0)
        left = moved + noise * LAWS[law](rng, len(levels))
        part = {"group": group, "time_s": 60.0 * minutes, "load_N": load, "fz_predicted_N": levels}
        parts.append(pd.DataFrame({**part, "fz_observed_N": levels + left}))
    return pd.concat(parts, ignore_index=True)
