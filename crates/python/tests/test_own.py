"""Models that are Python functions: closed forms of evidence, derivatives, failures."""

import signal
import subprocess
import sys
import threading
from typing import Any

import numpy as np
import pytest
import rijke

X = np.linspace(0.0, 1.0, 9)
Y = 0.4 + 1.7 * X + 0.1 * np.cos(37.0 * np.arange(9))
SD = 0.1


def line(degree: int, **derivatives: Any) -> rijke.OwnModel:
    powers = X[:, None] ** np.arange(degree + 1)
    parameters = [rijke.Parameter(f"a{k}", rijke.normal(0.0, 2.0)) for k in range(degree + 1)]
    return rijke.OwnModel(f"degree {degree}", parameters, lambda a: powers @ a, **derivatives)


def exact(degree: int) -> float:
    """ln of the evidence of a linear model with Gaussian prior and noise."""
    powers = X[:, None] ** np.arange(degree + 1)
    covariance = 4.0 * powers @ powers.T + SD**2 * np.eye(9)
    return float(-0.5 * (Y @ np.linalg.solve(covariance, Y) + np.linalg.slogdet(2 * np.pi * covariance)[1]))


def test_exact_evidence_of_linear_models() -> None:
    models = [line(k, hessian=lambda a: np.zeros((9, len(a), len(a)))) for k in range(3)]
    ranking = rijke.rank(models, rijke.Data(Y, SD))
    frame = ranking.frame.set_index("name")
    for degree in range(3):
        assert frame.loc[f"degree {degree}", "ln_marginal"] == pytest.approx(exact(degree), abs=1e-6)
    assert ranking.frame["name"][0] == f"degree {max(range(3), key=exact)}"
    assert frame["probability"].sum() == pytest.approx(1.0)
    assert (frame["verdict"] == "trusted").any()
    bare = rijke.rank([line(1)], rijke.Data(Y, SD)).frame
    assert bare["ln_marginal"][0] == pytest.approx(exact(1), abs=1e-6)
    assert "no second derivatives" in bare["verdict"][0]
    assert "degree 1" in repr(ranking) and "degree 1" in ranking._repr_html_()


def test_exact_given_derivatives_and_quotients_agree() -> None:
    parameters = [rijke.Parameter("k", rijke.log_normal(1.0, 0.5)), rijke.Parameter("tau", rijke.normal(0.5, 0.5))]

    def f(a: Any) -> Any:
        return a[0] * np.exp(-a[1] * X)

    def jacobian(a: Any) -> Any:
        return np.stack([np.exp(-a[1] * X), -a[0] * X * np.exp(-a[1] * X)], axis=-1)

    def hessian(a: Any) -> Any:
        e = np.exp(-a[1] * X)
        return np.moveaxis(np.array([[0 * X, -X * e], [-X * e, a[0] * X**2 * e]]), 2, 0)

    data = rijke.Data(f([1.3, 0.7]) + 0.02 * np.cos(37.0 * np.arange(9)), 0.02)
    kinds = {"none": {}, "first": {"jacobian": jacobian}, "both": {"jacobian": jacobian, "hessian": hessian}}
    ranking = rijke.rank([rijke.OwnModel(name, parameters, f, **kind) for name, kind in kinds.items()], data)
    values = [ranking.parameters(name)["value"].to_numpy() for name in kinds]
    sd = ranking.parameters("both")["sd"].to_numpy()
    assert np.all(abs(values[0] - values[2]) < 1e-4 * sd) and np.all(abs(values[1] - values[2]) < 1e-4 * sd)
    evidence = ranking.frame["ln_marginal"]
    assert evidence.max() - evidence.min() < 0.05  # Gauss and Newton's Hessian without second derivatives


def test_exact_covariance_and_noise() -> None:
    covariance = SD**2 * (np.eye(9) + 0.5)
    ranking = rijke.rank([line(1)], rijke.Data(Y, covariance=covariance))
    powers = X[:, None] ** np.arange(2)
    whole = 4.0 * powers @ powers.T + covariance
    ln = -0.5 * (Y @ np.linalg.solve(whole, Y) + np.linalg.slogdet(2 * np.pi * whole)[1])
    assert ranking.frame["ln_marginal"][0] == pytest.approx(ln, abs=1e-6)
    floated = rijke.rank([line(1)], rijke.Data(Y)).record["models"][0]["record"]["noise"][0]
    assert floated["floats"] and 0.03 < floated["sd"] < 0.15
    inferred = rijke.rank([line(1)], rijke.Data(Y, rijke.Noise(0.1, 0.5)))
    assert inferred.frame["ln_marginal"].notna().all()


def test_behaviour_draws_and_arviz() -> None:
    import arviz

    ranking = rijke.rank([line(1)], rijke.Data(Y, SD), draws=2000)
    draws = ranking.draws()
    sd = np.sqrt(np.diag(ranking.covariance()))
    assert draws["a1"].std() == pytest.approx(sd[1], rel=0.1)
    data = ranking.to_arviz()
    assert data.log_likelihood["data"].shape == (1, 2000, 9)
    assert 1.0 < arviz.loo(data).p_loo < 4.0


def test_oracle_leave_one_out_of_arviz_is_the_closed_form() -> None:
    import arviz

    ranking = rijke.rank([line(1, hessian=lambda a: np.zeros((9, 2, 2)))], rijke.Data(Y, SD), draws=4000)
    found = arviz.loo(ranking.to_arviz(), pointwise=True)
    powers = X[:, None] ** np.arange(2)
    precision = np.linalg.inv(4.0 * powers @ powers.T + SD**2 * np.eye(9))
    # Of each number given the others: precision q, mean offset (Q y)_k/q.
    q, pull = np.diag(precision), precision @ Y
    exact_ones = 0.5 * np.log(q / (2 * np.pi)) - 0.5 * pull**2 / q
    assert (found.pareto_k < 0.7).all()
    assert abs(found.loo_i.values - exact_ones).max() < 0.05
    assert found.elpd_loo == pytest.approx(exact_ones.sum(), abs=0.1)


def test_behaviour_functions_of_jax_fit_as_they_are() -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    powers = X[:, None] ** np.arange(2)

    def f(a: Any) -> Any:
        return powers @ a

    model = line(1, jacobian=jax.jit(jax.jacfwd(f)), hessian=jax.jit(jax.hessian(f)))
    model.predict = jax.jit(f)
    assert rijke.rank([model], rijke.Data(Y, SD)).frame["ln_marginal"][0] == pytest.approx(exact(1), abs=1e-6)


def test_behaviour_an_exception_of_the_model_comes_through() -> None:
    def broken(a: Any) -> Any:
        raise KeyError("no such law")

    with pytest.raises(KeyError, match="no such law"):
        rijke.rank([rijke.OwnModel("broken", [rijke.Parameter("a", rijke.normal(0, 1))], broken)], rijke.Data(Y, SD))


def test_behaviour_arithmetic_errors_shorten_steps() -> None:
    def partly(a: Any) -> Any:
        if a[0] < 0.0:
            raise ArithmeticError("negative")
        return a[0] * np.sqrt(X + 0.1)

    model = rijke.OwnModel("partly", [rijke.Parameter("a", rijke.normal(2.0, 2.0))], partly)
    ranking = rijke.rank([model], rijke.Data(1.1 * np.sqrt(X + 0.1), SD))
    assert ranking.parameters()["value"][0] == pytest.approx(1.1, abs=0.01)


def test_message_of_a_wrong_shape_names_the_model() -> None:
    model = line(1, jacobian=lambda a: np.zeros((9, 3)))
    outcome = rijke.rank([model], rijke.Data(Y, SD)).frame["verdict"][0]
    assert "the Jacobian of `degree 1` has the shape [9, 3], but [9, 2] is needed" in outcome
    with pytest.raises(rijke.InputError, match="covariance has the shape"):
        rijke.Data(Y, covariance=np.eye(3))


def test_behaviour_ctrl_c_stops_a_fit() -> None:
    script = (
        "import time, rijke\n"
        "def slow(a):\n    time.sleep(0.02); return [a[0]] * 3\n"
        "model = rijke.OwnModel('slow', [rijke.Parameter('a', rijke.normal(0, 1))], slow)\n"
        "print('go', flush=True)\n"
        "rijke.rank([model], rijke.Data([1.0, 1.1, 0.9], 0.1), importance=100000)\n"
    )
    child = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout is not None and child.stdout.readline() == "go\n"
    threading.Event().wait(0.5)
    child.send_signal(signal.SIGINT)
    _, said = child.communicate(timeout=20)
    assert "KeyboardInterrupt" in said and child.returncode != 0


@pytest.mark.samplers
@pytest.mark.parametrize("sampler", ["pymc", "nutpie"])
def test_behaviour_samplers_take_the_model_of_a_study(sampler: str) -> None:
    pytest.importorskip(sampler)
    import pymc_study

    summary = pymc_study.summary(sampler, pymc_study.problem())
    print(summary)
    assert (summary["r_hat"] < 1.01).all()
    assert (summary["ess_bulk"] > 400).all()


def test_data_that_would_be_misread_are_refused() -> None:
    rows = np.triu(np.ones((9, 9))) + 9.0 * np.eye(9)
    with pytest.raises(rijke.InputError, match="masked"):
        rijke.Data(np.ma.masked_greater(Y, 1.0), SD)
    with pytest.raises(rijke.InputError, match="complex"):
        rijke.Data(Y + 1j, SD)
    with pytest.raises(rijke.InputError, match="symmetric"):
        rijke.Data(Y, SD, rows)
    with pytest.raises(rijke.InputError, match="ln_sd"):
        rijke.Noise(None, 1.0)
    with pytest.raises(rijke.InputError, match="sd is nan"):
        rijke.Noise(float("nan"))
    with pytest.raises(rijke.InputError, match="9 positive numbers"):
        rijke.Data(Y, np.full(8, SD))


def test_a_standard_deviation_for_each_number() -> None:
    one = rijke.rank([line(1)], rijke.Data(Y, SD)).frame.ln_marginal[0]
    each = rijke.rank([line(1)], rijke.Data(Y, np.full(9, SD))).frame.ln_marginal[0]
    assert abs(one - each) < 1e-9


def test_few_data_widen_what_floated_noise_leaves() -> None:
    rng = np.random.default_rng(1)
    inside = 0
    for _ in range(200):
        data = rijke.Data(1.0 + 0.1 * rng.standard_normal(4))
        model = rijke.OwnModel("mean", [rijke.Parameter("a", rijke.normal(0.0, 10.0))], lambda a: np.full(4, a[0]))
        found = rijke.rank([model], data).parameters().iloc[0]
        inside += bool(abs(found.value - 1.0) < 2.0 * found.sd)
    assert 0.90 < inside / 200 < 0.99


def test_a_model_without_a_maximum_has_no_probability() -> None:
    parameters = [rijke.Parameter(name, rijke.normal(0.0, 2.0)) for name in "ab"]
    circle = rijke.OwnModel(
        "circle",
        parameters,
        lambda a: np.array([a[0] ** 2 + a[1] ** 2]),
        jacobian=lambda a: np.array([[2 * a[0], 2 * a[1]]]),
        hessian=lambda a: np.array([[[2.0, 0.0], [0.0, 2.0]]]),
    )
    straight = rijke.OwnModel("line", parameters[:1], lambda a: a[:1])
    frame = rijke.rank([circle, straight], rijke.Data([1.0], 0.1)).frame
    assert frame.name[0] == "line" and frame.probability[0] == 1.0
