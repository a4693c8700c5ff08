# SPDX-License-Identifier: MIT
"""draw.py SEED [TOTAL]: candidates for mutations.txt. Each room of src/, tools/ and python/ gets its share of TOTAL (200) mutations by
lines of code; what it lacks is drawn at random, twice as often, so that a person can leave out those that are no fault: lines that only
decide speed, order or messages. Prints rows of the list without their tests."""

import collections
import pathlib
import random
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from run import MUTATIONS  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
SWAPS = [(" < ", " <= "), (" <= ", " < "), (" > ", " >= "), (" >= ", " > "), (" == ", " != "), (" != ", " == "), (" && ", " || "),
         (" || ", " && "), (" + ", " - "), (" - ", " + "), (" * ", " / "), (" / ", " * "), ("true", "false"), ("false", "true"),
         (" += ", " -= "), (" -= ", " += "), (" and ", " or "), (" or ", " and "), ("fmin(", "fmax("), ("fmax(", "fmin("), ("sin(", "cos("),
         ("cos(", "sin(")]


def room_of(path):
    return "/".join(path.parts[:2])


def changes(line):
    """The line with one operator or number changed, in every way."""
    code = re.sub(r'"(\\.|[^"\\])*"|/\*.*', lambda m: "\0" * len(m[0]), line)  # not in strings and comments
    for old, new in SWAPS:
        for m in re.finditer(re.escape(old), code):
            yield line[:m.start()] + new + line[m.end():]
    for m in re.finditer(r"(?<![\w.])(\d+)(?![\w.])", code):
        yield line[:m.start()] + str(int(m[1]) + 1) + line[m.end():]


def main(seed, total):
    files = [path.relative_to(ROOT) for top in ("src", "tools", "python") for path in sorted((ROOT / top).rglob("*"))
             if path.suffix in (".c", ".h", ".py") and len(path.relative_to(ROOT).parts) > 2]
    texts = {path: (ROOT / path).read_text().splitlines() for path in files}
    lines, have = collections.Counter(), collections.Counter(room_of(pathlib.Path(m[0])) for m in MUTATIONS)
    for path in files:
        lines[room_of(path)] += len(texts[path])
    rng = random.Random(seed)
    for room in sorted(lines):
        lacks = round(total * lines[room] / sum(lines.values())) - have[room]
        pool = [(path, line) for path in files if room_of(path) == room for line in texts[path]
                if texts[path].count(line) == 1 and not re.match(r"\s*(\*|/\*|#|//)", line) and any(changes(line))]
        for path, line in rng.sample(pool, min(len(pool), 2 * max(0, lacks))):
            print(f"{path}: \n- {line.strip()}\n+ {rng.choice(list(changes(line))).strip()}")


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 200)
