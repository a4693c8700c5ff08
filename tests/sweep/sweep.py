#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sweep.py [N [SEED [FORMAT]]] - writes N files of each format from its grammar (grammars.py) and reads all with read_materials.

Of each file: it is accepted, or refused for what the grammar says. Each of its statements is dropped, and given another value, in turn:
what nqm makes of the file changes, or a remark, a list of what has no effect or a refusal of the whole file names the statement: nothing is
lost in silence. And each is broken in turn: the file is refused, with the name of the statement in the reason. NQM_BUILD names the build.
"""
import os
import shutil
import subprocess
import sys
import tempfile

import grammars

SAID = ("remark", "unused", "refusal", "error", "fault", "ignorable")


class Answer:
    """What read_materials says of a file."""

    def __init__(self, line):
        self.line = line
        fields = [field.partition("=") for field in line.split("\t") if field]
        self.said = " ".join(value for name, _, value in fields if name in SAID)
        self.unused = " ".join(value for name, _, value in fields if name in ("unused", "remark")).lower()
        self.refusal = " ".join(value for name, _, value in fields if name in ("refusal", "error", "fault"))
        self.ignorable = any(name == "ignorable" and value for name, _, value in fields)
        self.has_maps = any(name == "maps" for name, _, _ in fields)
        self.is_out_of_range = any(name == "fault" for name, _, _ in fields)

    def is_refused(self):
        return self.is_out_of_range or (bool(self.refusal) and not self.has_maps and not self.ignorable)

    def names(self, word):
        return word.lower() in self.said.lower()


def write(folder, number, case, text):
    """The path, relative to the folder, of a file with this text; of a folder of maps, which has one file a line, of the folder."""
    where = os.path.join(folder, "%d%s" % (number, case.ending))
    if case.ending:
        with open(where, "w", encoding="utf-8") as f:
            f.write(text)
    else:
        os.mkdir(where)
        for name in text.split():
            with open(os.path.join(where, name), "wb") as f:
                f.write(grammars.PIXEL)
    return os.path.basename(where)


def read_all(folder, names):
    program = os.path.join(os.environ["NQM_BUILD"], "tests", "read_materials")
    done = subprocess.run([program], input="".join(name + "\n" for name in names).encode(), stdout=subprocess.PIPE, cwd=folder, check=False)
    lines = done.stdout.decode("utf-8", "replace").split("\n")
    if done.returncode != 0:
        sys.exit("read_materials ended with %d at %s" % (done.returncode, names[len(lines) - 1]))
    # the name of the file and the places in it are no part of the answer
    return [Answer(line.replace(name, "FILE")) for line, name in zip(lines, names)]


def judge(case, answers):
    """The faults of one file: pairs of what is wrong and the text for which it is."""
    base, rest = answers[0], iter(answers[1:])
    if case.refused is None and base.is_refused():
        yield "refused: " + base.refusal, case.text
    elif case.refused is not None and not (base.refusal and base.names(case.refused)):
        yield "not refused for " + case.refused, case.text
    for change in case.changes:
        answer = next(rest)
        if answer.line == base.line and not base.is_refused() and not any(base.names(name) for name in change.names):
            yield "%s %s: nothing changes, and nothing names it" % (change.how, change.name), change.text
    for change in case.breaks:
        answer = next(rest)
        if base.ignorable or any(name.lower() in base.unused for name in change.names):
            continue  # what has no effect may be anything; what is refused has one reason
        if any(name.lower() in answer.unused for name in change.names):
            continue  # as readers of the format do
        if not answer.refusal or (answer.has_maps and not answer.is_out_of_range):
            yield "%s %s: not refused" % (change.how, change.name), change.text
        elif not any(answer.names(name) for name in change.names):
            yield "%s %s: refused without its name: %s" % (change.how, change.name, answer.refusal), change.text


def main():
    n, seed = (int(x) for x in (sys.argv[1:3] + ["300", "1"][len(sys.argv[1:3]):]))
    total = {}
    n_faults = 0
    for name in sys.argv[3:] or grammars.FORMATS:
        folder = tempfile.mkdtemp()
        try:
            cases = [grammars.make(name, seed, i) for i in range(n)]
            texts = [(case, text) for case in cases for text in case.texts()]
            answers = read_all(folder, [write(folder, i, case, text) for i, (case, text) in enumerate(texts)])
        finally:
            shutil.rmtree(folder)
        kinds, at = {}, 0
        for case in cases:
            mine = answers[at:at + 1 + len(case.changes) + len(case.breaks)]
            at += len(mine)
            for what, text in judge(case, mine):
                kinds.setdefault(what.split(":")[0] if ": nothing" in what else what[:90], []).append((what, text))
        for kind in sorted(kinds):
            print("%s: %d of: %s\n%s\n" % (name, len(kinds[kind]), kinds[kind][0][0], kinds[kind][0][1]))
        n_faults += sum(len(k) for k in kinds.values())
        total[name] = (len(texts), sum(a.is_refused() for a in answers))
    for name, (n_texts, n_refused) in total.items():
        print("%s: %d files in %d versions, %d of them refused" % (name, n, n_texts, n_refused))
    print("%d faults" % n_faults)
    sys.exit(n_faults > 0)


if __name__ == "__main__":
    main()
