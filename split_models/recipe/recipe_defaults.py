"""Defaults of a recipe: the paper's protocol."""

from __future__ import annotations

from typing import Any


def _training(
    epochs: int, batch_size: int, patience: int, learning_rate: float = 1e-3, weight_decay: float = 0.0
) -> dict[str, Any]:
    """A section ``training``, with the decay and the checkpoint interval that all networks share."""
    return {
        "epochs": epochs,
        "batch_size": batch_size,
        "learning_rate": learning_rate,
        "schedule": "decay",
        "decay": 0.99,
        "weight_decay": weight_decay,
        "patience": patience,
        "save_seconds": 120.0,
        "accumulate": 1,
    }


DEFAULTS: dict[str, Any] = {
    "seed": 0,
    "table": None,
    "data": {
        "store": None,
        "world": None,
        "camera": "digit",
        "image_size": [320, 240],
        "mesh": "",
        "wrench": "contact_wrench",
        "replay": {
            "resolution": "low",
            "fidelity": "finite-strain",
            "keep": "all",
            "material": "calibrated",
            "youngs_modulus": None,
            "poisson_ratio": None,
            "friction": None,
        },
        "split": {
            "name": "default",
            "make": True,
            "by": ["trajectory", "sensor", "indenter"],
            "hold_out": "auto",
            "fractions": [0.8, 0.1, 0.1],
            "force": [1.0, 13.0],
            "seed": 0,
        },
        "extra_stores": [],
    },
    "models": {
        "latents": "mean",
        "image_vae": {
            "blocks": [3, 3, 5, 5, 3, 3],
            "down": [2, 2, 2, 2, 5],
            "channels": [16, 32, 64, 64, 128, 128],
            "latent": 256,
            "activation": "tanh",
            "upsampling": "nearest",
            "divergence_weight": 0.001,
            "anneal": 50,
            "background_copies": 0,
            "learns_on": False,
            "augmentation": {"rotation": 0.1, "flip": 0.5, "noise": 0.02, "contrast": 0.1, "brightness": 0.1},
            "relighting": {
                "relit": 0.0,
                "exchanged": 0.0,
                "contact_weight": 0.0,
                "gradient_weight": 0.0,
                "backgrounds": [],
            },
            "training": _training(300, 64, 20, weight_decay=1e-5),
        },
        "mesh_vae": {
            "filters": [16, 16, 16, 32],
            "order": 6,
            "latent": 128,
            "divergence_weight": 0.005,
            "training": _training(300, 128, 20),
        },
        "projection": {
            "layers": [512, 1024, 1024, 256],
            "dropout": [0.2, 0.4],
            "training": _training(300, 512, 30),
        },
        "cycle": {
            "weight": 1.0,
            "own_weight": 1.0,
            "walks": 3,
            "training": _training(100, 512, 15, learning_rate=3e-4),
        },
        "end_to_end": {
            "training": _training(300, 64, 20, weight_decay=1e-5),
        },
        "force_head": {
            "layers": [128, 512, 512, 128],
            "dropout": [0.2, 0.2],
            "training": _training(300, 512, 30),
        },
        "zhu": {
            "size": [80, 60],
            "channels": [16, 32, 64, 64],
            "adaptation_weight": 1.0,
            "anneal": 10,
            "training": _training(100, 64, 10),
        },
        "raw_forces": {
            "training": _training(100, 512, 10),
        },
    },
    "variants": {},
    "rows": {
        "methods": None,
        "parts": ["test", "test_unseen"],
        "scores": None,
        "titles": {},
        "against": None,
        "rounds": 1000,
        "cycles": 40,
        "frames": 100,
        "sources": None,
        "targets": None,
        "pairs": 240,
        "weights": None,
        "head_seeds": 20,
        "raw_seeds": 3,
    },
    "published": {},
}
"""The paper's protocol; docs/decisions/0013-split-model-sizes.md explains the sizes that the paper leaves open."""
