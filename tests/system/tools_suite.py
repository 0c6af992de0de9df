"""The checks of the programs in Python. This process imports matplotlib and h5py once; each check is a fork of it, in a
folder of its own. usage: tools_suite.py BIN_DIR DATA_DIR TEST_DATA_DIR SHOWN DISKS_RUN [NAME...]
With names, these checks alone. The quick forms take fewer examples and draw fewer pictures than with NSDAE_TEST_SHARE=1."""

import os
import runpy
import sys
import traceback

import tools  # noqa: F401

HERE = os.path.dirname(os.path.abspath(__file__))
BIN, DATA, OLDER, SHOWN, DISKS_RUN = (os.path.abspath(word) for word in sys.argv[1:6])
CHECKS = {"vtk": [DATA], "animate": [DATA], "plot": [DATA], "older": [OLDER], "shown": [SHOWN], "listed": [DISKS_RUN],
          "hostile": []}


def check(name):
    """Exit code of tests/system/NAME_check.py as a program."""
    os.mkdir(name)
    os.chdir(name)
    sys.argv = [os.path.join(HERE, f"{name}_check.py"), BIN, *CHECKS[name]]
    try:
        runpy.run_path(sys.argv[0], run_name="__main__")
    except SystemExit as end:
        if isinstance(end.code, str):
            print(end.code)
            return 1
        return end.code or 0
    except BaseException:  # noqa: BLE001
        traceback.print_exc()
        return 1
    return 0


def in_fork(name):
    sys.stdout.flush()
    process = os.fork()
    if process == 0:
        code = 1
        try:
            code = check(name)
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    _, status, used = os.wait4(process, 0)
    print(f"{name}: {'failed' if status else 'passed'}, {used.ru_utime + used.ru_stime:.1f} s of processor time", flush=True)
    return status


failed = [name for name in sys.argv[6:] or CHECKS if in_fork(name)]
sys.exit(f"failed: {', '.join(failed)}" if failed else 0)
