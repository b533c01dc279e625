"""The law of signs and frames: what a log says of itself suffices to recover the true contact from its wrenches."""

from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from tactiledata.contract.description import LogDescription
from tactiledata.contract.schema import read_document
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.transforms import interpolate_poses, move_wrench, pose_matrices

WRENCH = ["fx", "fy", "fz", "tx", "ty", "tz"]
QUIET = {
    "pose_repeatability": 0.0,
    "tcp_noise": 0.0,
    "force_noise": 0.0,
    "torque_noise": 0.0,
    "force_quantum": 0.0,
    "torque_quantum": 0.0,
    "force_drift": 0.0,
}


def scenario_document(**changes):
    document = {
        "format": "tactiledata-scenario/1",
        "seed": 3,
        "sensors": {"D1": {"background": "digit-bg-0"}},
        "indenters": {"ball": {"shape": "sphere", "radius": 0.004}, "ring": {"shape": "ring"}},
        "streams": {"joints": 0, "arm_wrench": 0},
        "imperfections": QUIET,
        "images": {"free_air_frames": 0},
        "generate": {
            "count": 2,
            "tilt": [0.05, 0.1],
            "depth": [0.0005, 0.0006],
            "step": 0.0005,
            "shear_share": 1.0,
            "shear_step": 0.001,
            "dwell": [0.0, 0.0],
        },
    }
    return {**document, **changes}


def contact_from_log(log: Path) -> pd.DataFrame:
    """The contact wrench on the indenter in the gel frame, from the log alone, by DATA.md section 2."""
    description = LogDescription.checked(read_document(log / "log.yaml"), str(log))
    wrench = pd.read_csv(log / "wrench.csv")
    tcp = pd.read_csv(log / "tcp.csv")
    tool = description.robot["tool"]
    sign = 1.0 if description.wrench["sign"] == "load_on_sensor" else -1.0
    host_ns = wrench.t_ns.to_numpy() + description.clock_offset("wrench")
    tcp_ns = tcp.t_ns.to_numpy() + description.clock_offset("tcp")

    def weight(at_ns):
        rotation = pose_matrices(interpolate_poses(tcp_ns, tcp.iloc[:, 1:].to_numpy(), at_ns))[:, :3, :3]
        down = np.einsum("nji,j->ni", rotation, [0.0, 0.0, -9.81 * tool["mass"]])
        in_tcp = np.concatenate([down, np.cross(tool["centre_of_gravity"], down)], axis=1)
        return move_wrench(in_tcp, description.transform("tcp_from_ft").inverse().matrix)

    load = sign * wrench[WRENCH].to_numpy() - weight(host_ns)
    zero = np.zeros_like(load)
    for tare_ns in description.wrench["tare_ns"]:
        zero[host_ns >= tare_ns] = weight(np.array([tare_ns]))
    gel_from_ft = description.transform("tcp_from_gel").inverse() @ description.transform("tcp_from_ft")
    on_indenter = -move_wrench(load + zero, gel_from_ft.matrix)
    return pd.DataFrame(on_indenter, columns=WRENCH).assign(host_ns=host_ns)


def truth_of(log: Path) -> pd.DataFrame:
    table = pq.read_table(log.parent / "truth" / f"{log.name}.parquet").to_pandas()
    return table[table.stream == "wrench"].reset_index(drop=True)


@pytest.mark.slow
@pytest.mark.parametrize("sign", ["load_on_sensor", "reaction"])
@pytest.mark.parametrize("tare", ["log", "trajectory"])
def test_contact_is_recovered_from_the_log_alone(tmp_path, sign, tare):
    """Transforms, tool and tare of log.yaml and the TCP stream give back the true wrench, torques included."""
    scenario = load_scenario(scenario_document(recordings={"sign": sign, "tare": tare}))
    (log,) = record(scenario, tmp_path, "folder")
    found, truth = contact_from_log(log), truth_of(log)
    settled = found.host_ns > LogDescription.checked(read_document(log / "log.yaml"), "").wrench["tare_ns"][0]
    difference = (found[WRENCH] - truth[WRENCH])[settled].abs().max()
    assert truth.fz.max() > 0.5
    assert truth[["fx", "fy"]].abs().to_numpy().max() > 0.2
    # poses between two samples of the TCP stream are interpolated; the arm turns fastest between touches
    assert difference[:3].max() < 2e-3
    assert difference[3:].max() < 2e-4


def test_recovery_is_within_the_noise_of_a_noisy_rig(tmp_path):
    """With noise, bias and quanta the recovered force scatters about the truth as the scenario says."""
    noisy = {"pose_repeatability": 3e-5, "force_noise": 0.1, "coloured_share": 0.3, "force_quantum": 0.01}
    scenario = load_scenario(scenario_document(imperfections=noisy))
    (log,) = record(scenario, tmp_path, "folder")
    residual = (contact_from_log(log)[WRENCH] - truth_of(log)[WRENCH]).to_numpy()[100:, :3]
    assert np.abs(residual.mean(axis=0)).max() < 0.05
    assert residual.std(axis=0) == pytest.approx(np.full(3, 0.1 * np.hypot(1, 0.3)), rel=0.15)


def test_the_wrong_sign_is_seen(tmp_path):
    """Negative control: read with the other sign, pressing pulls."""
    (log,) = record(load_scenario(scenario_document(recordings={"sign": "reaction"})), tmp_path, "folder")
    text = (log / "log.yaml").read_text().replace("sign: reaction", "sign: load_on_sensor")
    (log / "log.yaml").write_text(text)
    found, truth = contact_from_log(log), truth_of(log)
    assert found.fz[truth.fz.idxmax()] < -0.3
