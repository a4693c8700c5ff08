# SPDX-License-Identifier: MIT
"""coverage.py BUILD: print the lines and branches that the tests of a build with NQM_COVERAGE have run, for each room; ends with 1
below the limits. Needs gcovr."""

import collections
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
LEAST = {"line": 96.0, "branch": 83.0}  # %


def counts(build):
    """{room: {"line": [run, all], "branch": [..]}} of the rooms of src/ and tools/."""
    command = ["gcovr", "--root", str(ROOT), "--object-directory", build, "--filter", str(ROOT / "src"), "--filter", str(ROOT / "tools"),
               "--exclude-unreachable-branches", "--gcov-ignore-parse-errors", "--json-summary", "-j", "2", build]
    ran = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    if ran.returncode:
        sys.exit(ran.stderr)
    files = json.loads(ran.stdout)["files"]  # stderr names branches with negative counts, where threads met
    rooms = collections.defaultdict(lambda: {kind: [0, 0] for kind in LEAST})
    for file in files:
        parts = pathlib.PurePath(file["filename"]).parts
        room = "/".join(parts[: 3 if parts[1] == "nqm" and len(parts) > 3 else 2])
        for kind in LEAST:
            for name in (room, "all"):
                rooms[name][kind][0] += file[f"{kind}_covered"]
                rooms[name][kind][1] += file[f"{kind}_total"]
    return rooms


def main(build):
    rooms = counts(build)
    percent = {room: {kind: 100 * n / (total or 1) for kind, (n, total) in kinds.items()} for room, kinds in rooms.items()}
    print(f"{'room':20} {'lines':>7} {'%':>6} {'branches':>9} {'%':>6}")
    for room in sorted(rooms, key=lambda name: (name == "all", name)):
        (_, lines), (_, branches) = (rooms[room][kind] for kind in LEAST)
        print(f"{room:20} {lines:7} {percent[room]['line']:6.1f} {branches:9} {percent[room]['branch']:6.1f}")
    low = [f"{percent['all'][kind]:.1f} % of {kind}s are run, at least {least:g} % are needed" for kind, least in LEAST.items()
           if percent["all"][kind] < least]
    print(*low, sep="\n", end="\n" if low else "")
    sys.exit(bool(low))


if __name__ == "__main__":
    main(sys.argv[1])
