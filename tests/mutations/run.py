# SPDX-License-Identifier: MIT
"""run.py check: every old text of mutations.txt occurs exactly once.
run.py [NUMBER...]: apply each mutation, or those with these numbers (from 1), to a copy of the sources in build-mutate/, rebuild
and run the tests that are expected to fail; then all unit tests on those that survived and are not explained. Prints a line for
each mutation. Ends with 1 unless each survivor is explained, and with 2 when a mutation cannot be applied or compiled."""

import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK = ROOT / "build-mutate"
SECONDS = 600  # of one test; a mutation may make a loop endless
LEAST = 200


def read_mutations():
    """The rows of mutations.txt: [file, old text, new text, tests], and the reason if no test can notice it."""
    rows = []
    for line in pathlib.Path(__file__).with_name("mutations.txt").read_text().splitlines():
        if line[:1] in ("-", "+"):
            rows[-1].insert(-1, line[2:])
        elif line[:1] == "?":
            rows[-1].append(line[2:])
        elif line and line[0] != "#":
            rows.append(line.split(": "))
    return rows


MUTATIONS = read_mutations()


def faults():
    """What is wrong with the list."""
    texts = [] if len(MUTATIONS) >= LEAST else [f"{len(MUTATIONS)} mutations, at least {LEAST} are needed"]
    for number, (file, old, new, tests, *_) in enumerate(MUTATIONS, 1):
        path = ROOT / file
        count = path.read_text().count(old) if path.exists() else 0
        if count != 1:
            texts.append(f"{number}: {file}: the old text occurs {count} times, not once: {old}")
        if old == new or "\n" in old + new:
            texts.append(f"{number}: {file}: needs one changed line: {old}")
        for test in tests.split():
            script = ROOT / "tests" / test.replace(".", "/")
            if not any(path.exists() for path in (script.with_suffix(".sh"), script.with_suffix(".py"), ROOT / f"tests/unit/{test}.c")):
                texts.append(f"{number}: there is no test {test}")
    return texts


def run(command, **more):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)


def build(targets):
    return run(["cmake", "--build", str(WORK / "build"), "--target", *targets])


def prepare():
    """Make the copy equal to the tracked files, and configure a build. Equal files keep their time, others get that of now: objects
    of an earlier run may be newer than the original."""
    source = WORK / "source"
    names = set(run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT).stdout.splitlines())
    for path in [path for path in source.rglob("*") if path.is_file()]:
        if str(path.relative_to(source)) not in names:
            path.unlink()
    for name in names:
        old, new = ROOT / name, source / name
        if old.is_file() and not (new.is_file() and new.read_bytes() == old.read_bytes()):
            new.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(old, new)
    options = ["-DCMAKE_C_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    os.environ.update(CCACHE_BASEDIR=str(WORK), CCACHE_NOHASHDIR="1", CCACHE_SLOPPINESS="time_macros")
    os.environ.setdefault("NQM_DATA", str(ROOT.parent / "shared/data"))
    done = run(["cmake", "-S", str(source), "-B", str(WORK / "build"), "-G", "Ninja", *options])
    if done.returncode:
        sys.exit(done.stdout)
    return source


def targets_of(tests):
    """What must be built for these tests: a script needs the tool and the programs that make its inputs."""
    names = ["_".join(test.split("_")[:2]) for test in tests if "." not in test]  # a program a room
    if len(names) < len(tests):
        names += ["nqm_tool", "nqm_full", "tiny_model", "tiny_dataset", "make_brdf_files"]
    return names


def fails(pattern):
    """Whether one of the tests fails, or takes too long."""
    done = run(["ctest", "--test-dir", str(WORK / "build"), "-R", pattern, "--timeout", str(SECONDS), "-j2"])
    if "No tests were found" in done.stdout:
        sys.exit(done.stdout)
    return done.returncode != 0


def try_mutation(source, number, is_wide):
    """'noticed', 'noticed by others', 'survives' or 'does not compile'. is_wide: with all unit tests."""
    file, old, new, tests = MUTATIONS[number - 1][:4]
    path, tests = source / file, tests.split()
    names = "|".join(test if "." in test else f"unit.{test}" for test in tests)
    text = path.read_text()
    path.write_text(text.replace(old, new))
    try:
        if build(["all"] if is_wide else targets_of(tests)).returncode:
            return "does not compile"
        if fails("^unit[.]" if is_wide else f"^({names})$"):
            return "noticed by others" if is_wide else "noticed"
        return "survives"
    finally:
        path.write_text(text)


def main(numbers):
    source, results = prepare(), {}
    done = build(sorted({name for n in numbers for name in targets_of(MUTATIONS[n - 1][3].split())}))
    if done.returncode:
        sys.exit(done.stdout[-4000:])
    for is_wide in (False, True):
        for number in [n for n in numbers if not is_wide or results[n] == "survives"]:
            file, old, new, _, *why = MUTATIONS[number - 1]
            if is_wide and why:
                continue
            results[number] = try_mutation(source, number, is_wide)
            print(f"{number:3} {results[number]}: {file}", flush=True)
            if not results[number].startswith("noticed"):
                print(f"      - {old}\n      + {new}" + "".join(f"\n      {text}" for text in why), flush=True)
    words = list(results.values())
    unexplained = sum(word == "survives" and len(MUTATIONS[n - 1]) < 5 for n, word in results.items())
    print(", ".join(f"{words.count(word)} {word}" for word in sorted(set(words))) + f"; {unexplained} survive without an explanation")
    sys.exit(2 if "does not compile" in words else unexplained > 0)


if __name__ == "__main__":
    problems = faults()
    if problems:
        print(*problems, sep="\n")
        sys.exit(2)
    if sys.argv[1:] != ["check"]:
        main([int(text) for text in sys.argv[1:]] or range(1, len(MUTATIONS) + 1))
