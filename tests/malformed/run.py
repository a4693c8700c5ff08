#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""run.py - writes the broken files of generate.py and compares what nqm makes of each with its verdict.

All files go through one process of build/tests/open_files, which calls the library's readers. Some of each kind also go through the tool,
which must end with the same exit code and name the file. NQM_BUILD, NQM_SOURCE and NQM_TOOL name the build, the source and the tool.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

# one verb for each kind of file; {} is the file
VERBS = {"brdf": ["check", "{}"], "model": ["score", "lambert:kd=.5", "lambert:kd=.5", "--model", "{}"], "dataset": ["info", "{}"], "directions": ["directions", "{}"],
         "list": ["batch", "{}"], "human": ["eval", "--human", "{}"], "mesh": ["render", "lambert:kd=.5", "--size", "8", "-o", "x.png", "--shape", "{}"],
         "image": ["render", "lambert:kd=.5", "--size", "8", "-o", "x.png", "--light", "{}"], "map": ["render", "maps:base_color={}", "--size", "8", "-o", "x.png"]}
EVERY = 12


def open_all(build, folder, verdicts):
    lines = "".join("%s\t%s\n" % (kind, name) for name, kind, _, _ in verdicts)
    done = subprocess.run([os.path.join(build, "tests", "open_files")], input=lines.encode(), stdout=subprocess.PIPE, cwd=folder,
                          timeout=250, check=False)
    answers = [line.split("\t", 1) for line in done.stdout.decode("utf-8", "replace").splitlines()]
    if done.returncode != 0:
        print("open_files ended with %d at %s" % (done.returncode, verdicts[len(answers)][0] if len(answers) < len(verdicts) else "its end"))
    return done.returncode, answers


def judge(verdict, code, message):
    name, _, expected, says = verdict
    fault = ""
    if code != expected:
        fault = "exit code %s, not %s" % (code, expected)
    elif says not in message or (says == "byte" and not re.search("byte [0-9]", message)):
        fault = "no '%s'" % says
    if fault:
        print("%s: %s: %s" % (name, fault, message))
    return not fault


def check_tool(tool, folder, verdicts, answers):
    """Every EVERY-th file through the verb of its kind."""
    n, failed = 0, 0
    for verdict, answer in list(zip(verdicts, answers))[::EVERY]:
        if verdict[1] not in VERBS:
            continue
        words = [word.replace("{}", verdict[0]) for word in VERBS[verdict[1]]]
        done = subprocess.run([tool] + words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=100, check=False)
        message = done.stderr.decode("utf-8", "replace")
        n += 1
        if str(done.returncode) != answer[0] or verdict[0].split(":")[0].split("/")[0] not in message or done.stdout:
            failed += 1
            print("nqm %s: exit code %d, not %s: %s" % (" ".join(words), done.returncode, answer[0], message))
    return n, failed


def main():
    build, source, tool = os.environ["NQM_BUILD"], os.environ["NQM_SOURCE"], os.environ["NQM_TOOL"]
    work = tempfile.mkdtemp()
    try:
        seeds, folder = os.path.join(work, "seeds"), os.path.join(work, "files")
        os.mkdir(seeds)
        subprocess.run([os.path.join(build, "tests", "make_brdf_files"), seeds], check=True)
        for program in ("tiny_model", "tiny_dataset"):
            target = os.path.join(seeds, "valid-%s.safetensors" % program[5:])
            subprocess.run([os.path.join(build, "tests", program), target], check=True)
        subprocess.run([sys.executable, os.path.join(source, "tests", "malformed", "generate.py"), seeds, folder], check=True)
        with open(os.path.join(folder, "verdicts.tsv"), encoding="utf-8") as f:
            verdicts = [tuple(line.rstrip("\n").split("\t")) for line in f]
        code, answers = open_all(build, folder, verdicts)
        failed = sum(not judge(v, a[0], a[1]) for v, a in zip(verdicts, answers))
        n_tool, failed_tool = check_tool(tool, folder, verdicts, answers)
        print("%d broken files, %d wrong verdicts; %d of them by the tool, %d wrong" % (len(verdicts), failed, n_tool, failed_tool))
        sys.exit(code != 0 or failed or failed_tool or len(answers) != len(verdicts) or len(verdicts) < 400)
    finally:
        shutil.rmtree(work)


if __name__ == "__main__":
    main()
