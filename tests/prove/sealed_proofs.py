"""Proofs with made-up answers, sealed as a run seals them: no simulator takes part."""

import json

import numpy as np

from tactiledata.contract.atomic import write_atomic, write_json_atomic
from tactiledata.prove.request import ProofRequest
from tactiledata.prove.run import ProofRun
from tactiledata.prove.seal.folder import FORMAT, ProofFolder, readings_bytes, write_sealed
from tactiledata.prove.seal.sealing import seal_cases

REQUEST = ProofRequest(generators=("analytic",), plans=("coarse-0",), counts={"nulls": 6, "visible": 6})


def label(kind, number):
    """The label of a made-up case."""
    hidden = [] if kind == "nulls" else [{"effect": "lag", "parameters": {"time": 0.01}}]
    return {
        "kind": kind,
        "configuration": {"generator": "analytic", "plan": "coarse-0", "mismatch": 1.0, "solver": 0, "noise": 1.0},
        "seed": number,
        "hidden": hidden,
        "truth": ["lag"] * len(hidden),
        "material": [9e5, 0.47, 0.6],
        "modulus_left": 1.0,
        "friction_left": 1.0,
        "sight": {"signal": 20.0, "absorbed": 0.1, "loss_ratio": 2.0, "alike": {}, "unhidden": [9e5, 0.47, 0.6]}
        if hidden
        else {},
    }


def said(names, verdict=None):
    """A made-up answer that names effects."""
    return {
        "verdict": verdict or ("explained" if names else "nothing found"),
        "names": list(names),
        "set": list(names),
        "probabilities": {"none": 0.1, "+".join(names): 0.9} if names else {"none": 0.9, "other": 0.1},
        "objections": [],
        "undetectable": [],
        "nearest": list(names),
        "before": [9.9e5, 0.47, 0.6],
        "after": [9e5, 0.47, 0.6],
        "zeros": [],
    }


def sealed_proof(path, size_of=lambda kind: 50, cases=6):
    """A folder with sealed cases, of two kinds; ``size_of`` says how many readings a case of a kind has."""
    folder = ProofFolder(path)
    write_json_atomic(folder.proof, {"format": FORMAT, "request": REQUEST.document})
    drawn = []
    for number, kind in enumerate(["nulls"] * cases + ["visible"] * cases):
        readings = [(np.arange(size_of(kind), dtype=np.int64), np.full((size_of(kind), 6), float(number)))]
        write_atomic(folder.drawn_readings(number), readings_bytes(readings))
        drawn.append({"number": number, "label": label(kind, number)})
    seal_cases(folder, drawn, {str(number): "coarse-0" for number in range(2 * cases)}, {})
    return folder


def answer_case(folder, name, answer, number=1):
    """Keep an answer as the task of a run does."""
    seal = json.loads(folder.seal.read_text())
    began = {"case": name, "attempt": number, "tool": seal["tool"]["digest"]}
    write_json_atomic(folder.attempt(name, number), began)
    write_sealed(folder.answer(name, number), {**began, "seconds": 1.0, "answer": answer})


def answered_proof(path):
    """A sealed proof with right answers, and one miss; scored."""
    folder = sealed_proof(path)
    labels = json.loads(folder.labels.read_text())
    missed = next(name for name in sorted(labels) if labels[name]["label"]["truth"])
    for name, one in labels.items():
        answer_case(folder, name, said([] if name == missed else one["label"]["truth"]))
    ProofRun(folder, REQUEST, path).score()
    return folder
