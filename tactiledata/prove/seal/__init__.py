"""The seal of a proof: nobody can change a label, an answer or a threshold afterwards without being found out.

`folder` lists the files of a proof, and reads and writes them.
`merkle` has commitments to labels and their root.
`frozen` describes the tool: digests of its program, and every number that decides a claim.
`sealing` gives drawn cases random names and writes the seal before any of them is diagnosed.
`leak` asks whether names, sizes, stamps and order tell what is hidden.
`verify` checks a proof without any simulator.
`published` packs all but the readings into one archive, from which others can verify a proof.
`compare` says how far two copies of a proof agree that were answered on different machines.
"""
