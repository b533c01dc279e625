"""The score of a proof: what the answers are worth, with intervals.

A score follows from labels and answers alone, so that anybody can compute it again.

`outcome` says what one answer is worth; `scored_case` holds a case beside its answer.
`wilson` has the interval of a share; `shares` adds a bootstrap over configurations.
`score` has targets, tables, strength against accuracy and the calibration of probabilities.
"""
