"""Which touches to record next.

Where several explanations are left, each proposed trial is played before anything is recorded, and judged by how far it
would separate them. Read the modules in this order:

- `rivals`: which explanations does the answer leave open?
- `trial`: what is a trial, and what are the steps of its touches?
- `bench`: on which rig would it be recorded, with which indenters, how deep and where?
- `kinds`: which trials are tried?
- `path`: where is the indenter at each moment of a touch?
- `cases`: which touches does the simulation play for a trial?
- `distance`: how far are two explanations apart after one has been refitted to the other?
- `propose`: which trial separates the explanations best?
- `scenario`: how is a trial written as a scenario file?
- `limits`: what can the recordings at hand not show, whatever is missing?

This room imports `naming` and `touches`. Its sentences about proposals stand in `answer`.
"""
