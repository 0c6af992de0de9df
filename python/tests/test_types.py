"""Type checkers: mypy accepts the program typed.py and names each mistake."""

import os
import re

import pytest

import nsdae

mypy = pytest.importorskip("mypy.api", reason="mypy is not here")
HERE = os.path.dirname(__file__)

MISTAKES = {
    'nsdae.solve(ball, 3, [1], dt="x")': "incompatible type",
    'nsdae.solve(ball, 3, [1], metod="event")': "Unexpected keyword argument",
    'nsdae.solve(ball, 3, [1], method="evnt")': "incompatible type",
    'nsdae.Sim(ball, threads=1.5)': "incompatible type",
    'nsdae.Sim(ball).set_options(t_span=(0, 3))': "Unexpected keyword argument",
    'wrong: nsdae.Options = {"start_check": "maybe"}': "Incompatible types",
    'nsdae.Status.E_NOTHING': "has no attribute",
    'nsdae.Sim(ball).step().foo': "has no attribute",
}


def test_mypy(tmp_path):
    with open(os.path.join(HERE, "typed.py"), encoding="utf-8") as file:
        good = file.read()
    program = tmp_path / "program.py"
    lines = good.splitlines() + list(MISTAKES)
    program.write_text("\n".join(lines) + "\n")
    settings = tmp_path / "mypy.ini"  # without these libraries, which take half a minute
    settings.write_text("[mypy]\n[mypy-pandas.*,xarray.*,matplotlib.*,h5py.*,numba.*,mpi4py.*]\nfollow_imports = skip\n")
    out, err, _ = mypy.run(["--strict", "--config-file", str(settings), "--cache-dir", str(tmp_path / "cache"), str(program)])
    assert not err
    found = {int(line): text for line, text in re.findall(r"program.py:(\d+): error: (.*)", out)}
    assert not {lines[i - 1]: text for i, text in found.items() if i <= len(good.splitlines())}
    first = len(good.splitlines()) + 1
    for i, (line, text) in enumerate(MISTAKES.items()):
        assert text in found.get(first + i, ""), (line, out)


def test_the_typed_program_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with open(os.path.join(HERE, "typed.py"), encoding="utf-8") as file:
        exec(compile(file.read(), "typed.py", "exec"), {"__name__": "typed"})


def test_options_are_those_of_the_library(ball):
    assert list(nsdae.Options.__annotations__) == list(nsdae.Sim(ball).options)


@pytest.mark.parametrize("word", ["t_span", "t_eval", "y0", "max_step", "events", "dense_output"])
def test_words_of_scipy_are_answered(ball, word):
    with pytest.raises(nsdae.ArgumentError, match=f"{word} is an argument of SciPy; here it is ") as caught:
        nsdae.solve(ball, 1, [1], **{word: 1})
    assert caught.value.argument == word and caught.value.status == nsdae.Status.E_OPTION


def test_a_span_in_place_of_an_end(ball):
    with pytest.raises(nsdae.ArgumentError, match="t_end=3, t0=0"):
        nsdae.solve(ball, (0, 3), [1])
