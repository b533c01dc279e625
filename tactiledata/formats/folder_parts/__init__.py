"""The parts of a folder log, one module each; only `formats.folder` uses them."""
