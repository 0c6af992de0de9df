"""Builds the web site without a warning and looks at what was built. usage: site.py SOURCE_DIR BUILD_DIR"""

import ast
import html.parser
import json
import os
import pathlib
import re
import subprocess
import sys
import unittest
import urllib.parse

SOURCE, BUILD = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
del sys.argv[1:]
OUT = BUILD / "docs/html"


class Page(html.parser.HTMLParser):
    """Links, anchors, pictures and words of a page."""

    def __init__(self, path):
        super().__init__()
        self.links, self.anchors, self.pictures, self.words = [], set(), [], []
        self.in_text, self.text_links = 0, []  # those of the page's own text, without the sidebars
        self.feed(path.read_text(encoding="utf-8"))
        self.text = " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.anchors |= {given[name] for name in ("id", "name") if given.get(name)}
        self.in_text += tag == "article"
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])
            if self.in_text:
                self.text_links.append(given["href"])
        if tag == "img":
            self.pictures.append(given["src"])

    def handle_endtag(self, tag):
        self.in_text -= tag == "article"

    def handle_data(self, data):
        self.words.append(data)


def aim(page, link):
    """File and anchor of a link within the site; None for one that leaves it."""
    parts = urllib.parse.urlsplit(link)
    if parts.scheme or parts.netloc:
        return None
    path = page if not parts.path else pathlib.Path(os.path.normpath(page.parent / urllib.parse.unquote(parts.path)))
    return path, urllib.parse.unquote(parts.fragment)


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.pages = {path: Page(path) for path in OUT.rglob("*.html") if "_static" not in path.parts}

    def test_search(self):
        """Pages that the index has for a word are pages that have it."""
        index = (OUT / "searchindex.js").read_text(encoding="utf-8")
        index = json.loads(index[index.index("{"):index.rindex("}") + 1])
        for word, stem in (("restitution", "restitut"), ("baumgarte", "baumgart"), ("painleve", "painlev"), ("coulomb", "coulomb")):
            found = index["terms"].get(stem, [])
            found = found if isinstance(found, list) else [found]
            self.assertTrue(found, word)
            for number in found:
                page = self.pages[OUT / f"{index['docnames'][number]}.html"]
                self.assertIn(stem, page.text.lower().replace("é", "e"), (word, index["docnames"][number]))
        self.assertNotIn("certainlynowhere", index["terms"])

    def test_no_link_is_broken(self):
        links = 0
        for path, page in self.pages.items():
            for link in page.links + page.pictures:
                to = aim(path, link)
                if to is None:
                    continue
                links += 1
                self.assertTrue(to[0].exists(), f"{path.relative_to(OUT)}: {link}")
                if to[1] and to[0] in self.pages and path.name not in ("genindex.html", "search.html"):
                    self.assertIn(to[1], self.pages[to[0]].anchors, f"{path.relative_to(OUT)}: {link}")
        self.assertGreater(links, 1000)

    def test_every_page_is_reached(self):
        """By links in the text of pages, from the front page on: the sidebar alone would reach them all."""
        reached, left = set(), [OUT / "index.html"]
        while left:
            path = left.pop()
            if path in self.pages and path not in reached:
                reached.add(path)
                left += [to[0] for to in (aim(path, link) for link in self.pages[path].text_links) if to]
        pages = [path for path in (SOURCE / "docs").rglob("*.md") if not path.is_relative_to(SOURCE / "docs/site")]
        self.assertGreater(len(pages), 25)
        for path in pages:
            self.assertIn(OUT / path.relative_to(SOURCE / "docs").with_suffix(".html"), reached)
        for path in [*(SOURCE / "data").glob("*.ini")]:
            self.assertIn(OUT / f"gallery/plot_{path.stem.replace('-', '_')}.html", reached)
        for path in (SOURCE / "python/notebooks").glob("*.ipynb"):
            self.assertIn(OUT / f"notebooks/{path.stem}.html", reached)

    def test_the_front_page_begins_with_the_kit(self):
        text = self.pages[OUT / "index.html"].text
        order = [text.rindex(word) for word in ("add_joint", "From Fortran", "Comparison", "Notebooks", "Trajectory files",
                                                "Errata", "Architecture")]
        self.assertEqual(order, sorted(order))

    def test_reference(self):
        text = {name: " ".join(page.text for path, page in self.pages.items() if path.match(f"reference/{name}"))
                for name in ("c-*", "cpp.html", "fortran-*", "python.html")}
        functions = {name for path in (SOURCE / "include/nsdae").glob("*.h")
                     for name in re.findall(r"^NSDAE_API[^(]*?(nsdae_\w+)\(", path.read_text(), re.M)}
        self.assertEqual({name for name in functions if name not in text["c-*"]}, set())
        self.assertIn("try_create", text["cpp.html"])
        self.assertIn("integer ( c_int ) function nsdae_lcp_solve".replace(" ", ""), text["fortran-*"].replace(" ", ""))
        tree = ast.parse((SOURCE / "python/nsdae/__init__.py").read_text())
        public = next(ast.literal_eval(node.value) for node in tree.body
                      if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__")
        anchors = self.pages[OUT / "reference/python.html"].anchors
        source = "".join(path.read_text() for path in (SOURCE / "python/nsdae").glob("*.py"))
        defined = [name for name in public if re.search(rf"^(def|class) {name}\b", source, re.M)]
        self.assertGreater(len(defined), 20)
        self.assertEqual([name for name in defined if f"nsdae.{name}" not in anchors], [])

    def test_options(self):
        fields = re.search(r"typedef struct nsdae_sim_options(.*?)\} nsdae_sim_options", (SOURCE / "include/nsdae/sim.h").read_text(),
                           re.S)[1]
        names = [name for line in re.findall(r"^  (?:int|double) ([a-z_, ]*);", fields, re.M) for name in line.split(", ")]
        self.assertGreater(len(names), 15)
        text = self.pages[OUT / "options.html"].text.split()
        self.assertEqual([name for name in names if name not in text and name != "initialised"], [])

    def test_examples_have_pictures(self):
        for path in (SOURCE / "docs/examples").glob("*.py"):
            page = self.pages[OUT / f"gallery/plot_0_{path.stem}.html"]
            self.assertTrue(any(picture.endswith(".gif") for picture in page.pictures), path.stem)
        for path in (SOURCE / "data").glob("*.ini"):
            page = self.pages[OUT / f"gallery/plot_{path.stem.replace('-', '_')}.html"]
            shown = [picture for picture in page.pictures if "_images" in picture]
            self.assertGreaterEqual(len(shown), 2, path.stem)
            self.assertTrue(any(picture.endswith(".gif") for picture in shown), path.stem)


if __name__ == "__main__":
    done = subprocess.run([sys.executable, "-B", SOURCE / "docs/site/build.py", BUILD], capture_output=True, text=True)
    if done.returncode:
        said = done.stdout + done.stderr
        print(said)
        offline = "No matching distribution found" in said and "Temporary failure in name resolution" in said
        sys.exit(77 if offline else 1)
    unittest.main()
