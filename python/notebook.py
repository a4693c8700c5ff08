#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Run the code cells of a notebook in order, without Jupyter.

usage: notebook.py NOTEBOOK.ipynb            compare what the cells print with the stored outputs; the exit code is 1 if they differ
       notebook.py NOTEBOOK.ipynb --write    store the outputs and figures

Numbers may differ by 5 %. Without matplotlib figures are left out: everything else runs."""
import ast
import base64
import contextlib
import io
import json
import re
import sys
import types
from unittest import mock

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def prepare_figures():
    """matplotlib without a display; or something that takes its calls."""
    try:
        import matplotlib
    except ImportError:
        import numpy as np

        def subplots(rows=1, columns=1, **options):
            axes = np.array([[mock.Mock() for _ in range(columns)] for _ in range(rows)])
            return mock.Mock(), axes.squeeze() if rows * columns > 1 else axes[0, 0]

        plt = mock.Mock(subplots=subplots)
        sys.modules["matplotlib"] = types.SimpleNamespace(pyplot=plt)
        sys.modules["matplotlib.pyplot"] = plt
        return None
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    return plt


def figures(plt):
    """The figures that a cell has drawn, as PNG in base64."""
    found = []
    for number in plt.get_fignums() if plt else []:
        data = io.BytesIO()
        # No version and no date, so that the same figure makes the same file.
        plt.figure(number).savefig(data, format="png", dpi=72, bbox_inches="tight", metadata={"Software": None})
        found.append(base64.b64encode(data.getvalue()).decode())
    if plt:
        plt.close("all")
    return found


def run(source, names):
    """What a cell prints, and the text of its last expression or None."""
    tree = ast.parse(source)
    shown = tree.body and isinstance(tree.body[-1], ast.Expr) and not source.rstrip().endswith(";")  # as in Jupyter
    last = tree.body.pop() if shown else None
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), names)
        value = eval(compile(ast.Expression(last.value), "cell", "eval"), names) if last else None
    return printed.getvalue(), None if value is None or isinstance(value, mock.Mock) else repr(value)


def outputs_of(printed, value, pictures, count):
    out = []
    if printed:
        out.append({"name": "stdout", "output_type": "stream", "text": printed.splitlines(True)})
    if value is not None:
        out.append({"data": {"text/plain": value.splitlines(True)}, "execution_count": count, "metadata": {},
                    "output_type": "execute_result"})
    out += [{"data": {"image/png": p}, "metadata": {}, "output_type": "display_data"} for p in pictures]
    return out


def text_of(outputs):
    return "".join("".join(o.get("text", o.get("data", {}).get("text/plain", []))) + "\n" for o in outputs)


def close(a, b):
    x, y = NUMBER.findall(a), NUMBER.findall(b)
    return NUMBER.sub("0", a).split() == NUMBER.sub("0", b).split() and len(x) == len(y) and all(
        abs(float(p) - float(q)) <= .05 * abs(float(p)) + .011 for p, q in zip(x, y))


def main():
    path, write = sys.argv[1], "--write" in sys.argv[2:]
    with open(path, encoding="utf-8") as file:
        notebook = json.load(file)
    if notebook.get("nbformat") != 4:
        sys.exit("%s: not a notebook of format 4" % path)
    plt, names, count, differ, n_figures = prepare_figures(), {}, 0, 0, 0
    for cell in notebook["cells"]:
        if cell["cell_type"] != "code":
            continue
        count += 1
        printed, value = run("".join(cell["source"]), names)
        pictures = figures(plt)
        made = outputs_of(printed, value, pictures, count)
        stored = [o for o in cell["outputs"] if "image/png" in o.get("data", {})]
        n_figures += len(stored)
        if write:
            cell["outputs"], cell["execution_count"] = made, count
        elif not close(text_of(cell["outputs"]), text_of(made)) or (plt and len(stored) != len(pictures)):
            differ += 1
            print("%s: cell %d stores\n%s\nand gives\n%s" % (path, count, text_of(cell["outputs"]), text_of(made)))
    if write:
        with open(path, "w", encoding="utf-8") as file:
            json.dump(notebook, file, indent=1, ensure_ascii=False)
            file.write("\n")
    print("%s: %d cells, %d differ; %d stored figures" % (path, count, differ, n_figures))
    sys.exit(1 if differ or (not write and not n_figures) else 0)


if __name__ == "__main__":
    main()
