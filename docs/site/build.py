#!/usr/bin/env python3
"""Builds the web site: build.py BUILD_DIR [OUTPUT_DIR]. A warning is an error.

BUILD_DIR/site gets what it needs:

- an environment of Python with the packages of requirements.txt and this tree's package nsdae
- Doxygen's XML of the headers
- the tree of pages in which Sphinx works

The programs of BUILD_DIR/bin run the examples.
"""

import os
import pathlib
import shutil
import subprocess
import sys

import examples
import headers
import pages
import reference

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent


def run(*command, **options):
    subprocess.run([str(word) for word in command], check=True, **options)


def sources():
    """What the package for Python is made of."""
    return [path for folder in ("include", "lib", "python", "drivers") for path in (ROOT / folder).rglob("*") if path.is_file()]


def environment(work):
    """Python of an environment that has the packages; made anew if what they are has changed."""
    python, stamp = work / "venv/bin/python", work / "venv/stamp"
    wanted = (HERE / "requirements.txt").read_text() + sys.version
    if not stamp.exists() or stamp.read_text() != wanted:
        shutil.rmtree(work / "venv", ignore_errors=True)
        run(sys.executable, "-m", "venv", work / "venv")
        run(python, "-m", "pip", "install", "-q", "--no-compile", "--disable-pip-version-check", "-r", HERE / "requirements.txt")
        stamp.write_text(wanted)
    return python


def package(python, work, build):
    """This tree's package nsdae in the environment; a wheel that the tests have made is taken if it is newer than its
    sources."""
    newest = max(path.stat().st_mtime for path in sources())
    installed = work / "venv/package"
    if installed.exists() and installed.stat().st_mtime > newest:
        return
    made = sorted((build / "tests/python/wheel").glob("nsdae-*.whl"), key=lambda path: path.stat().st_mtime)
    if not made or made[-1].stat().st_mtime < newest:
        run(python, "-m", "pip", "wheel", "-q", "--disable-pip-version-check", ROOT, "--no-deps", "-w", work / "wheel",
            f"--config-settings=build-dir={work / 'package'}")
        made = sorted((work / "wheel").glob("nsdae-*.whl"), key=lambda path: path.stat().st_mtime)
    run(python, "-m", "pip", "install", "-q", "--no-compile", "--disable-pip-version-check", "--no-deps", "--force-reinstall",
        made[-1])
    installed.touch()


def doxygen(work):
    """Doxygen's XML of the headers; returns its warnings."""
    folder = work / "headers"
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "nsdae").mkdir(parents=True)
    for header in (ROOT / "include/nsdae").iterdir():
        (folder / "nsdae" / header.name).write_text(headers.for_doxygen(header.read_text()))
    settings = (HERE / "Doxyfile").read_text() + f"INPUT = {folder}/nsdae\nOUTPUT_DIRECTORY = {work}\n" \
        f"STRIP_FROM_PATH = {folder}\nSTRIP_FROM_INC_PATH = {folder}\n"
    done = subprocess.run(["doxygen", "-"], input=settings, capture_output=True, text=True)
    return done.stdout + done.stderr


def staged(work, build):
    """The tree of pages: those of the project, and those that are made."""
    stage = work / "pages"
    for folder in (stage, work / "examples"):
        shutil.rmtree(folder, ignore_errors=True)
    (stage / "reference").mkdir(parents=True)
    pages.write(ROOT, stage)
    shutil.copy(build / "docs/options.md", stage / "options.md")
    shutil.copytree(ROOT / "drivers/models", stage / "source/models")
    for name, page in reference.pages(ROOT, work).items():
        (stage / f"reference/{name}.md").write_text(page)
    examples.write(work / "examples", stage / "pictures", ROOT)
    return stage


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    output = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else build / "docs/html").resolve()
    work = build / "site"
    work.mkdir(exist_ok=True)
    python = environment(work)
    package(python, work, build)
    warnings = doxygen(work)
    if warnings:
        sys.exit(warnings)
    stage = staged(work, build)
    path = f"{build / 'bin'}{os.pathsep}{os.environ['PATH']}"
    run(python, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-d", work / "doctrees", "-c", HERE, stage, output,
        env={**os.environ, "PATH": path, "NSDAE_SITE": str(work), "MPLBACKEND": "Agg", "PYTHONDONTWRITEBYTECODE": ""})


if __name__ == "__main__":
    main()
