"""Hidden effects: how the physics of a recording differs from what its log states.

`base` lists the places at which an effect may act; `effects` is the table by which scenarios name effects. The members
lie by subject: `pose`, `geometry`, `material`, `history`, `time`, `adhesion`, `friction`, `load`, `sensor`, `clock`.
`contact` plays a touch with effects: `pull` changes its pull along the gel, by the sliders of `slider`, the springs
that `own_springs` fits to it, and the limit of `coulomb_limit`. `sensing` applies effects to force readings and stamps.

Beside the rig, only the command `demo` imports this room. It shares no code with `tactiledata.effects`. Its members may
import one another: `sensor` takes a resonance from `load`, and `time` the warming from `history`.
"""
