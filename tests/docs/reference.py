"""The public headers as Doxygen gets them still compile, Doxygen has nothing to warn of, every exported function has a
description, and so has every procedure of Fortran its page. A name without a comment is found. usage: reference.py SOURCE_DIR"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

SOURCE = pathlib.Path(sys.argv.pop(1)).resolve()
sys.path.insert(0, str(SOURCE / "docs/site"))
import build  # noqa: E402
import headers  # noqa: E402
import reference  # noqa: E402

FUNCTION = re.compile(r"^NSDAE_API[^(]*?(nsdae_\w+)\(", re.M)


class Reference(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = pathlib.Path(folder.name)

    def test_headers(self):
        self.assertEqual(build.doxygen(self.work), "")
        subprocess.run(["cc", "-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "-I", self.work / "headers",
                        SOURCE / "docs/examples/ball.c"], check=True)
        described = set()
        for path in (self.work / "xml").glob("*.xml"):
            tree = ElementTree.parse(path)
            for member in [*tree.iter("memberdef"), *tree.iter("enumvalue")]:
                words = "".join(member.find("briefdescription").itertext()) + "".join(member.find("detaileddescription").itertext())
                if words.strip():
                    described.add(member.findtext("name"))
        declared = {name for path in (SOURCE / "include/nsdae").glob("*.h") for name in FUNCTION.findall(path.read_text())}
        self.assertGreater(len(declared), 100)
        self.assertEqual(declared - described, set())
        statuses = set(re.findall(r"X\((NSDAE_\w+),", (SOURCE / "include/nsdae/status.h").read_text()))
        self.assertEqual(statuses - described, set())
        classes = {path.stem for path in (self.work / "xml").glob("classnsdae*")}
        self.assertLessEqual({f"classnsdae_1_1{name}" for name in ("system", "sim", "trajectory", "bodies", "error")}, classes)

    def test_fortran(self):
        whole = (SOURCE / "lib/fortran/nsdae.f90").read_text()
        pages = "".join(reference.fortran_pages(SOURCE, set()).values())
        private = set(re.findall(r"\w+", whole[whole.index("private ::"):]))
        names = {name for path in (SOURCE / "lib/fortran").glob("*.f90")
                 for part in re.findall(r"^  public :: ((?:.*&\n)*.*)$", reference.module(SOURCE, path.stem), re.M) for name in re.findall(r"nsdae_\w+", part)}
        self.assertGreater(len(names), 80)
        self.assertEqual({name for name in names - private if f"\n## {name}\n" not in pages}, set())

    def test_a_name_without_a_comment_is_found(self):
        """Doxygen warns of a function, a member and a struct of the real headers whose comment is taken away."""
        for header, comment in (("params.h", r"/\* Entry of a key, or NULL\. \*/\n"), ("params.h", r"/\* description, one line \*/"),
                                ("params.h", r"/\* One field of a struct\. \*/\n")):
            text = (SOURCE / "include/nsdae" / header).read_text()
            less = re.sub(comment, "", text)
            self.assertNotEqual(less, text, comment)
            (self.work / "in").mkdir(exist_ok=True)
            (self.work / "in" / header).write_text(headers.for_doxygen(less))
            settings = (SOURCE / "docs/site/Doxyfile").read_text() + f"INPUT = {self.work}/in\nOUTPUT_DIRECTORY = {self.work}\n"
            done = subprocess.run(["doxygen", "-"], input=settings, capture_output=True, text=True)
            self.assertIn("is not documented", done.stdout + done.stderr, comment)
            shutil.rmtree(self.work / "in")

    def test_marks(self):
        """What each kind of comment becomes."""
        out = headers.for_doxygen('/* File.\n *     a = b\n */\n/* Two. */\nNSDAE_API int nsdae_a(void);\nNSDAE_API int nsdae_b(void);\n\n'
                                  '#define NSDAE_L_LIST(X) \\\n  X(NSDAE_A, 1, "a", "first") \\\n  X(NSDAE_B, -2, "b", "second")\n'
                                  'enum e {\n#define NSDAE_L_ENUM(name, value, text) name = value,\n  NSDAE_L_LIST(NSDAE_L_ENUM)\n};\n'
                                  'struct s {\n  double x, y; /* <both> */\n};\n')
        self.assertIn("/** @file\n File.\n@verbatim\n     a = b\n@endverbatim", out)
        self.assertIn("/** Two. */\nNSDAE_API int nsdae_a(void);\n/** @copydoc nsdae_a */\nNSDAE_API int nsdae_b(void);", out)
        self.assertIn("enum e {\n  NSDAE_A = 1, /**< first */\n  NSDAE_B = -2, /**< second */\n};", out)
        self.assertIn("double x; /**< \\<both\\> */   double y; /**< \\<both\\> */", out)


if __name__ == "__main__":
    if not shutil.which("doxygen"):
        print("no doxygen: not tested")
        sys.exit(77)
    unittest.main()
