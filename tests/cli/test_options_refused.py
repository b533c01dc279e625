"""Options that contradict each other, or would change nothing, are refused by name before a command does any work."""

import pytest
from bench import Cases, assert_answered_in_words, command

from tactiledata.cli.given_values import need_seed
from tactiledata.errors import UsageError

MATERIAL = ["--youngs-modulus", "0.88e6", "--poisson-ratio", "0.45", "--friction", "0.8"]
CASES = Cases()
case = CASES.case


def replay(bench, *words):
    return ["replay", bench.store, *MATERIAL, *words]


@case(2, "--pad-unit without --pad")
def a_unit_of_no_pad(bench):
    return replay(bench, "--pad-unit", "furlong")


@case(2, "--resolution with --pad")
def a_resolution_of_ones_own_pad(bench):
    return replay(bench, "--pad", "own.msh", "--resolution", "high")


@case(2, "--indenters nothere is no folder")
def replayed_indenters_that_are_not_there(bench):
    return replay(bench, "--indenters", "nothere")


@case(2, "--indenters nothere is no folder")
def calibrated_indenters_that_are_not_there(bench):
    return ["calibrate", bench.store, "--indenters", "nothere"]


@case(2, "--indenters nothere is no folder")
def drawn_indenters_that_are_not_there(bench):
    return ["scene", bench.store, "--trajectory", "t00000", "--indenters", "nothere"]


@case(2, "--port without --web")
def a_port_of_no_page(bench):
    return ["view", bench.store, "--port", "9999"]


@case(2, "--most with named trajectories")
def a_number_of_named_trajectories(bench):
    return ["view", bench.store, "t00000", "--most", "3"]


@case(2, "0 workers; expected at least 1")
def a_recording_without_workers(bench):
    return ["record", "tiny", "--out", "r", "--workers", "0"]


@case(2, "0 workers; expected at least 1")
def a_demo_without_workers(bench):
    return ["demo", "--out", "d", "--workers", "0"]


@case(2, "--seed -1; expected 0 or more")
def a_split_with_a_seed_below_zero(bench):
    return ["split", bench.store, "--name", "other", "--seed", "-1"]


@case(2, "--seed -1; expected 0 or more")
def a_calibration_with_a_seed_below_zero(bench):
    return ["calibrate", bench.store, "--seed", "-1"]


@case(2, "--size with --effect nothing")
def a_size_of_nothing(bench):
    return ["plant", bench.store, "--effect", "nothing", "--size", "3", "--into", "p.zarr"]


@case(2, "--size with --effect any")
def a_size_of_what_chance_draws(bench):
    return ["plant", bench.store, "--effect", "any", "--size", "3", "--into", "p.zarr"]


@case(2, "--into with --score")
def a_score_and_a_copy(bench):
    return ["plant", "--score", "p.zarr", "--diagnosis", "d.json", "--into", "q.zarr"]


@case(2, "there is no store at nothere.zarr")
def parents_that_are_not_there(bench):
    bench.patch.setattr("tactiledata.splits.audit.audit", None)
    return ["audit", bench.store, "--parents", "nothere.zarr"]


@case(2, "--again, and", "holds no sealed cases")
def a_case_of_a_proof_that_is_not_begun(bench):
    return ["prove", "--out", "p", "--quick", "--again", "foo"]


@case(2, "--nulls with --verify")
def a_check_of_a_proof_that_asks_for_cases(bench):
    return ["prove", "--verify", bench.folder, "--nulls", "3"]


@case(2, "--verify run.mcap is no folder", "or a .zip of --publish")
def a_check_of_a_file(bench):
    return ["prove", "--verify", bench.mcap.name]


@case(2, "cannot be written to: run.mcap is a file", "--bank")
def a_bank_that_is_a_file(bench):
    return ["prove", "--out", "p", "--quick", "--bank", bench.mcap.name]


@case(2, "cannot be written to: run.mcap is a file", "--out")
def a_proof_in_the_place_of_a_file(bench):
    return ["prove", "--out", bench.mcap.name, "--quick"]


@case(2, "--out . is a folder; expected a file name that ends in .rrd")
def a_view_in_the_place_of_a_folder(bench):
    return ["view", bench.store, "--out", "."]


@case(2, "unknown mesh 'none': there is no mesh", "`tactiledata replay` attaches meshes")
def a_mesh_of_a_store_without_any(bench):
    return ["view", bench.store, "--mesh", "none"]


@case(2, "--out without tsne")
def a_place_for_no_picture(bench):
    return ["score", bench.store, "--metric", "histogram_intersection", "--out", "pictures"]


@case(2, "--weights without gram_style")
def weights_of_no_distance(bench):
    return ["score", bench.store, "--metric", "histogram_intersection", "--weights", "vgg.pth"]


@case(2, "--model without a score of vectors")
def a_model_of_no_vectors(bench):
    return ["score", bench.store, "--metric", "histogram_intersection", "--model", "vae.pt"]


@case(2, "--frames 1; expected 2 or more")
def one_vector_of_each_sensor(bench):
    return ["score", bench.store, "--metric", "tsne", "--frames", "1"]


@case(2, "cannot be written to: run.mcap is a file")
def a_picture_below_a_file(bench):
    return ["score", bench.store, "--metric", "tsne", "--out", bench.mcap.name]


@case(2, "background-swap, ", "Did you mean latent-relit?")
def a_method_with_a_slip(bench):
    return ["transfer", bench.store, "--to", "ycb-sensorA", "--method", "latent-relight"]


@case(2, "--model without add")
def a_model_of_no_sensor(bench):
    return ["sensors", bench.store, "--model", "digit"]


@case(2, "--replace with remove")
def a_sensor_that_goes_and_is_replaced(bench):
    return ["sensors", "remove", "D1", "--replace", "--store", bench.store]


@case(2, "--store beside the store")
def two_stores_of_sensors(bench):
    return ["sensors", bench.store, "--store", bench.store]


@case(0, "D20001")
def sensors_of_a_store_that_an_option_names(bench):
    return ["sensors", "--store", bench.store]


@case(2, "--hold-out 1.5; expected a share")
def a_share_beyond_one(bench):
    return ["calibrate", bench.store, "--hold-out", "1.5"]


@case(2, "--offset-prior -1.0; expected metres")
def a_prior_below_zero(bench):
    return ["calibrate", bench.store, "--offset-prior", "-1"]


@case(2, "--trajectories 0; expected at least 2")
def a_calibration_on_nothing(bench):
    return ["calibrate", bench.store, "--trajectories", "0"]


@case(2, "--mismatch -1.0; expected numbers from 0 to 100")
def an_error_of_a_solver_below_zero(bench):
    return ["prove", "--out", "p", "--quick", "--mismatch", "-1"]


@case(2, "--stride is 0; expected a whole number of at least 1")
def no_frame_of_all(bench):
    return ["view", bench.store, "--stride", "0"]


@case(2, "--frame -1 of trajectory t00000")
def a_frame_before_the_first(bench):
    return ["scene", bench.store, "--trajectory", "t00000", "--frame", "-1"]


@case(2, "--poisson-ratio is 0.7")
def a_gel_that_no_material_is(bench):
    return ["replay", bench.store, "--youngs-modulus", "9e5", "--poisson-ratio", "0.7", "--friction", "0.8"]


@case(2, "--store is empty; expected a path. Write one after --store.")
def a_store_without_a_name(bench):
    return ["ingest", bench.log, "--store", ""]


@case(2, "--reason is empty; expected a text. Write one after --reason.")
def a_flag_without_a_word(bench):
    return ["flag", bench.store, "t00000", "--reason", ""]


@pytest.mark.parametrize("name", CASES)
def test_it_is_refused_in_words(name, bench, capsys):
    """Exit 2, the option as it was typed, and nothing is written beside what stood there."""
    before = None

    def spoil(of):
        nonlocal before
        words = CASES[name].spoil(of)
        before = sorted(path.name for path in of.folder.iterdir())
        return words

    assert_answered_in_words(CASES[name]._replace(spoil=spoil), bench, capsys)
    assert sorted(path.name for path in bench.folder.iterdir()) == before


@pytest.mark.slow
def test_the_same_options_where_they_mean_something(bench, capsys):
    """Negative control: a seed, a number of trajectories and a size serve where they change something."""
    for words in (
        ["split", bench.store, "--name", "other", "--seed", "7"],
        ["view", bench.store, "--most", "1", "--no-open"],
        ["plant", bench.store, "--effect", "lag", "--size", "0.01", "--into", "planted.zarr"],
        ["record", "tiny", "--out", "r", "--workers", "1"],
        # typed by hand, a default says nothing new
        ["view", bench.store, "t00000", "--most", "20", "--port", "9090", "--no-open"],
    ):
        code, text = command(capsys, *words)
        assert code == 0, text


@pytest.mark.parametrize("seed", [0, 1, 2**32 - 1])
def test_seeds_within_the_range_serve(seed):
    """Negative control at both ends; one beyond is refused."""
    need_seed(seed)
    with pytest.raises(UsageError, match="--seed"):
        need_seed(seed, seed)
