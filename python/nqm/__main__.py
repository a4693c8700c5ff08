# SPDX-License-Identifier: MIT
"""`python -m nqm ARGUMENTS`: the command-line tool that belongs to the library, or the one in PATH."""
import os
import shutil
import sys
from pathlib import Path
from typing import Optional


def tool() -> Optional[str]:
    """The tool: NQM_TOOL; in the folder of the library (a build) or in bin/ beside its lib/; in PATH."""
    if os.environ.get("NQM_TOOL"):
        return os.environ["NQM_TOOL"]
    from ._library import lib

    candidates = []
    if os.sep in lib._name:
        folder = Path(lib._name).resolve().parent
        candidates = [folder / "nqm", *(parent / "bin" / "nqm" for parent in list(folder.parents)[:2])]
    for path in candidates:
        if path.is_file() and os.access(path, os.X_OK):
            return str(path)
    return shutil.which("nqm")


def main() -> None:
    path = tool()
    if path is None:
        sys.exit("python -m nqm: the command-line tool is not installed (Debian: package nqm); set NQM_TOOL to its file")
    os.environ.setdefault("NQM_PYTHON", sys.executable)  # of `nqm doctor`
    try:
        os.execv(path, [path, *sys.argv[1:]])
    except OSError as error:
        sys.exit("python -m nqm: %s: %s" % (path, error.strerror))


if __name__ == "__main__":
    main()
