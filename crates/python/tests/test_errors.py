"""Errors name file, place and remedy."""

import pickle
from pathlib import Path
from typing import Any, Callable, Tuple

import pytest
import rijke

ENDS = "[upstream]\ntype = 'open'\n[downstream]\ntype = 'open'\n"


def failure(call: Callable[[], Any]) -> rijke.RijkeError:
    with pytest.raises(rijke.RijkeError) as found:
        call()
    return found.value


def test_message_of_a_missing_file_names_it(tmp_path: Path) -> None:
    path = tmp_path / "nothing.toml"
    error = failure(lambda: rijke.Network.from_file(path))
    assert isinstance(error, rijke.InputError) and isinstance(error, ValueError)
    assert error.file == str(path)
    assert error.remedy == "Name a network file."


def test_message_names_file_line_element_and_remedy(tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(ENDS + "[[element]]\nname = 'tube'\ntype = 'duct'\nlength = -1\ndiameter = 0.05\n")
    error = failure(lambda: rijke.Network.from_file(path))
    assert (error.file, error.place) == (str(path), "line 5, element 1 `tube` (duct)")
    assert error.message == "length is -1, but must be positive and finite"
    assert str(error) == f"{path}: {error.place}: {error.message}\n  remedy: {error.remedy}"


def test_message_of_toml_names_the_line() -> None:
    error = failure(lambda: rijke.Network.from_str("[gas]\ntemperture = 3\n" + ENDS))
    assert "line 2" in error.message and "temperature" in error.message


def test_message_of_an_unknown_number_lists_the_known(tube: str) -> None:
    error = failure(lambda: rijke.Network.from_file(tube).solve(1000j, {"heat release.gian": 1.0}))
    assert error.file == tube
    assert "`heat release.gian`" in error.message and "heat release.gain" in error.message


def test_message_of_a_lost_mode_says_where_to_guess(tube: str) -> None:
    error = failure(lambda: rijke.Network.from_file(tube).solve(-1e6 + 1e6j))
    assert isinstance(error, (rijke.ComputationError, rijke.InputError))
    assert error.remedy


@pytest.mark.parametrize("value", [(object(), "`element.0.length` is of type object"), ("x", "a number is needed")])
def test_message_of_a_dictionary_says_where(value: Tuple[Any, str]) -> None:
    given, words = value
    tables = {"upstream": {"type": "open"}, "downstream": {"type": "open"},
              "element": [{"type": "duct", "length": given, "diameter": 0.05}]}
    assert words in str(failure(lambda: rijke.Network.from_dict(tables)))


def test_message_of_a_study_names_file_and_line(tmp_path: Path) -> None:
    (tmp_path / "campaign.csv").write_text("point,row,Q [parsec]\na,b,1\n")
    error = failure(lambda: rijke.Study(tmp_path))
    assert error.file is not None and error.file.endswith("campaign.csv")
    assert error.place == "line 1"


def test_behaviour_errors_can_be_pickled() -> None:
    error = rijke.InputError("what", "file", "place", "remedy")
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is rijke.InputError and vars(copy) == vars(error)
