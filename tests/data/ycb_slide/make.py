"""Write a ``tactile_data.pkl`` as YCB-Slide's simulator does: with dill, settings of omegaconf beside the poses.

The two files here were made by it: dill 0.3.4, omegaconf 2.2.3 and numpy 1.26.4, and dill 0.4.1, omegaconf 2.4.0 and
numpy 2.4.6. None of these packages is needed to read them. The numbers are random; nothing of the corpus is in them.
"""

import sys
from pathlib import Path

import dill
import numpy as np
from omegaconf import OmegaConf

rng = np.random.default_rng(0)
settings = OmegaConf.create({"obj_model": "035_power_drill", "noise": {"sig_r": 1, "sig_t": 5e-4}, "num_samples": 2})
names = ("gelposes", "camposes", "gelposes_meas")
poses = {name: np.column_stack([rng.normal(size=(2, 3)) * 0.1, np.tile([0, 0, 0, 1.0], (2, 1))]) for name in names}
Path(sys.argv[1]).write_bytes(dill.dumps({**poses, "mNoise": settings.noise}))
