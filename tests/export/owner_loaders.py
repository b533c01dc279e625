"""Programs that read exports with their owners' loaders, run in processes of their own."""

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

DECLARED = """
import sys
sys.path.append(sys.argv[1])
import torch
# torchvision from the registry is compiled against a torch with CUDA, and cannot register its operators beside one
# without. Nobody here calls these two; declared, they let the rest of torchvision be imported.
library = torch.library.Library("torchvision", "DEF")
for operator in ("nms", "qnms"):
    library.define(operator + "(Tensor dets, Tensor scores, float iou_threshold) -> Tensor")
"""
LAST = """
import json
print("\\n" + json.dumps(result))
"""


def run_program(code, folder, home, owners=None):
    """What a program, run inside a folder, leaves in ``result``, as JSON values; with the owners' loaders if named."""
    program = (DECLARED if owners is not None else "") + code + LAST
    environment = {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "HF_HOME": str(home),
        "HF_HUB_OFFLINE": "1",
        "OMP_NUM_THREADS": "1",
    }
    done = subprocess.run(
        [sys.executable, "-c", program, str(owners)],
        cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=600,
    )  # fmt: skip
    assert done.returncode == 0, f"{code}\n{done.stdout[-1500:]}\n{done.stderr[-3000:]}"
    return json.loads(done.stdout.splitlines()[-1])


def snippet_of(folder):
    """The lines of Python that the page of an export shows."""
    page = (folder / "README.md").read_text(encoding="utf-8")
    return page.partition("```python\n")[2].partition("```")[0]
