"""The notebooks: each cell of code is run, in order; what its last line is worth must have a picture of itself."""

import ast
import glob
import json
import os

import matplotlib
import matplotlib.figure
import pytest

FOLDER = os.path.join(os.path.dirname(__file__), "..", "notebooks")


def show(value):
    if isinstance(value, matplotlib.figure.Figure):
        value.canvas.draw()
    elif hasattr(value, "_repr_html_"):
        assert value._repr_html_()
    assert repr(value)


def run(source, names):
    """A cell, as a notebook runs it: the value of a last expression is shown."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    if last:
        show(eval(compile(ast.Expression(last.value), "cell", "eval"), names))


@pytest.mark.parametrize("path", sorted(glob.glob(os.path.join(FOLDER, "*.ipynb"))), ids=os.path.basename)
def test_notebook(path):
    matplotlib.use("Agg")
    with open(path, encoding="utf-8") as file:
        cells = json.load(file)["cells"]
    sources = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    if any("numba" in source or "nsdae.cfunc" in source for source in sources):
        pytest.importorskip("numba", reason="numba is not here")
    names = {"__name__": "__main__"}
    for source in sources:
        run(source, names)


def test_there_are_notebooks():
    assert len(glob.glob(os.path.join(FOLDER, "*.ipynb"))) >= 3
