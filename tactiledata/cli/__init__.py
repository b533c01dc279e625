"""The command line: how a person, or a script, calls the toolkit.

`main` is the command `tactiledata` and its exit codes. Each module beside it holds the command of its name: `record`,
`ingest`, `replay`, `calibrate`, `diagnose`, `scene`, `sensors`, `view`, `flag`, `split` (and audit), `export_data`,
`prove`, `plant`, `demo`. `store` holds info, check, merge and report, `families` holds formats, indenters, effects and
inspect. `demo_steps` holds steps of `demo`. `output` prints; `failure`, `explain` and
`documents` say what went wrong; `working_store` finds the store that a command works on, `next_steps` says what to do
with it next, and `given_values` checks texts that were typed. `task_options` has the options that say where tasks run.

Commands parse, call and print. They do no work of their own, and import what they call only when they run.
"""
