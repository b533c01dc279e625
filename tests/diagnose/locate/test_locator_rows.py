"""Rows of documents and pages beside the sentences on the same findings."""

from dataclasses import replace

import numpy as np
from planted import modulus_over, planted

from tactiledata.diagnose.answer.locator_rows import findings
from tactiledata.diagnose.locate.energy import energy_shares
from tactiledata.diagnose.locate.locate import BESIDES, locate
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.residuals import Covariate


def along_two(world):
    """E changes with the depth, and by itself with the speed."""
    return modulus_over("depth", 0.5, 0.2, 1.0)(world) + modulus_over("speed", 0.3, 1.0, 20.0, logarithmic=True)(world)


def test_a_drift_beside_a_stronger_one_is_a_row_with_the_words_of_its_sentence():
    """Every sentence that begins with what was allowed for stands, as it is, among the rows of its locator."""
    located = locate(planted(3, 60, plant=along_two))
    said = [sentence for sentence in located.sentences() if sentence.lower().startswith(BESIDES)]
    assert said
    rows = [row["words"] for row in findings(located) if row["locator"] == "drifting parameters"]
    for sentence in said:
        assert sentence.lower().rstrip(".") in [words.lower() for words in rows]
    assert rows[0] == located.leading[0].words
    assert len(rows) == len(set(rows))
    # one of a kind where no drift remains beside the strongest
    alone = replace(located, leading=located.leading[:1])
    assert not any(row["words"].startswith(BESIDES) for row in findings(alone))


def test_a_third_of_which_both_ends_read_alike_is_said_with_one_number():
    """Between 16.1 and 16.3 minutes lies a third: "about 16 min", and no range from 16 to 16."""
    world = planted(8)
    clock = np.linspace(0.0, 1.0, len(world.values))
    near = np.where(clock < 0.3, 2.0, np.where(clock > 0.7, 40.0, 16.1 + 0.2 * (clock - 0.3) / 0.4))
    told = replace(world, covariates={"minutes": Covariate(near, "min")})
    words = [cell.words for cell in energy_shares(project(told)).cells if cell.factors == ("minutes",)]
    assert words == ["minutes below 16 min", "minutes about 16 min", "minutes above 16 min"]
    wide = replace(world, covariates={"minutes": Covariate(60.0 * clock, "min")})
    words = [cell.words for cell in energy_shares(project(wide)).cells if cell.factors == ("minutes",)]
    assert words[1] == "minutes from 20 min to 40 min"
