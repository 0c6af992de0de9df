"""The gallery: a script for sphinx-gallery of each model in Python in docs/examples, and of each program that has a file of
parameters in data/."""

import ast
import re
import shutil

SCRIPT = '''"""
{title}
{rule}

.. image:: /pictures/{name}.gif
   :alt: {title}

{about}
"""

# %%
# The program runs with the parameters of ``data/{name}.ini``. ``nsdae-plot`` and ``nsdae-animate`` draw its file.

import subprocess

import nsdae

subprocess.run(["nsdae-{name}", "--params", "data/{name}.ini", "--quiet", "--output", "{name}.h5"], check=True)
run = nsdae.load("{name}.h5")
run.plot()

# %%
# The animation above.

run.animate("pictures/{name}.gif", width=360, fps=8)

# %%
# The model in C
# --------------
# .. literalinclude:: /source/models/{source}.c
#    :language: c

# sphinx_gallery_thumbnail_path = 'pictures/{name}.gif'
'''


PYTHON = '''"""
{title}
{rule}

.. image:: /pictures/{name}.gif
   :alt: {title}

{about}
"""

# %%
# The model in Python, to copy: ``docs/examples/{name}.py``.

{code}{animation}
# sphinx_gallery_thumbnail_path = 'pictures/{name}.gif'
'''

ANIMATION = '''
# %%
# The animation above.

run.animate("pictures/{name}.gif", width=360, fps=8)
'''


def about(mdoc):
    """Text of a man page in reStructuredText."""
    lines = []
    for line in mdoc.split("\n"):
        request = re.match(r"\.(Cm|Fl|Xr|Pa|Li|Ar) (\S+)(?: \d)?(?: (.*))?$", line)
        if request:
            dashes = "--" if request[1] == "Fl" else ""
            lines.append(f"``{dashes}{request[2].removeprefix('-')}`` {request[3] or ''}".rstrip())
        elif line.startswith(".Pp"):
            lines.append("")
        elif not line.startswith("."):
            lines.append(line.replace("\\-", "-").replace("\\(", "").replace("\\", ""))
    text = "\n".join(lines).strip()
    return re.sub(r"`` ([.,;:)])", r"``\1", text)


def write(folder, pictures, root):
    """Scripts of all examples into a folder, in which they run."""
    folder.mkdir()
    pictures.mkdir(parents=True)
    (folder / "data").symlink_to(root / "data")
    (folder / "pictures").symlink_to(pictures)
    (folder / "GALLERY_HEADER.rst").write_text("Examples\n========\n\nModels in Python, then each program of the library with its run and its model in C.\n")
    for model in sorted((root / "docs/examples").glob("*.py")):
        source, name = model.read_text(), model.stem
        text = ast.get_docstring(ast.parse(source))
        given = root / f"docs/{name}.gif"  # of a run that the script takes step by step
        if given.exists():
            shutil.copy(given, pictures)
        title = f"{name.capitalize()} in Python"
        script = PYTHON.format(title=title, rule="=" * len(title), name=name, about=text, code=source.split('"""', 2)[2].lstrip(),
                               animation="" if given.exists() else ANIMATION.format(name=name))
        (folder / f"plot_0_{name}.py").write_text(script)  # before the programs
    for parameters in sorted((root / "data").glob("*.ini")):
        name = parameters.stem
        heading = name.replace("-", " ").capitalize().replace("Newtons", "Newton's")
        text = about((root / f"docs/man/{name}.mdoc").read_text())
        script = SCRIPT.format(title=heading, rule="=" * len(heading), name=name, about=text, source=name.replace("-", "_"))
        (folder / f"plot_{name.replace('-', '_')}.py").write_text(script)
