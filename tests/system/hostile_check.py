"""Files of unknown origin, given to every tool that reads one: refused in one line, or read; and pages with hostile names
in a browser. usage: hostile_check.py BIN_DIR"""

import contextlib
import html
import io
import json
import os
import random
import re
import resource
import shutil
import subprocess

import h5py
import numpy as np
from matplotlib import pyplot as plt
from PIL import Image
from tools import BIN, MAINS, QUICK, browse, browser, end, expect

TOOLS = {"nsdae-animate": "x.html", "nsdae-plot": "x.svg", "nsdae-vtk": "x.vtkhdf"}
SECRET = "a line that only its owner reads " * 40
MEMORY = 3 << 30  # bytes of address space: what a lie asks for is far beyond
FAMILY = 6 if QUICK else 24  # seeds


def limit(memory):
    resource.setrlimit(resource.RLIMIT_AS, (memory, resource.getrlimit(resource.RLIMIT_AS)[1]))


def unlimited():
    """Of a program in C, which bounds itself: the address space that AddressSanitizer reserves is far beyond MEMORY."""
    limit(resource.RLIM_INFINITY)


def make(program, *arguments):
    subprocess.run([os.path.join(BIN, program), *arguments, "--quiet"], check=True, stdout=subprocess.DEVNULL, preexec_fn=unlimited)


def drawn(tool, path, *arguments):
    """Exit, lines on stderr, and bytes of the output of a tool in Python, run in here: an exception is a traceback."""
    output = TOOLS[tool]
    said = io.StringIO()
    with contextlib.suppress(OSError):
        os.remove(output)
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        try:
            code = MAINS[tool]([path, "-o", output, *arguments])
        except Exception as error:  # noqa: BLE001
            return "traceback", [repr(error)], b""
        finally:
            plt.close("all")
    made = b""
    if os.path.exists(output):
        with open(output, "rb") as file:
            made = file.read()
    return code, said.getvalue().splitlines(), made


def ran(program, *arguments):
    done = subprocess.run([os.path.join(BIN, program), *arguments], capture_output=True, text=True, timeout=300,
                          env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
                          preexec_fn=unlimited)
    return done.returncode, done.stderr.splitlines()


def changed(source, target, change):
    shutil.copy(source, target)
    with h5py.File(target, "r+") as file:
        change(file)
    return target


def anew(name, **how):
    """Replaces a dataset by one of the same attributes."""
    def change(file):
        kept = {k: v for k, v in file[name].attrs.items() if k in ("units", "description")}
        del file[name]
        file.create_dataset(name, **{"dtype": "f8", **how}).attrs.update(kept)

    return change


def linked(name, link):
    def change(file):
        del file[name]
        file[name] = link

    return change


def virtual(name):
    def change(file):
        shape = file[name].shape
        del file[name]
        layout = h5py.VirtualLayout(shape, "f8")
        layout[...] = h5py.VirtualSource("other.h5", "x", shape)
        file.create_virtual_dataset(name, layout)

    return change


def hidden_scale(file):
    """A dimension scale that no link leads to, with its data in another file."""
    scale = file.create_dataset("gone", (file["q"].shape[0],), "f8", external=[("secret", 0, 8 * file["q"].shape[0])])
    scale.make_scale("gone")
    file["q"].dims[0].detach_scale(file["time"])
    file["q"].dims[0].attach_scale(scale)
    path, links = file.filename, h5py.h5o.get_info(scale.id).addr + 4  # in the header: version 1, no checksum
    file.close()
    with open(path, "r+b") as raw:
        raw.seek(links)
        raw.write(bytes([2, 0, 0, 0]))
    with h5py.File(path, "r+") as again:
        del again["gone"]


def shared_texts(file):
    """Many texts that are one in the file: memory by the square of its length."""
    n = 20000
    del file["bodies/name"]
    made = file.create_dataset("bodies/name", (n,), h5py.string_dtype())
    made[0] = "long " * 4000
    at, size = made.id.get_offset(), 16
    file.flush()
    with open(file.filename, "r+b") as raw:
        raw.seek(at)
        one = raw.read(size)
        raw.seek(at)
        raw.write(one * n)


def text(name, value):
    def change(file):
        values = [v for v in file[name][...]]
        values[-1] = value
        del file[name]
        file.create_dataset(name, data=values, dtype=h5py.string_dtype())

    return change


def put(name, index, value):
    return lambda file: file[name].__setitem__(index, value)


# what is done to a trajectory, and words of the reason; None: nsdae-plot may draw it, as it reads no bodies
LEAKS = {
    "raw data outside": (lambda f: anew("time", shape=f["time"].shape, external=[("secret", 0, 8 * len(f["time"]))])(f), "/time has its data in other files"),
    "external link": (linked("q", h5py.ExternalLink("other.h5", "/x")), "/q is a soft or external link"),
    "soft link": (linked("q", h5py.SoftLink("/v")), "/q is a soft or external link"),
    "soft loop": (linked("time", h5py.SoftLink("/time")), "/time is a soft or external link"),
    "dangling link": (linked("v", h5py.SoftLink("/nowhere")), "/v is a soft or external link"),
    "a group in itself": (lambda f: f["energy"].__setitem__("again", f["/"]), "or in itself"),
    "virtual": (virtual("q"), "/q is spread over other files"),
    "another filter": (lambda f: anew("v", data=f["v"][...], compression="lzf", chunks=True)(f), "/v is packed by a filter"),
    "hollow time": (anew("time", shape=(2**40,), chunks=(1 << 16,), compression="gzip"), "/time is longer than its data"),
    "hollow q": (anew("q", shape=(2**40, 3), chunks=(1 << 14, 3), compression="gzip"), "/q is longer than its data"),
    "hollow and plain": (anew("v", shape=(2**40, 3)), "/v has less data than its shape says"),
}
LIES = {
    "texts": (anew("q", shape=(5, 3), dtype="S8"), "/q must be a dataset of numbers of rank 2"),
    "scalar": (anew("q", shape=()), "/q must be a dataset of numbers of rank 2"),
    "4d": (anew("q", shape=(2, 2, 2, 2)), "/q must be a dataset of numbers of rank 2"),
    "one column": (anew("q", shape=(5, 1)), ""),
    "group": (lambda f: (f.__delitem__("q"), f.create_group("q")), "/q must be a dataset of numbers of rank 2"),
    "nan": (put("time", 0, np.nan), "/time must rise and be finite"),
    "texts of one": (shared_texts, "/bodies/name has more than"),
    "deep formula": (text("bodies/x", "(" * 200000 + "1"), None),
    "formula": (text("bodies/x", "9^9^9^9^9^q0*atan2(1,2)+zz"), None),
    "points -5": (put("bodies/points", 0, -5), None),
    "points 2^31": (put("bodies/points", 0, 2**31 - 1), None),
    "hidden": (hidden_scale, "/q has a dimension scale that no link leads to"),
}


def check_tools(name, path, words):
    for tool in TOOLS:
        if QUICK and words is None and tool == "nsdae-plot":
            continue
        code, said, made = drawn(tool, path)
        if words is None and tool == "nsdae-plot":
            expect(code in (0, 1), tool, name, code, said)
            continue
        expect(code == 1 and len(said) == 1 and said[0].startswith(f"{tool}: error: ") and (words or "") in said[0],
               tool, name, code, said, "wanted", words)
        expect(SECRET[:30].encode() not in made, tool, name, "shows another file")


def check_named():
    for name, (change, words) in {**LEAKS, **LIES}.items():
        path = changed("run.h5", "bad.h5", change)
        check_tools(name, path, words)
    for name, (change, words) in LEAKS.items():
        path = changed("run.h5", "bad.h5", change)
        code, said = ran("nsdae-crank-slider", "--quiet", "--restart", path, "--t-end", "0.2")
        expect(code == 2 and len(said) == 1 and words in said[0], "restart", name, code, said)
    for program, source in (("nsdae-lcp", "lcp.h5"), ("nsdae-friction", "friction.h5")):
        with h5py.File(source) as file:
            first = next(n for n in ("b", "fclib_local/vectors/q", "fclib_global/vectors/w") if n in file)
            length = file[first].shape
        for change, words in ((anew(first, shape=length, external=[("secret", 0, 8 * length[0])]), "has its data in other files"),
                              (linked(first, h5py.SoftLink("/x")), "is a soft or external link"), (virtual(first), "is spread over"),
                              (anew(first, shape=(2**40,), chunks=(1 << 16,), compression="gzip"), "is longer than its data")):
            code, said = ran(program, changed(source, "bad.h5", change))
            expect(code == 2 and len(said) == 1 and words in said[0], program, words, code, said)


def check_sweep():
    """nsdae-sweep takes up, nsdae-plot draws."""
    how = ["bouncing-ball", "--t-end", "0.1", "--grid", "h0=1,2,3", "--keep", "final", "--processes", "1", "--output"]
    make("nsdae-sweep", *how, "sweep.h5")
    cases = {
        "link": (linked("final/q", h5py.SoftLink("/x")), "is a soft or external link"),
        "outside": (anew("final/q", shape=(3, 1), external=[("secret", 0, 24)]), "has its data in other files"),
        "status of bytes": (anew("status", data=np.zeros(3, "i1"), dtype="i1"), "damaged"),
        "many statuses": (anew("status", data=np.ones(300000, "i4"), dtype="i4"), "damaged"),
        "long attribute": (lambda f: f.attrs.__setitem__("format", np.bytes_(b"x" * 5000)), "is not a sweep"),
        "setting of rank 8": (lambda f: anew("setting", data=f["setting"][...].reshape((-1,) + (1,) * 7), dtype="u1")(f), "is not a sweep"),
    }
    for name, (change, words) in cases.items():
        path = changed("sweep.h5", "bad.h5", change)
        code, said = ran("nsdae-sweep", *how, path, "--quiet")
        expect(code in (1, 2) and len(said) == 1 and words in said[0], "nsdae-sweep", name, code, said)
        code, said, made = drawn("nsdae-plot", path)
        expect(code in (0, 1) and len(said) == code, "nsdae-plot", name, code, said)
        expect(SECRET[:30].encode() not in made, "nsdae-plot", name, "shows another file")


def check_family():
    """Seeded: one or two things are done to any of the datasets; what leaves the file is refused."""
    with h5py.File("run.h5") as file:
        names = []
        file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
    for seed in range(FAMILY):
        rng = random.Random(seed)
        name, kind = rng.choice(names), rng.randrange(10)
        shape = tuple(rng.choice((0, 1, 5, 7)) for _ in range(rng.randrange(4)))
        change = [anew(name, shape=(6,), external=[("secret", 0, 48)]), linked(name, h5py.SoftLink(rng.choice(names))),
                  linked(name, h5py.ExternalLink("other.h5", "x")), virtual(name) if name in ("q", "v") else linked(name, h5py.SoftLink(".")),
                  anew(name, shape=(2**rng.randrange(30, 45),), chunks=(4096,)),
                  anew(name, shape=shape), anew(name, shape=shape, dtype=rng.choice(("S3", "i8", "u1", "c16", "?"))),
                  lambda f, n=name: f.__delitem__(n), lambda f, n=name: (f.__delitem__(n), f.create_group(n)),
                  anew(name, shape=shape, dtype=h5py.string_dtype())][kind]
        path = changed("run.h5", "bad.h5", change)
        for tool in TOOLS if kind < 5 or seed % 4 == 0 else ("nsdae-vtk",):
            code, said, made = drawn(tool, path)
            expect(code == 1 if kind < 5 else code in (0, 1), tool, "seed", seed, name, kind, code, said)
            expect(len(said) == code, tool, "seed", seed, name, kind, said)
            expect(SECRET[:30].encode() not in made, tool, "seed", seed, "shows another file")


FRAGMENTS = ("NSDAE_SCENE", "NSDAE_TITLE", "NSDAE_SCRIPT", "<!--", "<script>", "</script>", "-->", "]]>", "&lt;", "&", '"', "'", "\\",
             "<img src=x onerror=document.title=`OWNED`>", "<svg onload=document.title='OWNED'>", "</title>", "</h1>",
             "<script>document.title='OWNED'</script>", "';document.title='OWNED';'", "\u2028", "\u2029", "\u202e", "\u00e9\u4e2d\U0001f600",
             "$", "\\$", "$\\frac{", "$x$", "{0}", "%s", "${document.title='OWNED'}", "javascript:document.title='OWNED'", "_", "\t")


def named(file, names):
    for at in ("bodies/name", "velocity", "constraint", "coordinate_unit", "constraint_unit"):  # coordinates are in formulas
        if at in file:
            values = [names[i % len(names)] for i in range(len(file[at]))]
            file[at][...] = values
    file.attrs["model"], file.attrs["method"] = names[0], names[-1]


def coloured(picture):
    """Pixels of the canvas in colours of bodies: neither grey nor white."""
    with Image.open(picture) as image:
        rgb = np.asarray(image.convert("RGB")).astype(int)[60:500]
    return int(np.count_nonzero(rgb.max(axis=2) - rgb.min(axis=2) > 40))


def check_browser(program, page, title, names):
    dom = browse(program, page, 0.05, "--dump-dom")
    got = re.search("<title>(.*?)</title>", dom, re.DOTALL)
    expect(got and html.unescape(got[1]).split() == title.split(), page, "title", got and got[1], "wanted", title)
    expect("data-frame=" in dom, page, "draws no frame")
    expect(len(re.findall("<script", dom)) == 2 and "<img" not in dom and "<svg" not in dom, page, "has elements of a name")
    keys = re.search('<div class="row" id="bodies">(.*?)</div>', dom, re.DOTALL)[1]
    for name in names:
        expect(html.escape(name, quote=False) in keys.replace("&nbsp;", "\u00a0"), page, "does not show", name, "but", keys[:300])


def check_names():
    program = browser()
    cases = [["NSDAE_SCENE", "<img src=x onerror=document.title=`OWNED`>", "<!--<script>"],
             ["<script>document.title='OWNED'</script>", "</script><script>document.title='OWNED'</script>", "NSDAE_TITLE"]]
    for seed in range(1 if QUICK else 4):
        rng = random.Random(seed)
        cases.append(["".join(rng.choice(FRAGMENTS) for _ in range(rng.randrange(1, 5))) for _ in range(3)])
    for i, names in enumerate(cases):
        path = changed("run.h5", "bad.h5", lambda f, n=names: named(f, n))
        for tool in TOOLS if i < (1 if QUICK else 3) else ("nsdae-animate",):
            code, said, _ = drawn(tool, path)
            expect(code == 0 and not said, tool, "names", names, code, said)
        if not os.path.exists("x.html"):
            continue
        os.replace("x.html", f"{i}.html")
        with open(f"{i}.html", encoding="utf-8") as file:
            whole = file.read()
        data = re.search(r'<script type="application/json" id="data">(.*?)</script>', whole, re.DOTALL)[1]
        expect(not set("<>&\u2028\u2029") & set(data), "names", names, "stand unescaped")
        shown = json.loads(data)
        expect({b["name"] for b in shown["bodies"]} == set(names), "names", names, "are", [b["name"] for b in shown["bodies"]])
        expect(shown["title"] == f"{names[0]}, {names[-1]}", "title", shown["title"])
        if program and i < (1 if QUICK else len(cases)):
            check_browser(program, f"{i}.html", shown["title"], [b["name"] for b in shown["bodies"] if not b["fixed"]])
    if program:
        browse(program, "0.html", 0.05, f"--screenshot={os.getcwd()}/0.png")
        expect(coloured("0.png") > 500, "the canvas is blank:", coloured("0.png"), "pixels")
    return len(cases) if program else 0


def main():
    make("nsdae-crank-slider", "--t-end", "0.1", "--output", "run.h5")
    make("nsdae-incline", "--no-output", "--t-end", "0.1", "--set", "friction_dump=friction.h5")
    n = 3
    with h5py.File("other.h5", "w") as file, h5py.File("lcp.h5", "w") as lcp:
        file["x"] = np.frombuffer(SECRET.encode()[:1000], "f8")
        lcp["A"], lcp["b"] = np.eye(n), np.ones(n)
    with open("secret", "w", encoding="ascii") as file:
        file.write(SECRET)
    code, said = ran("nsdae-lcp", "lcp.h5")
    expect(code == 0, "nsdae-lcp", code, said)
    for tool in TOOLS:
        code, said, _ = drawn(tool, "run.h5", *(["--only", "energy"] if tool == "nsdae-plot" else []))
        expect(code == 0 and not said, tool, "refuses a good file", code, said)
    pages = check_names()
    limit(MEMORY)
    check_named()
    check_sweep()
    check_family()
    end(f"{len(LEAKS) + len(LIES)} named, {FAMILY} seeded files, {pages} pages in a browser")


main()
