#!/usr/bin/env python3
"""Tests that take longer than a bound, the longest first.

usage: times.py RESULTS.xml [SECONDS]

RESULTS.xml is what `ctest --output-junit RESULTS.xml` writes. Its times are those of a clock on the
wall: read them of a machine that does nothing else, with as many tests at a time as it has cores.
SECONDS is 3 without it, the bound of the quick form. The exit is 0 whatever is found: a test fails
by what it finds, never by its time.
"""
import sys
import xml.etree.ElementTree


def times(path):
    """(seconds, name) of each test that ran."""
    for case in xml.etree.ElementTree.parse(path).getroot().iter("testcase"):
        if case.get("status") in ("run", "fail"):
            yield float(case.get("time", 0)), case.get("name")


def main():
    if not 2 <= len(sys.argv) <= 3:
        sys.exit(__doc__.strip())
    bound = float(sys.argv[2]) if len(sys.argv) > 2 else 3.0
    found = sorted(times(sys.argv[1]), reverse=True)
    longer = [(seconds, name) for seconds, name in found if seconds > bound]
    for seconds, name in longer:
        print(f"{seconds:8.2f} s  {name}")
    total = sum(seconds for seconds, _ in found)
    print(f"{len(longer)} of {len(found)} tests take more than {bound:g} s; all together {total:.0f} s")


if __name__ == "__main__":
    main()
