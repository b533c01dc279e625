"""Proof: does the diagnosis name what a simulated world hides, and nothing where nothing is hidden?

A proof draws cases, seals their labels, lets the diagnosis answer, and scores the answers. Read in this order:

`request` says what a proof is asked to do, and `run` does it step by step.
`worlds` has plans of touches, generators that record them, and what a diagnosis reads of the recordings.
`element_world` is a generator by finite elements of scikit-fem.
`cases` draws what each world hides, and decides whether it can be seen.
`seal` names and commits cases before any diagnosis, freezes the tool, and checks a proof afterwards.
`answers` is the diagnosis of a case, and the tasks that workers run.
`plant` puts known effects into a copy of a user's own store.
`score` has shares with intervals, and tables; `page` writes them for people.
"""
