"""The programs, for tests of them in Python: those in Python run in forks of the test, which has imported them once;
those in C as they are. Failures are collected; end() prints how many there are and exits. sys.argv[1] is BIN_DIR."""

import collections
import contextlib
import os
import re
import resource
import shutil
import subprocess
import sys
import traceback

BIN = os.path.abspath(sys.argv[1])
sys.path.insert(0, os.path.join(BIN, "..", "share", "nsdae"))
import animate  # noqa: E402
import plot  # noqa: E402
import vtkhdf  # noqa: E402

MAINS = {"nsdae-animate": animate.main, "nsdae-plot": plot.main, "nsdae-vtk": vtkhdf.main}
Done = collections.namedtuple("Done", "code out err")
failures = []

QUICK = os.environ.get("NSDAE_TEST_SHARE") != "1"
# of the quick form: each kind of body, plane and list once
FEW = {"bouncing-ball": ("--t-end", "0.5"), "column": ("--set", "balls=3", "--t-end", "0.1"), "crank-slider": ("--t-end", "0.5"),
       "incline": (), "newtons-cradle": ("--t-end", "0.5"), "pendulum": ("--t-end", "3"), "rolling-ball": ("--t-end", "0.5"), "wall": ("--t-end", "0.2"),
       "woodpecker": ("--t-end", "0.3")}


def expect(holds, *what):
    if not holds:
        failures.append(" ".join(str(w) for w in what)[:400])
        print("FAILED:", failures[-1], flush=True)


@contextlib.contextmanager
def judged(*what):
    """A check that ends at its first fault, by sys.exit with the reason."""
    try:
        yield
    except SystemExit as end:
        expect(not end.code, *what, end.code)


def child(main, arguments, most):
    """The program's main as its own process would run it: exit code, output in the files out and err."""
    for number, name in ((1, "out"), (2, "err")):
        os.dup2(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644), number)
    if most:
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
    try:
        return main(list(arguments))
    except SystemExit as end:
        return end.code
    except BaseException:  # noqa: BLE001
        traceback.print_exc()
        return 1


def in_fork(main, arguments, most):
    sys.stdout.flush()
    process = os.fork()
    if process == 0:
        code = 1
        try:
            code = child(main, arguments, most)
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code or 0)
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])


def run(program, *arguments, most=None):
    """most: bytes of a file that it may write, for a program in Python."""
    if program not in MAINS:
        done = subprocess.run([os.path.join(BIN, program), *arguments], capture_output=True, text=True)
        return Done(done.returncode, done.stdout, done.stderr)
    code = in_fork(MAINS[program], arguments, most)
    texts = []
    for name in ("out", "err"):
        with open(name, encoding="utf-8") as file:
            texts.append(file.read())
    return Done(code, *texts)


def runs(program, *arguments):
    """It has no complaint; what it prints."""
    done = run(program, *arguments)
    expect(done.code == 0, program, *arguments, "exit", done.code, done.err)
    return done.out


def refuses(code, words, program, *arguments):
    """The exit code, and one line on stderr that has the words."""
    done = run(program, *arguments)
    expect(done.code == code and done.err.count("\n") == 1 and words in done.err, program, *arguments, "exit", done.code,
           "wanted", code, "stderr:", done.err, "wanted one line with:", words)


def started_by_launcher(program, *arguments):
    """As users start a program in Python; in the quick form as others, without importing its modules again."""
    if QUICK:
        return runs(program, *arguments)
    return runs_plainly([os.path.join(BIN, program), *arguments])


def runs_plainly(command):
    done = subprocess.run(command, capture_output=True, text=True)
    expect(done.returncode == 0, *command, "exit", done.returncode, done.stderr)
    return done.stdout


def examples():
    """Names of the programs that write a trajectory, without nsdae-; of the quick form those of FEW."""
    if QUICK:
        yield from FEW
        return
    for name in sorted(os.listdir(BIN)):
        if name.startswith("nsdae-") and name not in MAINS and re.search("FILE.h5 *trajectory", run(name, "--help").out):
            yield name[len("nsdae-"):]


def make(example, data, shorter=()):
    """Its trajectory by the parameters or the scene in the folder data, or its own."""
    shorter = FEW.get(example, shorter) if QUICK else shorter
    parameters, scene = (os.path.join(data, example + end) for end in (".ini", "_boxes.csv"))
    given = ["--params", parameters] if os.path.exists(parameters) else []
    if os.path.exists(scene):
        given.append(scene)
    runs(f"nsdae-{example}", "--quiet", *given, *shorter, "--output", f"{example}.h5")


def browser():
    found = shutil.which("chromium") or shutil.which("google-chrome")
    if not found and os.environ.get("CI") == "true":
        sys.exit("CI runs the pages in a browser: install chromium")
    return found


def browse(program, page, time, *how):
    return subprocess.run([program, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={os.getcwd()}/browser",
                           "--window-size=800,900", *how, f"file://{os.getcwd()}/{page}#t={time}"],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=300, check=True).stdout.decode()


def end(what="all as expected"):
    print(f"{len(failures)} failures" if failures else what)
    sys.exit(bool(failures))
