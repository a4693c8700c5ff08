#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""No page and no help text names a verb, an option, a command of ./dev or a CMake option that does not exist. Read are the code of all
pages (blocks, and inline code) and the examples of the help:
  - a command `nqm WORD ...`: WORD is a verb, and has each --option up to the end of the command;
  - inline code that begins with a verb or an option: the verb has the option, or some verb or program of the sources has it;
  - `./dev WORD`, -DNQM_NAME, and titles "## nqm WORD".
Of comments and messages in sources, what they name as `nqm VERB --option` is checked.
CHANGELOG.md and bench/results name what there was."""
import glob
import os
import re
import subprocess
import sys

SOURCE, TOOL = os.environ["NQM_SOURCE"], os.environ["NQM_TOOL"]
OPTION = re.compile(r"(?<![\w-])--([a-z][a-z0-9_-]*)")
STARTS = r"(?:(?:\$|time|exec|sudo|[A-Z_]+=\S*|(?:mpirun|srun)(?: -\S+(?: \d+)?)*) +)*"  # what may stand before a program
COMMAND = re.compile(STARTS + r"(?:[\w./$-]*/)?nqm +([^\s)]+)(.*)")
failures = []


def tool(*arguments):
    return subprocess.run([TOOL, *arguments], stdout=subprocess.PIPE, check=True, universal_newlines=True).stdout


def read(*patterns):
    """The text of files, joined."""
    text = ""
    for pattern in patterns:
        for path in glob.glob(os.path.join(SOURCE, pattern)):
            with open(path, encoding="utf-8") as file:
                text += file.read()
    return text


HELP = {v: tool(v, "--help") for v in re.findall(r"^  ([a-z]+)  ", tool("--help"), re.M)}
OPTIONS = {verb: set(OPTION.findall(text)) | {"help", "version"} for verb, text in HELP.items()}
# Options of other programs of the sources, whose inline code does not name the program.
OTHERS = set(re.findall(r'"(?:--)?([a-z][a-z0-9-]+)"', read("python/nqm/*.py", "studies/*.py", "models/*.py", "bench/*.py", "tools/bench/*.c")))
CMAKE, DEV = read("CMakeLists.txt", "cmake/*", "*/CMakeLists.txt"), read("dev")


def fail(place, message):
    failures.append(place)
    print("%s: %s" % (place, message))


def check_options(place, verb, text):
    for option in OPTION.findall(text):
        if option.replace("_", "-") not in OPTIONS[verb]:
            fail(place, "nqm %s has no option --%s" % (verb, option))


def check_code(place, code, is_inline):
    """Check the commands of one line of code."""
    code = re.sub(r"\s#\s.*", "", code)
    for name in re.findall(r"-D(NQM_\w+)", code):
        if not re.search(r"\b%s\b" % name, CMAKE):
            fail(place, "there is no CMake option %s" % name)
    for word in re.findall(r"^(?:\$ )?\./dev ([a-z]+)", code):
        if not re.search(r"(?m)^ *[a-z |-]*\b%s\b[a-z |-]*\)" % word, DEV):
            fail(place, "./dev has no %s" % word)
    for part in re.split(r"\|\||&&|\$\(|[|;`]", re.sub(r"'[^']*'|\"[^\"$]* [^\"$]*\"", "TEXT", code)):
        part = part.strip(' "(')
        command = COMMAND.match(part)
        word = command.group(1) if command else ""
        if word in OPTIONS:
            check_options(place, word, command.group(2))
        elif re.match(r"[a-z]+$", word):
            fail(place, "nqm has no verb %s" % word)
        first = part.split(" ")[0] if part else ""
        if is_inline and first in OPTIONS:
            check_options(place, first, part)
        elif is_inline and first.startswith("--"):
            for option in OPTION.findall(part):
                if option not in OTHERS and not any(option in known for known in OPTIONS.values()):
                    fail(place, "there is no option --%s" % option)


def check_inline(name, paragraph, number):
    """Check the inline code of a paragraph that ends before the line `number`."""
    first = number - paragraph.count("\n")
    for found in re.finditer(r"`([^`]+)`", paragraph):
        line = first + paragraph.count("\n", 0, found.start())
        check_code("%s:%d" % (name, line), found.group(1).replace("\n", " ").replace(r"\|", " or "), True)


def check_page(name, text):
    code, begin, paragraph = "", 0, ""
    is_fenced = False
    for number, line in enumerate([*text.split("\n"), ""], 1):
        is_text = not is_fenced and line.strip() and not line.startswith(("    ", "```", "|"))
        paragraph += line + "\n" if is_text else ""
        if not is_text:
            check_inline(name, paragraph, number)
            paragraph = ""
        if line.startswith("|"):
            check_inline(name, line, number)
        elif line.startswith("```"):
            is_fenced = not is_fenced
        elif is_fenced or line.startswith("    "):
            code, begin = code + " " + line.strip().rstrip("\\"), begin or number
            if line.endswith("\\"):
                continue
            check_code("%s:%d" % (name, begin), code.strip(), False)
        for word in re.findall(r"^## nqm ([a-z]+)", line):
            if word not in OPTIONS:
                fail("%s:%d" % (name, number), "nqm has no verb %s" % word)
        code, begin = "", 0


def check_source(path):
    """Check what messages and comments of a source file name as `nqm VERB`."""
    for number, line in enumerate(read(path).split("\n"), 1):
        for code in re.findall(r"`((?:build/)?nqm [^`]*)`", line):
            check_code("%s:%d" % (path, number), code, True)


os.chdir(SOURCE)
pages = [p for pattern in ("*.md", "doc/*.md", "studies/*.md", "models/*.md", "python/*.md", "examples/*.md", "packages/*.md", "web/*.md")
         for p in sorted(glob.glob(pattern)) if p != "CHANGELOG.md"]
for page in pages:
    check_page(page, read(page))
for verb, text in HELP.items():
    check_page("nqm %s --help" % verb, re.sub(r"(?m)^  ", "    ", text))
sources = [p for room in ("include", "src", "tools", "tests", "python", "studies", "models", "bench", "web", "examples", "packages", "debian", "cmake")
           for p in glob.glob(room + "/**", recursive=True) if re.search(r"\.(c|h|py|sh|html|cmake)$", p)]
for source in sources:
    check_source(source)
print("%d pages, the help of %d verbs, %d sources" % (len(pages), len(HELP), len(sources)))
sys.exit(1 if failures else 0)
