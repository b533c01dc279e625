"""Everything of tactiledata that reads files of strangers, each with small files that it reads whole."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from generators import (
    across_hdf5,
    folder_log,
    fota,
    gelsight_presses,
    hdf5_arrays,
    mcap_files,
    objectfolder_real,
    rtde_csv,
    sparsh_force,
    tvl,
    ycb_slide,
)

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "tests" / "data"


@dataclass(frozen=True)
class Reader:
    """A reader under test.

    Parameters
    ----------
    name : str
    make : callable
        Writes whole files into an empty folder.
    read : callable
        Reads that folder by the toolkit. What it returns is true where something could be read.
    gives : bool
        Whether something can be read of the whole files; a fixture that is refused would hide what lies behind.
    """

    name: str
    make: Callable[[Path], object]
    read: Callable[[Path], object]
    gives: bool = True


def rng() -> np.random.Generator:
    """The same numbers for the same fixture."""
    return np.random.default_rng(7)


# -- recordings --------------------------------------------------------------------------------------------------------


def ingested(folder: Path) -> int:
    """Look into all recordings of a folder, ingest them, and check the store; the number of recordings in it."""
    from tactiledata.formats import FORMATS
    from tactiledata.ingest.pipeline import ingest
    from tactiledata.ingest.sources.discover import find_sources
    from tactiledata.store.check.check import check

    sources, _ = find_sources([folder], None)
    tried([partial(FORMATS[source.format]().inspect, source) for source in sources])
    with tempfile.TemporaryDirectory() as place:
        store = Path(place) / "ds.zarr"
        report = ingest([folder], store)
        if not report.changed:
            return 0
        damage = [finding for finding in check(store) if finding.code.startswith("store-")]
        # damage of a recording is marked in the store; the store itself is whole
        assert not damage, damage
        return len(report.sources)


def plain_mcap(folder: Path) -> None:
    """Messages in plain sight: no compression and no checksums, so that a changed byte reaches the decoder."""
    mcap_files.touch(folder / "plain.mcap", compression="none", count=8, enable_crcs=False, enable_data_crcs=False)


def packed_mcap(folder: Path) -> None:
    """As recorders write them: chunks with checksums, compressed."""
    mcap_files.touch(folder / "packed.mcap", count=8)


def ros1_mcap(folder: Path) -> None:
    """ROS 1 messages without compression and checksums."""
    mcap_files.touch(
        folder / "one.mcap", "ros1", compression="none", count=6, enable_crcs=False, enable_data_crcs=False
    )


def foxglove_mcap(encoding: str) -> Callable[[Path], None]:
    """Messages as protobuf or JSON."""
    return lambda folder: mcap_files.foxglove_touch(folder / f"{encoding}.mcap", encoding, count=6, compression="none")


def real_mcaps(folder: Path) -> None:
    """Small files that others wrote."""
    for place in sorted((DATA / "mcap").rglob("*.mcap")):
        if place.stat().st_size < 20_000:
            shutil.copyfile(place, folder / place.name)


def rosbag(folder: Path) -> None:
    """A bag in several files that others wrote, without any stream that is read."""
    shutil.copytree(DATA / "mcap" / "ros2" / "wbag", folder / "bag")


# -- documents, tables, meshes, pictures -------------------------------------------------------------------------------


def each(folder: Path, read: Callable[[Path], object]) -> int:
    """Read every file of a folder, also after an error of the toolkit in one; the number of those that were read."""
    return tried([partial(read, place) for place in sorted(folder.rglob("*")) if place.is_file()])


def tried(steps: Sequence[Callable[[], object]]) -> int:
    """Take steps one after the other, also after an error of the toolkit in one; the number of those without one."""
    from tactiledata.errors import TactileDataError

    done = 0
    for step in steps:
        try:
            step()
            done += 1
        except TactileDataError:
            continue
    return done


def recipes(folder: Path) -> None:
    """The bundled recipes."""
    for place in sorted((ROOT / "recipes").glob("*.yaml")):
        shutil.copyfile(place, folder / place.name)


def read_recipe(place: Path) -> object:
    """A recipe at its small scale."""
    from split_models.recipe.recipe import load_recipe

    return load_recipe(place)


def scenarios(folder: Path) -> None:
    """The bundled worlds of the rig."""
    for place in sorted((ROOT / "recipes" / "worlds").glob("*.yaml")):
        shutil.copyfile(place, folder / place.name)


def read_scenario(place: Path) -> object:
    """A scenario, not recorded."""
    from tactiledata.rig.scenario.scenario import load_scenario

    return load_scenario(place)


def read_arrays(path: Path) -> object:
    """Look into an HDF5 file of arrays, and read it by a mapping."""
    from generators.collect import Collected

    from tactiledata.formats.hdf5.hdf5 import Hdf5Format

    form = Hdf5Format()
    [source] = form.sources(path)
    form.inspect(source)
    return form.read(source, Collected(), hdf5_arrays.MAPPING)


def mappings(folder: Path) -> None:
    """A mapping of topics, beside the recording that it is for."""
    mcap_files.touch(folder / "plain.mcap", compression="none", count=4)
    document = {
        "format": "tactiledata-mapping/1",
        "signals": {
            "wrench": {"topic": mcap_files.TOPICS["wrench"]},
            "tcp": {"topic": mcap_files.TOPICS["tcp"]},
            "force_x": {"topic": mcap_files.TOPICS["wrench"], "fields": ["wrench.force.x"], "units": ["N"]},
        },
        "images": {"digit": {"topic": mcap_files.TOPICS["digit"], "sensor": mcap_files.SERIAL}},
        "clock": "auto",
    }
    (folder / "mapping.yaml").write_text(yaml.safe_dump(document), encoding="utf-8")


def read_mapping(folder: Path) -> object:
    """A mapping and a recording by it."""
    from generators.collect import read

    from tactiledata.contract.schema import read_document
    from tactiledata.formats.mcap.mcap import McapFormat

    mapping = read_document(folder / "mapping.yaml", "mapping")
    return read(McapFormat(), folder / "plain.mcap", mapping)


def tables(folder: Path) -> None:
    """A table of predictions and observations, as text and as Parquet."""
    draws = rng()
    depth = np.tile(np.linspace(0, 1e-3, 12), 10)
    force = 900 * depth
    frame = pd.DataFrame(
        {
            "trial": np.repeat(np.arange(10), 12),
            "time_s": np.tile(np.arange(12) * 0.1, 10),
            "depth_mm": 1e3 * depth,
            "fz_predicted_N": force,
            "fz_observed_N": force + 0.05 * draws.normal(size=120),
        }
    )
    frame.to_csv(folder / "table.csv", index=False)
    frame.to_csv(folder / "table.tsv", index=False, sep="\t")
    frame.to_parquet(folder / "table.parquet", compression="none")


def read_residuals(place: Path) -> object:
    """Residuals of a table, not diagnosed."""
    from tactiledata.diagnose.table_input.read import read_table
    from tactiledata.diagnose.table_input.residuals_of import residuals_of

    return residuals_of(read_table(place), None, None)


def meshes(folder: Path) -> None:
    """Surfaces of an indenter in each kind of file, and a small pad of tetrahedra."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=1, radius=4.0)
    for kind in ("stl", "obj", "ply"):
        ball.export(folder / f"ball.{kind}")
    (folder / "ball_ascii.stl").write_text(trimesh.exchange.stl.export_stl_ascii(ball), encoding="utf-8")


def read_indenter(place: Path) -> object:
    """An indenter of a mesh file."""
    from tactiledata.indenters.mesh_indenter import load_mesh_indenter

    return load_mesh_indenter({"mesh": place.name, "unit": "mm"}, place.parent, "the fuzzer")


def pads(folder: Path) -> None:
    """A pad of tetrahedra as Gmsh and VTK write it."""
    import meshio

    points = np.array([[x, y, z] for x in (0, 10, 20) for y in (0, 10, 20) for z in (0, 4)], float)
    number = {tuple(point): place for place, point in enumerate(points.tolist())}
    parts = ((0, 1, 3, 7), (0, 1, 5, 7), (0, 2, 3, 7), (0, 2, 6, 7), (0, 4, 5, 7), (0, 4, 6, 7))
    cells = []
    for x, y in ((0, 0), (0, 10), (10, 0), (10, 10)):
        box = [number[(x + 10.0 * i, y + 10.0 * j, 4.0 * k)] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
        cells += [[box[corner] for corner in part] for part in parts]
    mesh = meshio.Mesh(points, [("tetra", np.array(cells))])
    for kind, words in (("mesh", {}), ("vtk", {"binary": False})):
        mesh.write(folder / f"pad.{kind}", **words)
    mesh.write(folder / "pad.msh", file_format="gmsh22", binary=False)


def read_pad(place: Path) -> object:
    """A pad of a mesh file."""
    from tactiledata.gel.mesh.mesh_file import pad_from_file

    return pad_from_file(place, "mm")


def pictures(folder: Path) -> None:
    """A picture of each kind."""
    import cv2

    image = mcap_files.picture(3)
    for kind in ("png", "jpg"):
        cv2.imwrite(str(folder / f"one.{kind}"), image)


def read_image(place: Path) -> object:
    """A picture without contact from a file, and the bytes of a frame."""
    from tactiledata.contract.image_bytes import decode_rgb, probe
    from tactiledata.store.change.add_sensor import read_picture

    content = place.read_bytes()
    tried([lambda: decode_rgb(content), lambda: probe(content)])
    return read_picture(place)


def image_folder(folder: Path) -> None:
    """Pictures without anything beside them."""
    for number in range(3):
        pictures(folder)
        (folder / "one.png").rename(folder / f"{number}.png")
        (folder / "one.jpg").rename(folder / f"{number}a.jpg")


# -- what the toolkit wrote itself -------------------------------------------------------------------------------------


def stores(folder: Path) -> None:
    """A small store with a split."""
    from tactiledata.ingest.pipeline import ingest
    from tactiledata.splits.make import make_split
    from tactiledata.store.read.reader import Store

    with tempfile.TemporaryDirectory() as place:
        log = Path(place) / "log"
        folder_log.write(log, touches=3)
        ingest([log], folder / "ds.zarr")
    make_split(Store.open(folder / "ds.zarr"), hold_out="none")


def read_store(folder: Path) -> int:
    """Read and check a store in full; the number of ways of reading it that gave a result."""
    from tactiledata.splits.audit import audit
    from tactiledata.splits.manifest import load_split
    from tactiledata.store.check.check import check
    from tactiledata.store.read.reader import Store

    place = folder / "ds.zarr"
    return tried(
        [
            lambda: check(place),
            lambda: Store.open(place).frames(),
            lambda: Store.open(place).trajectories(),
            lambda: Store.open(place).images(range(Store.open(place).n_frames)),
            lambda: Store.open(place).aligned("wrench"),
            lambda: load_split(Store.open(place), "default"),
            lambda: audit(Store.open(place)),
        ]
    )


def effects(folder: Path) -> None:
    """Strengths of effects, as a diagnosis writes them."""
    from tactiledata.effects.simulate.setting import EffectSetting, write_settings
    from tactiledata.gel.elasticity.material import GelMaterial

    settings = [EffectSetting("lag", {"delay": 0.02}), EffectSetting("frame_rotation", {"yaw": 0.05})]
    write_settings(settings, folder / "effects.json", GelMaterial(0.9e6, 0.45, 0.7))


def read_effects(place: Path) -> object:
    """Strengths of effects."""
    from tactiledata.effects.simulate.setting import read_settings

    return read_settings(place)


def proofs(folder: Path) -> None:
    """A sealed proof with made-up answers."""
    from sealed_proofs import sealed_proof

    sealed_proof(folder / "proof")


def read_proof(folder: Path) -> int:
    """Verify a proof."""
    from tactiledata.prove.seal.folder import ProofFolder
    from tactiledata.prove.seal.verify import verify

    return tried([lambda: verify(ProofFolder(folder / "proof"))])


def checkpoints(folder: Path) -> None:
    """A checkpoint of a small network."""
    from split_models.learning.checkpoint import Checkpoint, TrainedOn, save_checkpoint
    from split_models.networks.image_vae import ImageVae

    network = ImageVae((40, 30), blocks=(1, 1, 1), down=(2, 5), channels=(8, 8, 16), latent=16)
    save_checkpoint(folder / "vae.ckpt", Checkpoint.of(network, TrainedOn("a", "b", "c")))


def read_checkpoint(place: Path) -> object:
    """A checkpoint and its network."""
    from split_models.learning.checkpoint import load_checkpoint

    return load_checkpoint(place).network()


READERS = {
    reader.name: reader
    for reader in (
        Reader("mcap-plain", plain_mcap, ingested),
        Reader("mcap-packed", packed_mcap, ingested),
        Reader("mcap-ros1", ros1_mcap, ingested),
        Reader("mcap-json", foxglove_mcap("json"), ingested),
        Reader("mcap-protobuf", foxglove_mcap("protobuf"), ingested),
        Reader("mcap-real", real_mcaps, ingested, gives=False),
        Reader(
            "rosbag2", lambda folder: shutil.copytree(DATA / "mcap/ros2/wbag", folder / "bag"), ingested, gives=False
        ),
        Reader("folder", lambda folder: folder_log.write(folder / "log"), ingested),
        Reader("rtde_csv", lambda folder: rtde_csv.write(folder / "rtde.csv"), ingested),
        Reader("gelsight_presses", lambda folder: gelsight_presses.write(folder / "pack.npz"), ingested),
        Reader("ycb_slide", lambda folder: ycb_slide.write(folder / "ycb", rng(), runs=1, frames=6), ingested),
        Reader("tvl", lambda folder: tvl.write(folder / "tvl", rng(), sequences=2, frames=3, ssvtp=2), ingested),
        Reader("fota", lambda folder: fota.write(folder / "fota", rng(), sequences=2, frames=4), ingested),
        Reader(
            "objectfolder_real",
            lambda folder: objectfolder_real.write(folder / "objects", rng(), objects=(1,), frames=4),
            ingested,
        ),
        Reader("sparsh_force", lambda folder: sparsh_force.write(folder / "sparsh", rng(), images=10), ingested),
        Reader(
            "across_hdf5",
            lambda folder: across_hdf5.write(folder / "across", rng(), trials=1, steps=3, environments=2),
            ingested,
        ),
        Reader(
            "hdf5",
            lambda folder: hdf5_arrays.write(folder / "run.h5", hdf5_arrays.some_arrays()),
            lambda folder: each(folder, read_arrays),
        ),
        Reader("mapping", mappings, read_mapping),
        Reader("recipe", recipes, lambda folder: each(folder, read_recipe)),
        Reader("scenario", scenarios, lambda folder: each(folder, read_scenario)),
        Reader("table", tables, lambda folder: each(folder, read_residuals)),
        Reader("mesh", meshes, lambda folder: each(folder, read_indenter)),
        Reader("pad", pads, lambda folder: each(folder, read_pad)),
        Reader("picture", pictures, lambda folder: each(folder, read_image)),
        Reader("image_folder", image_folder, ingested),
        Reader("store", stores, read_store),
        Reader("effects", effects, lambda folder: each(folder, read_effects)),
        Reader("proof", proofs, read_proof),
        Reader("checkpoint", checkpoints, lambda folder: each(folder, read_checkpoint)),
    )
}
"""All readers by name."""
