"""How near nulls come to a name."""

from proof_nulls import shares


def test_candidates_are_ranked_by_the_share_of_what_they_need():
    """Much evidence of which more is needed is a small share; negative evidence is a negative one."""
    candidates = [
        {"effects": ["lag"], "evidence": 30.0, "needed": 120.0},
        {"effects": ["dome", "skin"], "evidence": 9.0, "needed": 12.0},
        {"effects": ["wear"], "evidence": -4.0, "needed": 16.0},
    ]
    assert shares(candidates) == [(0.75, "dome + skin"), (0.25, "lag"), (-0.25, "wear")]
