"""Tables of presses with a known difference between what was predicted and what was observed."""

import numpy as np
import pandas as pd


def presses(seed=0, trials=40, rows=12, rate=0.0, noise=True, correlation=0.4):
    """A table of presses whose observation is larger by ``rate`` for each decade of speed.

    Noise is correlated inside trials, and each trial has a scale of its own.
    """
    rng = np.random.default_rng(seed)
    parts = []
    for trial in range(trials):
        speed, deepest = 10 ** rng.uniform(-1, 1), rng.uniform(0.4, 1.2)
        depth = deepest * np.sin(np.pi * np.arange(rows) / (rows - 1))
        predicted = 8.0 * depth**1.5
        white = rng.normal(0, 0.1, rows)
        left = white.copy()
        for row in range(1, rows):
            left[row] = correlation * left[row - 1] + np.sqrt(1 - correlation**2) * white[row]
        own = 1 + rng.normal(0, 0.003)
        parts.append(
            pd.DataFrame(
                {
                    "trial": trial,
                    "time_s": 0.1 * np.arange(rows),
                    "depth_mm": depth,
                    "speed_mm_per_s": speed,
                    "fz_predicted_N": predicted,
                    "fz_observed_N": own * predicted * (1 + rate * np.log10(speed)) + left,
                    "indenter": ("ball", "cone")[rng.integers(2)],
                }
            )
        )
    table = pd.concat(parts, ignore_index=True)
    return table.assign(fz_noise_N=0.1) if noise else table
