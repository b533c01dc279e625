"""Small stores to transfer, and the calls at which a test kills a writer."""

from loaders.loader_stores import SENSORS, write_loader_store

from tactiledata.store.change.keep_sensors import remove_picture
from tactiledata.store.read.reader import Store

MOMENTS = ("pwrite", "replace", "rename", "fsync", "ftruncate", "unlink", "rmdir", "open")


def write_two_sensors(folder, n_sources=8, with_backgrounds=SENSORS, damaged=(7, 30)):
    """A store of sensors D1 and D2 in turn, three trajectories a recording; two frames lack a whole image."""
    write_loader_store(folder, n_sources=n_sources, damaged=damaged)
    for sensor in set(SENSORS) - set(with_backgrounds):
        remove_picture(folder, sensor)
    return Store.open(folder)
