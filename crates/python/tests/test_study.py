"""Studies: the program's records to the last bit, tables, draws, the model with its derivatives."""

import json
import pickle
import shutil
import subprocess
from pathlib import Path
from typing import Any, List, Tuple

import numpy as np
import pytest
import rijke
from conftest import ROOT

FOLDER = ROOT / "examples" / "quarter-wave"


@pytest.fixture(scope="module")
def results() -> rijke.Results:
    return rijke.Study(FOLDER).run(trusted="laplace")


def test_exact_records_are_those_of_the_program_to_the_last_bit(
    results: rijke.Results, program: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "study"
    shutil.copytree(FOLDER, folder, ignore=shutil.ignore_patterns("results"))
    subprocess.run([program, "run", folder, "--one-start"], check=True, capture_output=True)
    for stage in results:
        theirs = json.loads((folder / "results" / "numbers" / f"stage-{stage.id}.json").read_text())
        assert stage.record == theirs


def test_exact_tables_hold_the_record(results: rijke.Results) -> None:
    stage = results["heat"]
    models = stage.models
    assert models["id"][0] == stage.winner
    # The truth has the mean flow.
    assert stage.chosen == "heat.king-lighthill + mean-flow.without-entropy"
    assert (models["ln_best_fit"] + models["ln_occam"]).to_numpy() == pytest.approx(models["ln_marginal"].to_numpy())
    assert models["below"][0] == 0.0 and (models["below"].to_numpy()[1:] < 0).all()
    parameters = stage.parameters()
    posterior = stage.posterior
    assert list(parameters["value"]) == list(posterior.mean[: len(parameters)])
    assert posterior.frame["sd"].to_numpy() == pytest.approx(np.sqrt(np.diag(posterior.covariance)))
    assert len(results.frame) == sum(len(s.models) for s in results)
    assert len(stage.measured) == 48


def test_behaviour_progress_is_told(results: rijke.Results) -> None:
    told: List[Tuple[int, int, str]] = []
    rijke.Study(FOLDER).run(trusted="laplace", progress=lambda *news: told.append(news))
    assert [done for done, _, _ in told] == [0, 1, 2, 3]
    assert told[0][2] == "The empty tube: wall, inlet, mouth"


def test_behaviour_an_exception_of_the_callback_ends_the_run() -> None:
    def interrupt(done: int, count: int, title: str) -> None:
        if done == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        rijke.Study(FOLDER).run(trusted="laplace", progress=interrupt)


def test_behaviour_ctrl_c_counts_between_stages() -> None:
    script = (
        "import os, signal, rijke\n"
        "def news(done, count, title):\n"
        "    if done == 1: signal.raise_signal(signal.SIGINT)\n"
        f"rijke.Study({str(FOLDER)!r}).run(trusted='laplace', progress=news)\n"
    )
    import sys

    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert ended.returncode != 0 and "KeyboardInterrupt" in ended.stderr


def test_order_derivatives_of_the_model(results: rijke.Results) -> None:
    posterior = results["heat"].posterior
    model = posterior.model
    at = posterior.mean[: len(model.names)]
    sd = np.sqrt(np.diag(posterior.covariance))[: len(model.names)]
    s, slope, curvature = model.hessian(at)
    assert (s.shape, slope.shape, curvature.shape) == ((48,), (48, 8), (48, 8, 8))
    assert np.array_equal(curvature, np.swapaxes(curvature, 1, 2))
    steps = np.diag(1e-3 * sd)
    ends = model.jacobian(np.stack([at + steps, at - steps]))
    for k in range(len(at)):
        width = 2e-3 * sd[k]
        quotient = (ends[0][0, k] - ends[0][1, k]) / width
        assert np.allclose(slope[:, k], quotient, rtol=1e-5, atol=1e-6 * abs(slope[:, k]).max())
        quotients = (ends[1][0, k] - ends[1][1, k]) / width
        assert np.allclose(curvature[:, k], quotients, rtol=1e-4, atol=1e-5 * abs(curvature[:, k]).max())


def test_exact_a_vector_of_parameters_is_each_of_them(results: rijke.Results) -> None:
    model = results["heat"].posterior.model
    values = results["heat"].posterior.draws(35, seed=3)[:, : len(model.names)].reshape(5, 7, -1)
    found = model.solve(values)
    assert found.shape == (5, 7, 48)
    assert np.array_equal(found[4, 6], model.solve(values[4, 6]))
    recorded = next(m for m in results["heat"].record["models"] if m["id"] == results["heat"].chosen)
    best = model.solve(results["heat"].posterior.mean[: len(model.names)])
    assert np.allclose(np.stack([best.real, best.imag], axis=-1), recorded["predicted"], rtol=1e-12)


def test_oracle_draws_have_the_moments_of_the_posterior(results: rijke.Results) -> None:
    posterior = results["heat"].posterior
    draws = posterior.draws(40_000, seed=1)
    assert np.array_equal(draws, posterior.draws(40_000, seed=1))
    sd = np.sqrt(np.diag(posterior.covariance))
    assert np.all(abs(draws.mean(0) - posterior.mean) < 0.03 * sd)
    assert np.all(abs(np.cov(draws.T) - posterior.covariance) < 0.04 * np.outer(sd, sd))


def test_behaviour_arviz_takes_the_posterior(results: rijke.Results) -> None:
    import arviz

    data = results["heat"].posterior.to_arviz(draws=250, chains=4)
    summary = arviz.summary(data, round_to=6)
    assert (summary["r_hat"] < 1.02).all()
    assert (summary["ess_bulk"] > 700).all()  # of 1000 independent draws
    # Each number given all others: draws need little weighing, and the plain mean of as many says the same.
    for name, count in [("growth_rate", 48), ("angular_frequency", 48), ("relative_pressure", 288)]:
        loo = arviz.loo(data, var_name=name, pointwise=True)
        ln = data.log_likelihood[name].to_numpy().reshape(-1, count)
        plain = -np.log(np.exp(-ln).mean(0))
        assert (loo.pareto_k.to_numpy() < 0.7).all()
        assert abs(loo.loo_i.to_numpy() - plain).max() < 0.03
    import matplotlib

    matplotlib.use("agg")
    arviz.plot_pair(data, var_names=["k1", "k2"])


def test_behaviour_predictions_cover_what_was_measured(results: rijke.Results) -> None:
    frame = results["heat"].predictions
    sd = np.hypot(frame["growth_rate_sd"].to_numpy(), results["heat"].measured["growth_rate_sd"].to_numpy())
    off = (frame["measured_growth_rate"].to_numpy() - frame["growth_rate"].to_numpy()) / sd
    assert (abs(off) < 4).all() and 0.3 < np.sqrt((off**2).mean()) < 1.6
    import matplotlib

    matplotlib.use("agg")
    assert results["heat"].plot_predictions().get_xlabel().startswith("measured growth rate")
    assert "nats" in results["heat"].plot_models().get_xlabel()


def test_behaviour_display_and_pickling(results: rijke.Results) -> None:
    study: Any = pickle.loads(pickle.dumps(results.study))
    assert study.stages == results.study.stages
    assert "48 operating points" in repr(study) and "<table>" in study._repr_html_()
    assert "goes on" in results._repr_html_()
    assert "k1" in results["heat"].posterior._repr_html_()
    assert set(study.points.columns) > {"point", "row", "Q", "x_g"}


def test_message_of_an_unknown_stage_lists_the_known(results: rijke.Results) -> None:
    with pytest.raises(rijke.InputError, match="no stage called `heaat` has run") as found:
        results["heaat"]
    assert found.value.remedy == "Give one of tube, gauze, heat."
    with pytest.raises(rijke.InputError, match="Give a value of each of"):
        results["heat"].posterior.model.solve([1.0])


def test_message_of_a_lost_mode_is_a_failure_of_the_work(results: rijke.Results) -> None:
    model = results["heat"].posterior.model
    with pytest.raises(rijke.ComputationError, match="at operating point") as found:
        model.solve(1e3 * model.medians)
    assert found.value.remedy is not None and "the mode was lost" in found.value.remedy
