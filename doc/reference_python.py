#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Print doc/reference-python.md from the docstrings of python/nqm. ./dev pages writes it, and tests/python/test_pages.py checks that it is
up to date. The sources are parsed, not imported: neither NumPy nor torch is needed."""
import ast
import inspect
import os
import re

PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "python", "nqm")
GROUPS = (("Scores", ("score", "score_many", "batch", "expand_pairs", "score_samples", "score_grad", "Score", "Parts", "Scorer", "preference")),
          ("BRDFs", ("BRDF", "BRDFInfo", "CheckReport", "compare", "Difference", "presets", "materials", "MaterialInfo", "table_nodes",
                     "half_diff_to_directions", "directions_to_half_diff", "Directions")),
          ("Metrics and models", ("Metric", "metrics", "Model", "ModelInfo", "models")),
          ("Textures", ("score_maps", "MapScore", "Blame", "Material", "MapsInfo")),
          ("Libraries of materials", ("dedup", "nearest", "diff", "Change")),
          ("Fits", ("fit", "Fit", "fit_models", "translate", "Translation")),
          ("Tests of shaders", ("conform", "Conformance", "Mistake")),
          ("Rendering", ("label", "Label", "render", "srgb", "Scene", "Rays")),
          ("Datasets", ("Dataset",)),
          ("Errors and the library", ("Error", "Status", "build_info", "files_within")))


def parse(name):
    with open(os.path.join(PACKAGE, name), encoding="utf-8") as file:
        return ast.parse(file.read())


def is_marked(node, name):
    return any(getattr(d, "id", getattr(d, "attr", "")) == name for d in node.decorator_list)


def signature(function, drop_self):
    """The arguments without their types."""
    arguments = function.args
    for a in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs, arguments.vararg, arguments.kwarg):
        if a:
            a.annotation = None
    text = ast.unparse(arguments)
    return re.sub(r"^(self|cls|ctx)(, |$)", "", text) if drop_self else text


def markdown(doc):
    """A docstring as Markdown: its sections become lists, its examples code. Left out: what is the same everywhere (main() says it),
    that is `progress`, the errors raised, and arguments that are those of another function."""
    doc = re.sub(r"(?ms)^    (?:progress: |\w+: as for )(?:(?!^    \w+: |^$).)*", "", inspect.cleandoc(doc) + "\n")
    doc = re.sub(r"(?m)^Args:\n(?=\n|\Z)|^Raises:\n(?:    .*\n)*", "", doc)
    out, section = [], None
    for line in doc.strip().split("\n"):
        head = re.match(r"(Args|Returns|Raises|Attributes):$", line)
        if head:
            section = head.group(1)
            out += ["", {"Args": "Arguments:", "Attributes": "Members:"}.get(section, section + ":"), ""]
        elif section and re.match(r"    \w+: ", line) and section != "Returns":
            name, _, text = line.strip().partition(": ")
            out.append("- `%s`: %s" % (name, text))
        elif section and line.strip():
            out.append(("  " if out[-1].startswith(("- ", "  ")) else "") + line.strip())
        else:
            out.append(line)
    text = re.sub(r"\n{3,}", "\n\n", "\n".join(out))
    return re.sub(r"(?m)^>>>(?s:.*?)(?=\n\n|\Z)", lambda m: "```python\n%s\n```" % m.group(), text)


def is_shortcut(node):
    """A method that a function of the package describes, or a class that functions of the package call."""
    return re.search(r"; see `\w+`\.$|^`\w+\.apply\(", ast.get_docstring(node))


def entry(level, name, node):
    """Lines of a function or class."""
    doc = ast.get_docstring(node)
    if isinstance(node, ast.FunctionDef):
        yield "%s `%s(%s)`\n\n%s\n" % (level, name, signature(node, level == "####"), markdown(doc))
        return
    init = next((f for f in node.body if isinstance(f, ast.FunctionDef) and f.name == "__init__"), None)
    closed = init is None or isinstance(init.body[0], ast.Raise)  # "use ....open()"
    yield "%s `%s%s`\n\n%s\n" % (level, name, "" if closed else "(%s)" % signature(init, True), markdown(doc))
    values = [n for n in node.body if isinstance(n, ast.Assign)]
    if any(getattr(b, "attr", "") == "IntEnum" for b in node.bases):
        yield "| name | value |\n|---|---|"
        yield "".join("| `%s` | %s |\n" % (n.targets[0].id, ast.unparse(n.value)) for n in values)
    for f in node.body:
        if isinstance(f, ast.FunctionDef) and ast.get_docstring(f) and not is_shortcut(f) and (not f.name.startswith("_") or f.name in ("__call__", "__len__")):
            short = name.partition(".")[2] if "." in name else name
            if is_marked(f, "property"):
                yield "#### `%s.%s`\n\n%s\n" % (short, f.name, markdown(ast.get_docstring(f)))
            elif f.name == "__len__":
                yield "#### `len(%s)`\n\n%s\n" % (short.lower(), markdown(ast.get_docstring(f)))
            else:
                yield from entry("####", short if f.name == "__call__" else "%s.%s" % (short, f.name), f)


def main():
    found = {}
    for name in sorted(os.listdir(PACKAGE)):
        if name.endswith(".py") and name not in ("torch.py", "_torch_metric.py", "dask.py", "plot.py", "__main__.py"):
            for node in parse(name).body:
                if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not is_marked(node, "overload"):
                    found[node.name] = node
    public = ast.literal_eval(next(n.value for n in parse("__init__.py").body if isinstance(n, ast.Assign) and
                                   n.targets[0].id == "__all__"))
    if sorted(public) != sorted(name for _, names in GROUPS for name in names):
        raise SystemExit("reference_python.py: GROUPS and nqm.__all__ differ: %s" %
                         (set(public) ^ {name for _, names in GROUPS for name in names}))
    print("# Reference of the Python package\n\nWhat does each function take and return? This page is made from the docstrings "
          "(`./dev pages`), which `help()` shows too.\n[python.md](python.md) is the introduction. Angles are radians, f_r is in 1/sr "
          "without the cosine, RGB is linear with BT.709 primaries.\n\n"
          "An argument without a description is that of `score`, `score_samples`, `Scorer` or `Scene`. `progress` is called with the stage, the\n"
          "work done and the total; True shows a line on standard error; an exception ends the call. Errors are `nqm.Error`.\n")
    for title, names in GROUPS:
        print("## %s\n" % title)
        for name in names:
            print("\n".join(entry("###", "nqm." + name, found[name])))
    for title, name, files in (("PyTorch", "torch", ("torch.py", "_torch_metric.py")), ("Dask", "dask", ("dask.py",)), ("Charts", "plot", ("plot.py",))):
        trees = [parse(file) for file in files]
        print("## %s\n\n%s\n" % (title, markdown(ast.get_docstring(trees[0]))))
        for node in (n for tree in trees for n in tree.body):
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.name.startswith("_") and not is_shortcut(node):
                print("\n".join(entry("###", "nqm.%s.%s" % (name, node.name), node)))


main()
