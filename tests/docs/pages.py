#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Run the commands of one documentation page and compare what they print with what the page shows.

usage: pages.py PAGE.md        (environment: NQM_SOURCE, NQM_BUILD; NQM_DATA and NQM_DOCS=full are optional)

A code block is indented by four spaces or fenced by ```. It is one of
  - a session: lines "$ COMMAND", each followed by the lines that it prints ("..." matches any text; alone, any lines);
  - a list of commands: every line begins with a command word (nqm, ./dev, sh, cc, ...); a trailing backslash continues it;
  - C code, fenced as ```c: compiled as C11 against the headers; linked and run when it has a main function;
  - anything else: text, which must not hold a line that begins with a command word.
All blocks of a page run in order in one scratch folder, a copy of the files that tests/docs/files.sh has made.
Comments <!-- test: WORD... --> before a block change what is done with it:
  skip because REASON   not run
  text                  not commands, although it looks like them
  data                  needs measured data in $DATA (NQM_DATA, or ../shared/data); without it the page ends as skipped (77)
  slow                  run only when NQM_DOCS=full (./dev test all)
  tolerance X           relative tolerance of numbers, or one unit of the last printed place; without it they are as printed
  exit N                the last command ends with exit code N instead of 0
Blocks with python3 -m nqm.plot are run by the first Python that has matplotlib, and skipped without one.
Relative links and their anchors must exist. In inline code every function nqm_...() must be in a public header, and every path that begins
with a folder of the repository must exist. In a row of a table that names source files, a function without a public header may be in one of
these. (tests/structure/words.py reads verbs and options.)
"""
import glob
import os
import re
import subprocess
import sys
import tempfile
import time

SOURCE, BUILD = os.environ["NQM_SOURCE"], os.environ["NQM_BUILD"]
WORDS = ("nqm", "models/scan.py", "models/plan.py", "studies/reproduce.py", "./dev", "build/nqm", "sh", "cc", "git", "awk", "python3", "/usr/bin/python3", "cmake", "mpirun", "sed")
COMMAND = re.compile(r"(?:%s)(?: |$)" % "|".join(re.escape(w) for w in WORDS))
NUMBER = re.compile(r"[-+]?(?:\d[\d,]*\d|\d)?\.?\d+(?:[eE][-+]?\d+)?")
failures = []


def fail(line, message):
    failures.append(line)
    print("%s:%d: %s" % (sys.argv[1], line, message))


def blocks(lines):
    """Yield (line number, fence or None, directives, lines) of every code block."""
    directives, i = [], 0
    while i < len(lines):
        line = lines[i]
        comment = re.match(r"<!-- test: (.*?) -->$", line)
        fence = re.match(r"```(\w*)$", line)
        if comment:
            directives.append(comment.group(1))
            i += 1
        elif fence:
            end = lines.index("```", i + 1)
            yield i + 2, fence.group(1), directives, lines[i + 1:end]
            directives, i = [], end + 1
        elif line.startswith("    ") and (i == 0 or not lines[i - 1].strip() or directives):
            end = i
            while end < len(lines) and (lines[end].startswith("    ") or
                                        (not lines[end] and end + 1 < len(lines) and lines[end + 1].startswith("    "))):
                end += 1
            yield i + 1, None, directives, [x[4:] for x in lines[i:end]]
            directives, i = [], end
        else:
            if line.strip() and directives:
                fail(i + 1, "a test comment must be directly before a code block")
                directives = []
            i += 1


def commands(block):
    """Split a block into [offset, command, printed lines], or return None when it is text."""
    session = any(x.startswith("$ ") for x in block)
    if not session and not (COMMAND.match(block[0]) and all(COMMAND.match(x) or not x or x[0] in " #" for x in block)):
        return None
    found, continued = [], False
    for offset, line in enumerate(block):
        if continued:
            found[-1][1] += "\n" + line
        elif line.startswith("$ ") or (not session and line.strip() and not line.startswith("#")):
            found.append([offset, line[2:] if session else line, []])
        elif found and session:
            found[-1][2].append(line)
        continued = bool(found) and line.endswith("\\") and not found[-1][2]
    return found or None


def same_number(shown, printed, tolerance, is_cut):
    """As printed, to "..." if the page cuts it; with a tolerance, relative, or one of the last digit."""
    if tolerance == 0:
        return printed.startswith(shown) if is_cut else shown == printed
    try:
        a, b = float(shown.replace(",", "")), float(printed.replace(",", ""))
    except ValueError:
        return shown == printed
    digits, _, exponent = shown.lower().partition("e")
    unit = 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2])) if "." in digits else 0
    return abs(a - b) <= max(tolerance * abs(a), 1.01 * unit)


def same_line(shown, printed, tolerance):
    """Words must be equal, numbers close; runs of blanks count as one; "..." matches any text."""
    shown, printed = " ".join(shown.split()), " ".join(printed.split())
    words, numbers = NUMBER.split(shown), NUMBER.findall(shown)
    pattern = ""
    for i, word in enumerate(words):
        pattern += ".*".join(re.escape(x) for x in word.split("...")) + ("(%s)" % NUMBER.pattern if i < len(numbers) else "")
    match = re.fullmatch(pattern, printed)
    return bool(match) and all(same_number(a, b, tolerance, after.startswith("..."))
                               for a, b, after in zip(numbers, match.groups(), words[1:]))


def same_output(shown, printed, tolerance):
    """Compare lists of lines; a shown line "..." matches any number of lines. Return the first line that differs."""
    if not shown:
        return None if not printed else "(nothing more)"
    if shown[0].strip() == "...":
        rest = shown[1:]
        return None if any(same_output(rest, printed[i:], tolerance) is None for i in range(len(printed) + 1)) else " ".join(rest[:1])
    if not printed or not same_line(shown[0], printed[0], tolerance):
        return shown[0]
    return same_output(shown[1:], printed[1:], tolerance)


def run_block(number, found, tolerance, last_exit, folder, environment):
    for i, (offset, command, shown) in enumerate(found):
        begin = time.monotonic()
        done = subprocess.run(["/bin/sh", "-c", command], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace")
        if time.monotonic() - begin > 5:
            print("%s:%d: %.0f s: %s" % (sys.argv[1], number + offset, time.monotonic() - begin, command))
        said = "\n--- standard output\n%s--- standard error\n%s" % (done.stdout[-3000:], done.stderr[-2000:])
        expected = last_exit if i + 1 == len(found) else 0
        if done.returncode != expected:
            fail(number + offset, "exit code %d instead of %d: %s%s" % (done.returncode, expected, command, said))
            return
        shown = [x for x in shown if x.strip()]
        if shown:
            difference = same_output(shown, [x for x in done.stdout.splitlines() if x.strip()], tolerance)
            if difference is not None:
                fail(number + offset, "%s\nprints something else than the page shows, first at: %s%s" % (command, difference, said))


def run_c(number, code, folder, environment):
    """Compile C code; a fragment becomes the body of a function. Run what has a main function."""
    whole = re.search(r"\bint main\(", code)
    if not whole:
        code = "#include <nqm/nqm.h>\n#include <stdio.h>\nint fragment(void);\nint fragment(void) {\n%s\nreturn 0;\n}\n" % code
    with open(os.path.join(folder, "page.c"), "w") as out:
        out.write(code)
    command = "cc -std=c11 -Wall -Wextra -Werror -I'%s/include' page.c " % SOURCE
    command += "-o page -L'%s' -lnqm-full -Wl,-rpath,'%s' && ./page" % (BUILD, BUILD) if whole else "-fsyntax-only"
    run_block(number, [[0, command, []]], 0, 0, folder, environment)


def plotting_python(environment):
    """A Python that has NumPy and matplotlib; None: there is none."""
    for python in ("python3", "/usr/bin/python3"):
        if subprocess.run([python, "-c", "import numpy, matplotlib"], env=environment, stderr=subprocess.DEVNULL).returncode == 0:
            return python
    return None


def check_links(page, lines):
    def slugs(path):
        with open(path) as text:
            heads = [re.sub(r"[^\w\- ]", "", h.strip().lower()).replace(" ", "-") for h in re.findall(r"(?m)^#+ (.*)$", text.read())]
        return heads
    for number, line in enumerate(lines, 1):
        for target in re.findall(r"\]\(([^)\s]+)\)", line):
            if re.match(r"\w+:", target):
                continue
            path, _, anchor = target.partition("#")
            path = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
            if not os.path.exists(path):
                fail(number, "link to %s, which does not exist" % target)
            elif anchor and anchor not in slugs(path):
                fail(number, "link to %s: no such heading" % target)


def text_of_files(codes):
    """The source files among the codes, joined."""
    text = ""
    for path in codes:
        if re.match(r"(?:src|tools)/[\w./-]*\.[ch]$", path) and os.path.exists(os.path.join(SOURCE, path)):
            with open(os.path.join(SOURCE, path)) as source:
                text += source.read()
    return text


def check_names(lines):
    headers = ""
    for name in os.listdir(SOURCE + "/include/nqm"):
        with open(SOURCE + "/include/nqm/" + name) as text:
            headers += text.read()
    for number, line in enumerate(lines, 1):
        codes = re.findall(r"`([^`]*)`", line)
        row = text_of_files(codes) if line.startswith("|") else ""
        for code in codes:
            for name in re.findall(r"\b(\w+)\(\)", code) if row else re.findall(r"\b(nqm_\w+)\(\)", code):
                if not re.search(r"\b%s\(" % name, row or headers):
                    fail(number, "%s() is in %s" % (name, "none of the files of its row" if row else "no public header"))
            for path in re.findall(r"^(?:src|include|tests|models|studies|doc|tools|examples|fuzz|presets|bench|nqm)/[\w./*-]*$", code):
                if not glob.glob(os.path.join(SOURCE, "include" if path.startswith("nqm/") else "", path)):
                    fail(number, "%s does not exist" % path)


def main():
    page = os.path.abspath(sys.argv[1])
    with open(page) as text:
        lines = text.read().split("\n")
    data = os.environ.get("NQM_DATA") or os.path.abspath(SOURCE + "/../shared/data")
    environment = dict(os.environ, PATH=BUILD + ":" + os.environ["PATH"], LC_ALL="C", DATA=data if os.path.isdir(data) else "",
                       PYTHONPATH=SOURCE + "/python", PYTHONDONTWRITEBYTECODE="1", NQM_LIBRARY=BUILD + "/libnqm-full.so", OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    counts = {"run": 0, "skipped": 0, "slow": 0, "no data": 0, "no matplotlib": 0}
    python = plotting_python(environment) if any("nqm.plot" in line for line in lines) else "python3"
    check_links(page, lines)
    check_names(lines)
    with tempfile.TemporaryDirectory() as folder:
        if any(fence == "c" or commands(block) for _, fence, _, block in blocks(lines)):
            subprocess.run(["cp", "-r", BUILD + "/docs-files/.", folder], check=True)
        for name in ("examples", "models", "studies", "doc"):
            os.symlink(os.path.join(SOURCE, name), os.path.join(folder, name))
        os.symlink(BUILD, os.path.join(folder, "build"))
        for number, fence, directives, block in blocks(lines):
            word = {d.split()[0]: d for d in directives}
            for w in word:
                if w not in ("skip", "text", "data", "slow", "tolerance", "exit"):
                    fail(number, "unknown test comment: " + word[w])
            found = commands(block)
            if "skip" in word:
                if not re.match(r"skip because \S+ \S+", word["skip"]):
                    fail(number, "say why: skip because REASON")
                counts["skipped"] += 1
                print("%s:%d: %s" % (os.path.basename(page), number, word["skip"]))
            elif "text" in word or (fence != "c" and not found):
                if "text" not in word and any(COMMAND.match(x) for x in block):
                    fail(number, "a block with commands that is neither run nor skipped: begin commands with '$ '")
            elif "data" in word and not environment["DATA"]:
                counts["no data"] += 1
            elif "slow" in word and os.environ.get("NQM_DOCS") != "full":
                counts["slow"] += 1
            elif not python and any("nqm.plot" in command for _, command, _ in found):
                counts["no matplotlib"] += 1
            else:
                counts["run"] += 1
                found = [(offset, command.replace("python3 -m nqm.plot", "%s -m nqm.plot" % python), shown) for offset, command, shown in found]
                if fence == "c":
                    run_c(number, "\n".join(block), folder, environment)
                else:
                    run_block(number, found, float(word.get("tolerance", "- 0").split()[1]),
                              int(word.get("exit", "- 0").split()[1]), folder, environment)
    print("%s: %s" % (os.path.basename(page), ", ".join("%d %s" % (n, w) for w, n in counts.items())))
    if failures:
        return 1
    if counts["no data"]:
        print("SKIPPED: %d blocks of %s need measured data; set NQM_DATA" % (counts["no data"], page))
        return 77
    return 0


sys.exit(main())
