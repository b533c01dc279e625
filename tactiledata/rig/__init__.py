"""Recorded worlds: which recordings a world of known physics gives.

The rig plays a scenario whose truth is known and writes ordinary logs of it, which the toolkit then reads like any
others. Read `scenario` (what a world consists of), `motion` (how arm and indenter move), `contact` and `layer` (what
the gel answers, in closed form or by a solver), `hidden` (faults and physics that only the rig knows), `logs` (what the
instruments record and write) and `bank` (solved contacts, kept); `play` and `record` join them.

The rooms `contact`, `layer`, `hidden`, `scenario` and `play` import one another: a scenario names hidden effects, and
these act on contacts. The rig has its own contact and its own optics: it may not import the gel engines, the effects or
the diagnosis. A test on its logs is a test only because no model code is shared.
"""
