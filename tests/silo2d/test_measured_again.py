"""Results of a finished run follow the measures of today, from what the run stored."""

from small_silo import silo2d, the_run


def test_results_that_other_measures_made_are_measured_again_from_the_stored_frames(finished):
    """A T90 of another version of the measures: the same command gives that of today's."""
    run = the_run(finished)
    right, provenance = run.read_summary(), run.read_provenance()
    run.write_summary({**right, "t90_s": 99.0})
    run.write_provenance({**provenance, "measures_digest": "0"})

    result = silo2d("run", run.path / "case.toml", "-o", finished, "--json", "--quiet")

    assert (result.code, result.err) == (0, "")
    assert result.json["reused"] is True
    assert result.json["t90_s"] == right["t90_s"]
    assert run.read_summary() == right
    assert run.read_provenance() == provenance


def test_results_of_the_same_measures_are_read_as_they_stand(finished):
    run = the_run(finished)
    run.write_summary({**run.read_summary(), "t90_s": 99.0})
    result = silo2d("run", run.path / "case.toml", "-o", finished, "--json", "--quiet")
    assert result.json["t90_s"] == 99.0
