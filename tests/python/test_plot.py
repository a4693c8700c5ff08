# SPDX-License-Identifier: MIT
"""nqm.plot: each kind of chart has the values of the library and its labels; the command writes whole files, the same ones twice; malformed
tables are refused with the exit codes of the tool; without matplotlib one sentence says what to install. Skipped without matplotlib."""
import contextlib
import importlib.util
import io
import json
import os
import resource
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import nqm

if importlib.util.find_spec("matplotlib") is None:
    print("skipped: there is no matplotlib")
    sys.exit(77)
import matplotlib  # noqa: E402

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

import nqm.plot as plot  # noqa: E402

EVALUATION = {"dataset": {"split": "test"}, "results": [
    {"name": "rmse", "n": 60, "n_materials": 6, "spearman": -0.1, "ci95": None, "spearman_mean_by_material": None},
    {"name": "default", "n": 60, "n_materials": 6, "spearman": 0.9, "ci95": [0.8, 0.95], "spearman_mean_by_material": 0.92,
     "ci95_mean_by_material": [0.85, 0.97]}]}


def luminance(rgb):
    return rgb @ [0.2126, 0.7152, 0.0722]


def texts(figure):
    """All that a figure says."""
    return " ".join(t.get_text() for t in figure.findobj(matplotlib.text.Text))


class Plot(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(pyplot.close, "all")
        self.addCleanup(os.chdir, os.getcwd())
        self.folder = folder.name
        os.chdir(folder.name)

    def write(self, name, *lines):
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write("".join(line + "\n" for line in lines))
        return path

    def pairs(self, families=2, header="reference,jod,default,rmse,family"):
        return self.write("pairs.csv", header, *("r,%g,%g,%g,f%d" % (10 - i / 10, 10 - i / 11, (i + 1) / 90, i % families) for i in range(40)))

    def evaluation(self, **members):
        return self.write("eval%d.json" % len(os.listdir()), json.dumps({**EVALUATION, **members}))

    def log(self, name, n=20):
        return self.write(name, "epoch,train_loss,validation_loss,lr_first", *("%d,%g,%g,%g" % (i, 1 / i, 1.2 / i, 1e-4) for i in range(1, n + 1)))

    # ---- BRDFs

    def test_slice(self):
        brdf = nqm.BRDF.open("sgd:nickel")
        axes = plot.slice([brdf, "ward:nickel", "lambert:kd=0"], names=[None, "mine", None], theta_d_deg=30, phi_d_deg=60)
        self.assertEqual(axes.shape, (2, 3))
        theta, f = axes[0, 0].lines[0].get_data()
        hd = np.stack([np.radians(theta), np.full_like(theta, np.radians(30)), np.full_like(theta, np.radians(60))], axis=-1)
        shown = np.isfinite(f)
        np.testing.assert_allclose(f[shown], luminance(brdf.eval_half_diff(hd))[shown], rtol=1e-6)
        self.assertGreater(shown.sum(), 200)
        theta, f = axes[0, 1].lines[0].get_data()
        np.testing.assert_allclose(f, luminance(brdf.eval_half_diff(np.stack([0 * theta, np.radians(theta), 0 * theta + np.radians(60)], axis=-1))), rtol=1e-6)
        for ax, light in ((axes[1, 0], 15), (axes[1, 1], 45), (axes[1, 2], 70)):
            theta, f = ax.lines[1].get_data()
            wi = [-np.sin(np.radians(light)), 0, np.cos(np.radians(light))]
            wo = np.stack([np.sin(np.radians(theta)), 0 * theta, np.cos(np.radians(theta))], axis=-1)
            np.testing.assert_allclose(f, luminance(nqm.BRDF.open("ward:nickel").eval(wi, wo)), rtol=1e-6)
            self.assertEqual((ax.get_yscale(), ax.get_xlim()), ("log", (-90, 90)))
        angle, radius = axes[0, 2].lines[0].get_data()  # the lobes for light at 45 degrees, as logarithms
        theta, f = axes[1, 1].lines[0].get_data()
        np.testing.assert_allclose(np.degrees(angle), theta)
        np.testing.assert_allclose(radius, np.maximum(np.log10(f), axes[0, 2].get_ylim()[0]), atol=1e-6)
        legend = [t.get_text() for t in axes[0, 0].get_legend().get_texts()]
        self.assertEqual(legend, ["sgd:nickel", "mine", "lambert:kd=0 (0)"])
        self.assertEqual(len({line.get_linestyle() for line in axes[0, 0].lines}), 3)
        self.assertIn("1/sr", axes[0, 0].get_ylabel())

    def test_slice_of_anisotropic(self):
        brushed = "ward:kd=.1;ks=.1;ax=.1;ay=.4" if "ax" in nqm.BRDF.open("ward:nickel").info.spec else None
        brushed = brushed or "rotate:deg=0;of=open-pbr:base_metalness=1;specular_roughness=.4;specular_roughness_anisotropy=.8"
        along, across = (plot.slice([brushed], azimuth_deg=a)[1, 1].lines[0].get_ydata() for a in (0, 90))
        self.assertFalse(np.allclose(along, across))
        self.assertIn("90° from the tangent", texts(pyplot.gcf()))
        where = plot.attribution(brushed, "rotate:deg=90;of=" + brushed.replace("rotate:deg=0;of=", ""))
        self.assertIn("azimuths", texts(where.figure))

    def test_attribution(self):
        ax = plot.attribution("lambert:kd=.5", "lambert:kd=.25", names=["a", "b"])
        mean = ax.collections[0].get_array().reshape(60, 90)
        self.assertAlmostEqual(float(mean[30, 30]), np.log(.5 / np.pi + .003) - np.log(.25 / np.pi + .003), 9)
        self.assertTrue(mean.mask[59, 89])  # below the horizon
        self.assertFalse(mean.mask[0].any() and mean.mask[:, 0].any())
        self.assertEqual((ax.get_xlim(), ax.get_ylim()), ((0, 90), (0, 90)))
        self.assertIn("Where b differs from a", texts(ax.figure))
        same = plot.attribution("sgd:nickel", "sgd:nickel").collections[0]
        self.assertEqual((same.get_array().max(), same.get_clim()[1]), (0, 0.01))

    # ---- models

    def test_directions(self):
        degrees = nqm.Model.open("default").directions.degrees
        for source in ("default", nqm.Model.open("default").directions):
            axes = plot.directions(source)
            for k in range(2):
                np.testing.assert_array_equal(np.array(axes[k].lines[0].get_data()).T, degrees[:, [0, k + 1]])
        table = self.write("set.csv", "theta_h,theta_d,phi_d", "10,20,200")
        self.assertEqual(plot.directions(table)[1].lines[0].get_ydata()[0], 200)

    def test_network(self):
        model = "paper" if "paper" in nqm.models() else "default"
        info = nqm.Model.open(model).info
        said = " ".join(cell.get_text().get_text() for cell in plot.network(model).tables[0].get_celld().values())
        self.assertIn("{:,}".format(info.n_parameters), said)
        for a, b in zip(info.layer_sizes, info.layer_sizes[1:]):
            self.assertIn("{:,}".format(a * b), said)
        with self.assertRaisesRegex(nqm.Error, "transport has no network"):
            plot.network("transport")

    # ---- tables

    def test_curve(self):
        delta_e = np.arange(1, 61)
        jod = 10 / (1 + (delta_e / 25) ** 1.5) + (delta_e % 3 - 1) / 5
        path = self.write("labels.csv", "# a comment", "model,DeltaE,JOD", *("%s,%g,%g" % ("ab"[i % 2], x, y) for i, (x, y) in enumerate(zip(delta_e, jod))))
        ax = plot.curve(path)
        *groups, fitted = ax.lines
        self.assertEqual([line.get_label() for line in ax.lines], ["a", "b", "fitted curve"])
        np.testing.assert_allclose(groups[0].get_data(), (delta_e[::2], jod[::2]), rtol=1e-5)
        fit = json.loads(subprocess.check_output([os.environ["NQM_TOOL"], "regress", path, "--json"]))
        x, y = fitted.get_data()
        np.testing.assert_allclose(y, 10 * (1 - 1 / (1 + np.exp(fit["b1"] * (-x ** fit["b3"] - fit["b2"])))), atol=1e-5)
        self.assertIn("RMSE %.3f JOD" % fit["rmse"], texts(ax.figure))
        with self.assertRaisesRegex(nqm.Error, "3 rows do not determine"):
            plot.curve(self.write("few.csv", "DeltaE,JOD", "1,9", "2,8", "3,7"))

    def test_scatter(self):
        ax = plot.scatter(self.pairs())
        self.assertEqual([line.get_label() for line in ax.lines], ["f0", "f1", "equal"])
        np.testing.assert_allclose(ax.lines[1].get_data(), ([10 - i / 10 for i in range(1, 40, 2)], [float("%g" % (10 - i / 11)) for i in range(1, 40, 2)]))
        self.assertIn("40 pairs; Spearman correlation 1.000", texts(ax.figure))
        rmse = plot.scatter(self.pairs(), "rmse")
        self.assertEqual((rmse.get_yscale(), len(rmse.lines)), ("log", 2))  # no diagonal
        self.assertIn("Spearman correlation 1.000 (signed: higher is better)", texts(rmse.figure))
        many = plot.scatter(self.pairs(families=12))
        self.assertEqual(many.lines[7].get_label(), "other")
        self.assertEqual(sum(len(line.get_xdata()) for line in many.lines[:8]), 40)
        people = self.write("people.csv", "delta_e,jod,default", ",3,9", ",4,9.5")
        self.assertIn("score of people", texts(plot.scatter(people).figure))
        ties = self.write("ties.csv", "jod,default", "9,1", "8,1", "8,2", "7,3")
        self.assertIn("Spearman correlation -0.833", texts(plot.scatter(ties).figure))

    def test_bars(self):
        ax = plot.bars(self.evaluation())
        self.assertEqual([t.get_text() for t in ax.get_yticklabels()], ["default", "rmse"])  # best first
        widths = [bar.get_width() for bar in ax.patches]
        np.testing.assert_array_equal(widths, [.9, -.1, .92, np.nan])
        whiskers = [sorted(bar.get_segments()[0][:, 0]) for bar in ax.collections if bar.get_segments()]
        np.testing.assert_allclose(whiskers, [[.8, .95], [.85, .97]])
        said = texts(ax.figure)
        for words in ("60 pairs", "split: test", "whiskers", "0.920", "over all pairs", "mean over materials"):
            self.assertIn(words, said)
        one = texts(plot.bars(self.evaluation(results=[{"name": "a", "spearman": .9}])).figure)
        self.assertNotIn("whiskers", one)  # only what is drawn is named
        self.assertNotIn("mean over materials", one)
        scores = texts(plot.bars(self.evaluation(human={"kind": "score"})).figure)
        self.assertIn("scores of people", scores)
        self.assertNotIn("split", scores)
        choice = self.evaluation(human={"kind": "choice", "choices": 3, "triplets": 2, "materials": 1, "ceiling": .9}, results=[
            {"name": "a", "majority": 1, "agreement": .8, "ci95": [.7, .9]}])
        self.assertIn("3 choices between 2 pairs of tests", texts(plot.bars(choice).figure))

    def test_loss(self):
        axes = plot.loss(self.log("a.csv"))
        np.testing.assert_allclose(axes[0].lines[1].get_data(), [range(1, 21), [1.2 / i for i in range(1, 21)]], rtol=1e-5)
        np.testing.assert_allclose(axes[1].lines[0].get_ydata(), 1e-4)
        self.assertEqual([line.get_label() for line in axes[0].lines], ["training", "validation"])
        both = plot.loss([self.log("a.csv"), self.log("b.csv", 1)])
        self.assertEqual([line.get_label() for line in both[0].lines][2:], ["b.csv, training", "b.csv, validation"])
        self.assertEqual((both[0].lines[0].get_marker(), both[0].lines[2].get_marker()), ("", "o"))  # one epoch is no line

    def test_sizes(self):
        ax = plot.sizes(self.write("sizes.csv", "map,kind,size,jod", "roughness,a,4,9.8", "roughness,a,.5,9.2", "roughness,b,2,9.9", "normal,a,1,9"))
        np.testing.assert_array_equal(ax.lines[0].get_data(), [[.5, 2, 4], [9.2, 9.9, 9.9]])
        self.assertEqual(ax.get_legend_handles_labels()[1], ["roughness", "normal"])

    # ---- refusals: what, in which file, with the exit code of the tool

    def test_refusals(self):
        log, pairs = self.log("log.csv"), self.pairs()
        half = self.write("half.csv", "epoch,train_loss,validation_loss,lr_first", "1,1,1,1e-4", "2,half,1,1e-4")
        for kind, path, code, message in (
                (plot.curve, log, 4, "log.csv: the header has no column DeltaE"),
                (plot.curve, os.path.join(self.folder, "no.csv"), 3, "no.csv: No such file"),
                (plot.loss, pairs, 4, "no column train_loss"),
                (plot.loss, half, 4, "half.csv: line 3: column 'train_loss' needs a finite number, not 'half'"),
                (plot.loss, self.write("inf.csv", "epoch,train_loss,validation_loss,lr_first", "1,1e999,1,1"), 4, "line 2.*'1e999'"),
                (plot.loss, self.write("none.csv", "epoch,train_loss,validation_loss,lr_first"), 5, "none.csv: there are no rows"),
                (plot.loss, self.write("empty.csv", "# nothing"), 4, "the file is empty"),
                (plot.loss, self.write("torn.csv", "epoch,train_loss", "1"), 4, "line 2: 1 fields where the header has 2"),
                (plot.loss, self.write("quote.csv", "epoch,train_loss", '"1,2'), 4, "quote.csv: line 2: "),
                (plot.scatter, log, 4, "scatter needs the column jod.*eval --pairs"),
                (plot.scatter, self.pairs(header="reference,jod,jod_low,rmse,family"), 5, "has the scores of nqm batch"),
                (plot.bars, pairs, 4, "bars draws the document of `nqm eval --json`"),
                (plot.bars, self.write("list.json", "[1]"), 4, "there is no list \"results\""),
                (plot.bars, self.evaluation(results=[]), 5, "no results to draw"),
                (plot.bars, self.evaluation(results=[{"name": "a", "spearman": None}]), 4, r"result 0 \(a\) has no Spearman"),
                (plot.bars, self.evaluation(results=[{"name": "a", "spearman": "x"}]), 4, "is no number"),
                (plot.bars, self.evaluation(results=[{"name": "a", "spearman": 1, "ci95": [1]}]), 4, "is no number"),
                (plot.network, "nobody", 6, "there is no model 'nobody'"),
                (plot.slice, ["lambert:kd=0"], 8, "no BRDF has a value above 0")):
            with self.subTest(message), self.assertRaisesRegex(nqm.Error, message) as caught:
                kind(path)
            self.assertEqual(caught.exception.code, code, message)
        for wrong in ([], ["sgd:nickel"] * 9):
            with self.assertRaisesRegex(ValueError, "1 to 8 BRDFs"):
                plot.slice(wrong)

    # ---- the command

    def run_plot(self, *arguments, **options):
        """In a process of its own: (exit code, stdout, stderr)."""
        found = subprocess.run([sys.executable, "-m", "nqm.plot", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               universal_newlines=True, **options)
        return found.returncode, found.stdout, found.stderr

    def call(self, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = plot.main(arguments)
            except SystemExit as stop:
                code = stop.code
        return code, out.getvalue(), err.getvalue()

    def test_files(self):
        starts = {"svg": b"<?xml", "pdf": b"%PDF-", "PNG": b"\x89PNG"}
        for ending, start in starts.items():
            name, made = os.path.join(self.folder, "x." + ending), []
            for _ in range(2):
                self.assertEqual(plot.main(["slice", "sgd:nickel", "My fit=ward:nickel", "-o", name]), 0)
                with open(name, "rb") as file:
                    made.append(file.read())
            self.assertEqual(made[0], made[1], "not the same bytes twice")
            self.assertTrue(made[0].startswith(start))
            self.assertNotIn(b"CreationDate", made[0])
        self.assertEqual(sorted(os.listdir(self.folder)), ["x.PNG", "x.pdf", "x.svg"])

    def test_options(self):
        out = os.path.join(self.folder, "x.png")
        self.assertEqual(plot.main(["sizes", self.write("s.csv", "size,jod", "1,9"), "-o", out, "--size", "300", "250", "--scale", "1", "--title", ""]), 0)
        self.assertEqual(pyplot.imread(out).shape[:2], (250, 300))
        self.assertEqual(pyplot.gcf()._suptitle.get_text(), "")
        self.assertEqual(plot.main(["scatter", self.pairs(), "--predictor", "rmse", "-o", out]), 0)
        self.assertIn("rmse against", texts(pyplot.gcf()))
        self.assertEqual(plot.main(["slice", "sgd:nickel", "--theta-d", "40", "-o", out]), 0)
        self.assertIn("= 40°", texts(pyplot.gcf()))
        with open(self.evaluation(), encoding="utf-8") as file:
            self.assertEqual(self.run_plot("bars", "-", "-o", "piped.svg", stdin=file), (0, "", ""))
        self.assertIn("piped.svg", os.listdir(self.folder))

    def test_command_refuses(self):
        log = self.log("log.csv")
        for code, message, arguments in ((2, "FILE.svg", ["loss", log, "-o", "x.gif"]), (2, "--scale", ["loss", log, "-o", "x.png", "--scale", "9"]),
                                         (2, "--size", ["loss", log, "-o", "x.png", "--size", "10", "10"]), (3, "no/x.svg", ["loss", log, "-o", "no/x.svg"]),
                                         (2, "invalid choice: 'pie'", ["pie", log, "-o", "x.svg"]), (2, "required", ["loss", log]),
                                         (2, "nonsense", ["slice", "sgd:nonsense", "-o", "x.svg"]), (4, "DeltaE", ["curve", log, "-o", "x.svg"])):
            found = self.call(*arguments)
            self.assertEqual(found[:2], (code, ""), arguments)
            self.assertIn(message, found[2])
        self.assertEqual(os.listdir(), ["log.csv"])
        full = self.run_plot("loss", log, "-o", "x.png", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000)))  # a full disk
        self.assertEqual((full[:2], os.listdir()), ((3, ""), ["log.csv"]))
        self.assertIn("python3 -m nqm.plot: x.png: cannot write", full[2])

    def test_help(self):
        said = self.call("--help")[1]
        for kind in plot._KINDS:
            self.assertIn("python3 -m nqm.plot %s " % kind, said)
            self.assertIn("example: python3 -m nqm.plot %s " % kind, self.call(kind, "--help")[1])

    def test_without_matplotlib(self):
        self.write("matplotlib.py", "raise ImportError")
        found = self.run_plot("sizes", self.write("s.csv", "size,jod", "1,9"), "-o", "x.svg",
                              env={**os.environ, "PYTHONPATH": self.folder + ":" + os.environ["PYTHONPATH"]})
        self.assertEqual(found, (2, "", "python3 -m nqm.plot: nqm.plot needs matplotlib: install the package python3-matplotlib "
                                        "(Debian), or matplotlib by pip\n"))


if __name__ == "__main__":
    unittest.main()
