"""Cases of sealed proofs for the tables beside them: which, in which order, and what is known of each."""

import pytest
from proof_cases import of_cases, proof_cases, proof_parser
from sealed_proofs import answered_proof


def name_and_kind(one):
    """What is known of a case that hides one effect."""
    return one.case.name, one.case.kind


@pytest.fixture(scope="module")
def proof(tmp_path_factory):
    """A proof with an answer to each case; one of its lags is missed."""
    return answered_proof(tmp_path_factory.mktemp("cases") / "proof")


@pytest.mark.slow
def test_cases_are_those_of_the_kinds_that_are_asked(proof):
    """Each case of a kind comes once, proof by proof; two workers say what one says, in the same order."""
    given = proof_parser(None).parse_args([str(proof.path), str(proof.path), "--workers", "2"])
    cases = proof_cases(given, ("visible",))
    alone, together = (list(of_cases(name_and_kind, cases, workers)) for workers in (1, given.workers))
    assert alone == together
    assert {kind for _, kind in alone} == {"visible"}
    assert alone[:6] == alone[6:] == sorted(alone[:6])
    assert len(set(alone)) == 6
    assert not proof_cases(given, ("pairs",))


@pytest.mark.slow
def test_what_is_known_of_a_case_says_whether_it_was_named(proof):
    """The document of a case has effect, signal and generator of its label, and whether its answer named the effect."""
    cases = proof_cases(proof_parser(None).parse_args([str(proof.path)]), ("visible",))
    assert [one.effect for one in cases] == ["lag"] * 6
    documents = [one.document for one in cases]
    assert sum(one["is_named"] for one in documents) == 5
    assert {(one["hidden"], one["signal"], one["generator"]) for one in documents} == {("lag", 20.0, "analytic")}
