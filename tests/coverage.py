#!/usr/bin/env python3
"""Lines and branches of lib/ that tests reached, folder by folder, from the summary that llvm-cov exports.

usage: llvm-cov export -summary-only ... | coverage.py --lines PERCENT --branches PERCENT
Exit status 1 if less was reached. A branch is one of the two ways at each condition.
"""
import argparse
import collections
import json
import sys


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--lines", type=float, default=0)
    parser.add_argument("--branches", type=float, default=0)
    floors = vars(parser.parse_args())
    reached = collections.defaultdict(lambda: {kind: [0, 0] for kind in floors})
    for file in json.load(sys.stdin)["data"][0]["files"]:
        parts = file["filename"].split("/lib/", 1)
        if len(parts) == 2 and "/build/" not in parts[0]:
            for folder in (parts[1].split("/")[0], "all"):
                for kind, (covered, count) in reached[folder].items():
                    summary = file["summary"][kind]
                    reached[folder][kind] = [covered + summary["covered"], count + summary["count"]]
    if not reached:
        sys.exit("coverage: no file of lib/ in the summary")
    below = []
    for folder in sorted(reached, key=lambda name: (name == "all", name)):
        line = f"{folder:12}"
        for kind, (covered, count) in reached[folder].items():
            percent = 100 * covered / count if count else 100
            line += f"  {kind} {percent:6.2f} % ({covered} of {count})"
            if folder == "all" and percent < floors[kind]:
                below.append(f"coverage: {kind} {percent:.2f} %, below {floors[kind]:g} %")
        print(line)
    sys.exit("\n".join(below) or 0)


main()
