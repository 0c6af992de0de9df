"""What docs/check_prose.py finds and what it leaves out. usage: prose.py SOURCE_DIR"""

import json
import pathlib
import sys
import unittest

SOURCE = pathlib.Path(sys.argv.pop(1)).resolve()
sys.path.insert(0, str(SOURCE / "docs"))
import check_prose  # noqa: E402

LONG = " ".join(["word"] * 30)  # and one more makes it too long


def found(name, source):
    """(line, rule) of each finding, in the order of lines."""
    return sorted((line, rule) for line, rule, _ in check_prose.findings(pathlib.Path(name), source))


class Prose(unittest.TestCase):
    def test_every_phrase(self):
        bad = ["It is said.", "They were told.", "In so many steps.", "What counts as zero.", "See what rests there.",
               "What is left of it.", "All but for one.", "It never gets there.", "Nobody can tell.", "Each by itself.",
               "Precision has an end.", "It goes on from there.", "A sum in two parts."]
        for sentence in bad:
            self.assertEqual(len(found("a.md", sentence)), 1, sentence)
        hit = {phrase.pattern for phrase in check_prose.PHRASES for s in bad if phrase.search(s)}
        self.assertEqual(len(hit), len(check_prose.PHRASES))
        good = ["This is a said word.", "What is the rest?", "Itself.", "So. Many.", "The twofold parts."]
        self.assertEqual([s for s in good if found("a.md", s)], [])

    def test_a_phrase_over_two_lines_and_its_place(self):
        self.assertEqual(found("a.md", "One.\n\nTwo. This is\nsaid. Four.\n"), [(3, "phrase 'is said'")])

    def test_length(self):
        self.assertEqual(found("a.md", LONG + "."), [])
        self.assertEqual(found("a.md", f"One.\n{LONG} more."), [(2, "31 words")])
        self.assertEqual(found("a.md", f"{LONG}. And more of it."), [])
        self.assertEqual(found("a.md", f"{LONG} as in Fig. 3, e.g. here."), [(1, "34 words")])
        self.assertEqual(found("a.md", f"{LONG} (J. Moreau)."), [(1, "31 words")])
        self.assertEqual(found("a.md", f"{LONG} 1 2.5 x y = 3."), [])  # numbers and symbols are no words
        self.assertEqual(found("a.md", f"{LONG} `one two three`."), [(1, "31 words")])
        self.assertEqual(found("a.md", f"- {LONG}\n- and more\n"), [])
        self.assertEqual(found("a.md", f"{LONG}:\n\nand more\n"), [])

    def test_markdown_leaves_out(self):
        for text in ("```c\nint is said;\n```\n", "One:\n\n    this is said\n\n    and told, it was told\n", "| a | is said |\n",
                     "The word `is said` is code.\n", "A [link](is%20said.md#is-said) and [one](so many.md).\n",
                     "<!-- is said -->\n", "$$\nis said\n$$\n", "::::{grid} 2\n:gutter: so many\n::::\n"):
            self.assertEqual(found("a.md", text), [], text)
        for text in ("> It is said.\n", "- It is said.\n", "# It is said\n", "**is said**\n", "[is said](a.md)\n",
                     "- One\n\n    it is said\n", "```c\ncode\n```\nIt is said.\n", ":::{note}\nIt is said.\n:::\n"):
            self.assertEqual(len(found("a.md", text)), 1, text)

    def test_man_pages(self):
        self.assertEqual(found("docs/man/a.mdoc", ".Sh NAME\n.Nd it is said\nOne is\n.Ar said\n.Dl $ is said\nIt is\ntold.\n"),
                         [(2, "phrase 'is said'"), (6, "phrase 'is told'")])

    def test_headers(self):
        self.assertEqual(found("include/nsdae/a.h", f"/* {LONG}\n * more. */\n"), [(1, "31 words")])
        self.assertEqual(found("include/nsdae/a.h", f"int a; /* {LONG}\n          more */\n"), [(1, "31 words")])
        self.assertEqual(found("include/nsdae/a.h", f"/* An equation:\n *     {LONG}\n *     more and more\n */\n"), [])
        self.assertEqual(found("lib/a.c", f"/* {LONG}\n * more. */\n"), [])  # the length of public comments only

    def test_code(self):
        self.assertEqual(found("lib/a.c", 'int is, said; /* It is\n * said. */\nf("was "\n  "told");\n// so\n// many\n'),
                         [(1, "phrase 'is said'"), (3, "phrase 'was told'"), (5, "phrase 'so many'")])
        self.assertEqual(found("lib/a.c", "char c = '\"'; is said; char d = '\"';\n"), [])
        self.assertEqual(found("lib/a.c", "/* is */ int x;\n/* said */\n"), [])
        self.assertEqual(found("lib/a.f90", "is = said ! it is\nsaid = is ! said\nx = 'is said'\nis = said\n"),
                         [(3, "phrase 'is said'")])
        self.assertEqual(found("lib/a.f90", "! it is\n! said\n"), [(1, "phrase 'is said'")])

    def test_python(self):
        source = f'def f(a):\n    """{LONG}\n    more.\n\n    >>> is said\n    """\n    # it is\n    # said\n    g("so many")\n'
        self.assertEqual(found("python/nsdae/a.py", source),
                         [(2, "31 words"), (7, "phrase 'is said'"), (9, "phrase 'so many'")])
        fields = f'"""F.\n\n    Parameters\n    ----------\n    x : float\n        {LONG}.\n    y : float\n        More.\n"""\n'
        self.assertEqual(found("python/nsdae/a.py", fields), [])

    def test_notebooks(self):
        cells = [{"cell_type": "markdown", "source": ["It is\n", "said."]}, {"cell_type": "code", "source": ["# is said"]}]
        self.assertEqual(found("a.ipynb", json.dumps({"cells": cells})), [(1, "phrase 'is said'")])

    def test_the_project_is_covered(self):
        covered = {str(path) for path in check_prose.covered()}
        self.assertLessEqual({"README.md", "CHANGELOG.md", "docs/guide/python.md", "include/nsdae/sim.h", "python/nsdae/_sim.py",
                              "docs/man/driver.1.in", "lib/fortran/sim.f90", "drivers/plot/plot.py"}, covered)
        self.assertFalse({path for path in covered if path.startswith(("tests/", "build/"))})


if __name__ == "__main__":
    unittest.main()
