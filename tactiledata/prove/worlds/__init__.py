"""Worlds of known truth: plans of touches, generators that record them, and what a diagnosis reads of the recordings.

`plan` and `wedges` say what the arm is told; `plan_names` finds a plan by its name.
`generators` lists who computes the contact; `solver_errors` adds errors of another solver to it.
`logs` has the logs of a world; `touches` what they say of each touch; `zeros` what they say in free air.
`recorder` records a world of a plan, and reads recordings as a diagnosis does.
`played_plan` adds the plays of the gel engine: all that the worlds of a plan have in common.
"""
