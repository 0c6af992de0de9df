#!/usr/bin/env python3
"""Faults in lib/*.c, one at a time, and the first test that finds each: what a survivor shows is a test that is missing.

A mutant is one expression of one line that is changed: a sign, a comparison, a constant, a condition, a statement that is left out. Its
object is compiled alone and linked into the tests in place of the library's; nothing else is built anew. The tests of its folder run
first, then those of systems, anomalies and conformance, the quick ones first, until one fails that passes without the change.

usage: mutants.py BUILD --sample COUNT [--seed N] [--write LIST]
       mutants.py BUILD --list LIST [--only I,J..]
LIST is a JSON array of {"file": "lib/..", "line": N, "column": N, "old": "+", "new": "-"}; without a column the first "old" of the line
is meant, and "new" may be empty. Each result goes to --results at once; mutants that are there are not run again. Nor are those of
mutants_equivalent.json, which change no answer, for the reason there.
"""
import argparse
import json
import os
import pathlib
import random
import re
import resource
import shlex
import subprocess
import sys
import tempfile
import time

FLIPPED = {"<": "<=", ">": ">=", "<=": "<", ">=": ">"}
NEGATED = {"<": ">=", ">": "<=", "<=": ">", ">=": "<", "==": "!=", "!=": "=="}
OTHER = {"+": "-", "-": "+", "*": "/", "/": "*", "+=": "-=", "-=": "+=", "&&": "||", "||": "&&", "fmin": "fmax", "fmax": "fmin",
         "nsdae_larger": "fmin"}

# Kind, what is replaced (group 1), by what. Operators have spaces around them in this format of code, those of pointers have none.
CHANGES = [
    ("boundary", r" (<=|>=|<|>) ", FLIPPED.get),
    ("comparison", r" (<=|>=|<|>) ", NEGATED.get),
    ("equality", r" (==|!=) ", NEGATED.get),
    ("sign of a term", r" ([-+]) ", OTHER.get),
    ("factor", r" ([*/]) ", OTHER.get),
    ("sign of a change", r" ([-+]=) ", OTHER.get),
    ("and, or", r" (&&|\|\|) ", OTHER.get),
    ("extremum", r"\b(fmin|fmax|nsdae_larger)(?=\()", OTHER.get),
    ("absolute value", r"\b(fabs)(?=\()", lambda old: ""),
    ("whole number", r"(?<![\w.\]-])(\d{1,2})(?![\w.])", lambda old: str(int(old) + 1)),
    ("real number", r"(?<![\w.])(\d+\.\d*(?:e[+-]?\d+)?|\d+e[+-]?\d+)(?![\w.])", lambda old: f"(2 * {old})"),
    ("unary minus", r"(?:(?<=[(=,?:] )|(?<=\()|(?<=return ))(-)(?=[A-Za-z(])", lambda old: ""),
    ("negation", r"(!)(?=[A-Za-z(])", lambda old: ""),
    ("statement", r"^ +((?!return|break|continue|goto|const|static|double|int|size_t|char|unsigned|long|nsdae_\w+ \*?\w+[ ;=\[])"
                  r"[a-z_][\w>.\[\]+ *-]*(?: [-+*/]?= |\(|\+\+|--)[^;{}]*;)$", lambda old: ";"),
]
# Texts of errors, sizes of arrays and the preprocessor are left alone.
SPARED = re.compile(r"^#|snprintf|_error_set\(|_fail\(|NSDAE_E_|^ *(?:static )?(?:const )?(?:double|int|char|size_t) [^=(]*\[[^=]*;$")

# By folder of lib the tests that are near to it, the nearest first; those of unit/FOLDER come before them.
NEAR = {
    "base": "anomaly/(memory|arguments)",
    "bodies": "system/(kit|bodies|rigid|meshes|polyhedra|pairs|scene|rolling|spun|klein|fast|far|structures|limits) anomaly/(kit|mesh|bodies)",
    "contact": "system/(contact_work|certificate|slop|dry_friction|pairs|numbered|repose|platform|clearance|newtons) anomaly/certificate",
    "event": "(system|anomaly)/certificate system/(event|play_published|late_start|tippe|linkages|platform) anomaly/warnings",
    "friction": "system/(friction|repose|contact_work|structures) anomaly/friction",
    "io": "system/(trajectory|sensors_file|contact_forces_file|event_file) anomaly/(hdf5|disk|file_memory|corrupt|described)",
    "lcp": "system/(lcp|failed_lcp|certificate) anomaly/(lcp|kernels)",
    "linalg": "system/(chains|mechanisms|blocks|listed_projection|projection|numbered) anomaly/blas",
    "method": "system/(start|late_start|restart|trajectory_resume) conformance/state",
    "penalty": "system/(penalty|late_start|threads) anomaly/(integrators|work|together)",
    "sim": "anomaly/(kit|warnings|certificate|arguments|merged|interrupt) system/(start|projection|certificate|slop) conformance/state",
    "smooth": "system/(dae_test_set|event|penalty)",
    "step": "system/(decay|platform|bouncing|crank|start|fast|pendulum|projection) conformance/exact",
    "system": "anomaly/(callbacks|kinematics|lists|sizes|named|arguments) system/(mechanisms|blocks|numbered)",
    "terms": "system/(mechanisms|blocks|listed_projection|event_curved|spare|penalty) anomaly/lists",
    "tracking": "system/(event_lists|event_listed|spare|trajectory_listed)",
}


def blanked(text):
    """The text with spaces for comments and strings."""
    pattern = r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])+\''
    return re.sub(pattern, lambda found: re.sub(r"[^\n]", " ", found.group(0)), text, flags=re.S)


def mutants_of(root, path):
    """All mutants of a file, by kind."""
    found, depth = {}, 0
    text = (root / path).read_text()
    written, lines = text.split("\n"), blanked(text).split("\n")
    for number, line in enumerate(lines, 1):
        inside = depth > 0
        depth += line.count("{") - line.count("}")
        if not inside or SPARED.search(line):
            continue
        for kind, pattern, change in CHANGES:
            if kind == "statement" and not lines[number - 2].rstrip().endswith((";", "{", "}")):
                continue  # the body of an if or for, or the rest of one
            for match in re.finditer(pattern, line):
                old = written[number - 1][match.start(1):match.end(1)]
                found.setdefault(kind, []).append({"file": path, "line": number, "column": match.start(1) + 1, "kind": kind,
                                                   "old": old, "new": change(old)})
    return found


def sample(root, count, seed):
    """As many of each folder, up to one, and of them kinds alike, so that rare ones are there."""
    draw, by_folder = random.Random(seed), {}
    for path in sorted((root / "lib").rglob("*.c")):
        name = path.relative_to(root).as_posix()
        kinds = by_folder.setdefault(name.split("/")[1], {})
        for kind, mutants in mutants_of(root, name).items():
            kinds.setdefault(kind, []).extend(mutants)
    folders = sorted(folder for folder in by_folder if by_folder[folder])
    draw.shuffle(folders)
    chosen = []
    while len(chosen) < count:
        kinds = by_folder[folders[len(chosen) % len(folders)]]
        mutant = draw.choice(kinds[draw.choice(sorted(kinds))])
        if mutant not in chosen:
            chosen.append(mutant)
    return chosen


def applied(text, mutant):
    lines = text.split("\n")
    line, old = lines[mutant["line"] - 1], mutant["old"]
    at = mutant["column"] - 1 if "column" in mutant else line.find(old)
    if at < 0 or line[at:at + len(old)] != old:
        raise SystemExit(f"{mutant['file']}:{mutant['line']}: no {old!r} there: {line.strip()}")
    lines[mutant["line"] - 1] = line[:at] + mutant["new"] + line[at + len(old):]
    return "\n".join(lines)


class Tests:
    """The tests of a build, linked with one object more."""

    def __init__(self, build, work, share):
        self.build, self.work, self.share = build, work, share
        self.links, self.passes = {}, {}
        self.costs_file = work / "costs.json"
        self.costs = json.loads(self.costs_file.read_text()) if self.costs_file.exists() else {}
        shown = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], capture_output=True, text=True, check=True)
        self.tests = {}
        for test in json.loads(shown.stdout)["tests"]:
            words = test.get("command", [])
            program = next((i for i, word in enumerate(words) if word.startswith(f"{build}/tests/test_")), None)
            if program is None or re.search("fortran|cpp", test["name"]):
                continue
            variables = {}
            for item in test["properties"]:
                if item["name"] == "ENVIRONMENT":
                    variables = dict(pair.split("=", 1) for pair in item["value"])
            self.tests[test["name"]] = (os.path.relpath(words[program], build), words[program + 1:], variables)
        self.objects = {}
        database = subprocess.run(["ninja", "-C", build, "-t", "compdb"], capture_output=True, text=True, check=True)
        for entry in json.loads(database.stdout):
            if entry["file"].endswith(".c") and " -c " in entry["command"]:
                self.objects.setdefault(os.path.normpath(os.path.join(entry["directory"], entry["file"])), entry["command"])

    def compiled(self, path, text):
        """The object of a source with this text; None: it does not compile."""
        source, target = self.work / path.name, self.work / "mutant.o"
        source.write_text(text)
        words = shlex.split(self.objects[str(path)])
        words = [word for word in words[:words.index("-o")] if not re.match(r"-W|-M|-fvisibility|.*\.d$", word)]
        # visible: it also takes the place of what a shared library defines
        words += ["-fvisibility=default", "-w", "-iquote", str(path.parent), "-o", str(target), "-c", str(source)]
        done = subprocess.run(words, cwd=self.build, capture_output=True, check=False)
        return target if done.returncode == 0 else None

    def program(self, name, extra):
        """The program of a test; extra: with this object before those of the library."""
        program = self.tests[name][0]
        if program not in self.links:
            built = subprocess.run(["ninja", "-C", self.build, program], capture_output=True, text=True, check=False)
            if built.returncode != 0:
                raise SystemExit(f"{program} cannot be built: {built.stdout[-400:]}")
            shown = subprocess.run(["ninja", "-C", self.build, "-t", "commands", "-s", program], capture_output=True, text=True, check=True)
            line = shown.stdout.strip().split("\n")[-1]
            self.links[program] = shlex.split(line.removeprefix(": && ").removesuffix(" && :"))
        if not extra:
            return self.build / program
        words, target = list(self.links[program]), self.work / "test"
        words[words.index("-o") + 1] = str(target)
        words.insert(next(i for i, word in enumerate(words) if word.endswith(".o")), str(extra))
        subprocess.run(words, cwd=self.build, capture_output=True, check=True)
        return target

    def run(self, name, extra=None):
        """Whether the test passes within six times its CPU, or 10 s if that is not known yet; and the last of its output."""
        program, (_, arguments, variables) = self.program(name, extra), self.tests[name]
        known = name in self.costs
        most = int(min(60, 10 + 6 * self.costs[name])) if known else 10

        def bounded():
            resource.setrlimit(resource.RLIMIT_CPU, (most, most + 1))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 30, 1 << 30))
            resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))

        environment = {**os.environ, **variables, "NSDAE_TEST_SHARE": str(self.share), "OPENBLAS_NUM_THREADS": "1"}
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        with tempfile.TemporaryDirectory(dir=self.work) as folder:
            try:
                done = subprocess.run([program, *arguments], cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True,
                                      preexec_fn=bounded, timeout=20 * most, check=False)
            except subprocess.TimeoutExpired:
                return False, "no end"
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        passed = done.returncode in (0, 77)
        if not known and (passed or not extra):
            self.costs[name] = round(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, 2)
            self.costs_file.write_text(json.dumps(self.costs, indent=0))
        return passed, (done.stdout + done.stderr)[-400:].decode(errors="replace")

    def passes_without(self, name):
        if name not in self.passes:
            self.passes[name] = self.run(name)[0]
        return self.passes[name]

    def order(self, path):
        """All tests, the nearest to a file first, of those the quick ones."""
        folder = path.split("/")[1]
        near = NEAR.get(folder, "-").split()

        def rank(name):
            unit, close = name.startswith(f"unit/{folder}/"), any(re.match(pattern, name) for pattern in near)
            return 0 if unit else 1 if close else 2, self.costs.get(name, 1)

        return sorted(self.tests, key=rank)


def reason(mutant, line):
    """Why the mutant of this line changes no answer; None: it does, as far as is known. Lines move: their text is compared."""
    table = json.loads(pathlib.Path(__file__).with_name("mutants_equivalent.json").read_text())
    at = (mutant["column"] - 1 if "column" in mutant else line.find(mutant["old"])) - (len(line) - len(line.lstrip()))
    same = {**{key: mutant[key] for key in ("file", "old", "new")}, "text": line.strip(), "at": at}
    return next((known["why"] for known in table if all(known[key] == same[key] for key in same)), None)


def tried(tests, root, mutant, most):
    """The mutant with its verdict."""
    path = root / mutant["file"]
    text = path.read_text()
    line = text.split("\n")[mutant["line"] - 1]
    result, why = dict(mutant, text=line.strip()), reason(mutant, line)
    if why:
        return dict(result, verdict="equivalent", why=why)
    changed = applied(text, mutant)
    extra = tests.compiled(path, changed)
    if not extra:
        return dict(result, verdict="does not compile")
    spent, passed = 0.0, []
    for name in tests.order(mutant["file"]):
        cost = tests.costs.get(name, 0)
        if spent + cost > most:
            continue
        began = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        passes, said = tests.run(name, extra)
        spent += resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - began
        if not passes and tests.passes_without(name):
            return dict(result, verdict="killed", by=name, said=said, passed=len(passed))
        if passes:
            passed.append(name)
    code = extra.read_bytes()
    same = tests.compiled(path, text).read_bytes() == code
    return dict(result, verdict="same code" if same else "survived", passed=passed)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("build", help="a configured build (ninja), e.g. build")
    parser.add_argument("--sample", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", help="the sample goes there, and nothing is run")
    parser.add_argument("--list")
    parser.add_argument("--only", help="numbers in the list, with commas between")
    parser.add_argument("--results", default="mutants.jsonl")
    parser.add_argument("--share", type=int, default=7, help="NSDAE_TEST_SHARE of the quick suite")
    parser.add_argument("--most", type=float, default=120, help="seconds of CPU of tests a mutant")
    given = parser.parse_args()
    root, build = pathlib.Path(__file__).resolve().parents[1], pathlib.Path(given.build).resolve()
    mutants = json.loads(pathlib.Path(given.list).read_text()) if given.list else sample(root, given.sample, given.seed)
    if given.write:
        pathlib.Path(given.write).write_text(json.dumps(mutants, indent=0) + "\n")
        return 0
    if given.only:
        mutants = [mutants[int(i)] for i in given.only.split(",")]
    results = pathlib.Path(given.results)
    done = [json.loads(line) for line in results.read_text().splitlines()] if results.exists() else []
    work = build / "mutants"
    work.mkdir(exist_ok=True)
    tests, began = Tests(build, work, given.share), time.time()
    for mutant in mutants:
        if any(all(old.get(key) == mutant.get(key) for key in ("file", "line", "column", "old", "new")) for old in done):
            continue
        result = tried(tests, root, mutant, given.most)
        done.append(result)
        with results.open("a") as out:
            out.write(json.dumps(result) + "\n")
        print(f"{result['file']}:{result['line']} {result['old']!r} -> {result['new']!r}: {result['verdict']} {result.get('by', result.get('why', ''))} "
              f"({time.time() - began:.0f} s)", flush=True)
    print("\nsurvivors:")
    for result in done:
        if result["verdict"] == "survived":
            print(f"{result['file']}:{result['line']}:{result.get('column', '')} {result['old']!r} -> {result['new']!r}: {result['text']}"
                  f" ({len(result['passed'])} tests passed)")
    for verdict in ("killed", "equivalent", "survived", "same code", "does not compile"):
        print(f"{verdict}: {sum(result['verdict'] == verdict for result in done)}")
    return 0


sys.exit(main())
