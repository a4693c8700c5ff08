# SPDX-License-Identifier: MIT
"""dedup, nearest and diff give what the tool gives; translate; warnings, progress, interruption, and what is refused."""
import json
import os
import signal
import subprocess
import tempfile
import threading
import unittest

import nqm

TOOL = os.environ["NQM_TOOL"]


def write(path, **roughness):
    with open(path, "w") as file:
        json.dump({"asset": {"version": "2.0"}, "materials": [{"name": name, "pbrMetallicRoughness": {"roughnessFactor": r}}
                                                              for name, r in roughness.items()]}, file)


def tool(*arguments):
    return json.loads(subprocess.run([TOOL, *arguments, "--json"], stdout=subprocess.PIPE, check=True).stdout)["results"]


class Find(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)
        write("old.gltf", a=0.3, b=0.301, c=0.6, gone=0.9)
        write("new.gltf", a=0.3, b=0.4, renamed=0.6, new=0.1)

    def test_dedup(self):
        (score,) = nqm.dedup("old.gltf")
        (row,) = tool("dedup", "old.gltf")
        self.assertEqual((score.ref, score.test), (row["old"], row["new"]))
        self.assertAlmostEqual(score.jod, row["jod"], 6)
        self.assertEqual(score.verdict, row["verdict"])
        self.assertEqual(len(nqm.dedup(["old.gltf", "new.gltf"])), 3)
        with self.assertRaisesRegex(nqm.Error, "the JOD is 9 to 10"):
            nqm.dedup("old.gltf", jod=8)
        with self.assertRaisesRegex(nqm.Error, "no transport matrix"):
            nqm.dedup("old.gltf", model="paper")

    def test_nearest(self):
        scores = nqm.nearest("old.gltf:c", "old.gltf", n=3, index="x.index")
        self.assertEqual([s.test for s in scores], [r["test"] for r in tool("nearest", "old.gltf:c", "--among", "old.gltf", "-n", "3")])
        self.assertTrue(scores[0].identical and scores[1].jod >= scores[2].jod)
        made = os.stat("x.index").st_mtime_ns
        self.assertEqual(nqm.nearest("old.gltf:c", "old.gltf", n=3, index="x.index"), scores)
        self.assertEqual(os.stat("x.index").st_mtime_ns, made)
        with self.assertRaisesRegex(nqm.Error, "is no index"):
            nqm.nearest("old.gltf:c", "old.gltf", index="new.gltf")
        with self.assertRaisesRegex(nqm.Error, "there is no material 'x'"):
            nqm.nearest("old.gltf:x", "old.gltf")

    def test_diff(self):
        changes = nqm.diff("old.gltf", "new.gltf")
        self.assertEqual([(c.name, c.was) for c in changes],
                         [("b", "b"), ("a", "a"), ("renamed", "c"), (None, "gone"), ("new", None)])
        self.assertEqual([c.changed for c in changes], [True, False, False, True, True])
        self.assertEqual(changes[0].properties, {"roughness": (0.301, 0.4)})
        self.assertAlmostEqual(changes[0].score.jod, tool("diff", "old.gltf", "new.gltf")[0]["jod"], 6)
        self.assertEqual([c.was for c in nqm.diff("/dev/null", "new.gltf")], [None] * 4)

    def test_left_out(self):
        os.mkdir("folder")
        write("folder/a.gltf", a=0.3)
        with open("folder/b.gltf", "w") as file:
            file.write("{")
        with self.assertWarnsRegex(UserWarning, "folder/b.gltf: "):
            self.assertEqual(nqm.dedup("folder"), [])
        with self.assertRaises(nqm.Error) as caught:
            nqm.dedup("folder/b.gltf")
        self.assertEqual(caught.exception.code, 4)

    def test_stopped(self):
        write("many.gltf", **{"m%d" % i: i / 16000 for i in range(16000)})
        stages = []

        def stop(stage, done, total):
            stages.append(stage)
            if stage == "sample":
                raise KeyError(stage)

        with self.assertRaises(KeyError):
            nqm.nearest("old.gltf:a", "many.gltf", index="many.index", progress=stop)
        self.assertIn("read", stages)
        timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            nqm.nearest("old.gltf:a", "many.gltf", index="many.index")
        timer.join()
        self.assertFalse([name for name in os.listdir() if "index" in name])

    def test_translate(self):
        calls = []
        for path, word in (("a.png", "a.png"), ("a.blend", "a.blend")):  # before any work
            with self.assertRaisesRegex(nqm.Error, word):
                nqm.translate("open-pbr:base_color=.8,.3,.1", "gltf", path, progress=lambda *work: calls.append(work))
        self.assertFalse(calls)
        with self.assertRaisesRegex(nqm.Error, "no-such-model"):
            nqm.translate("open-pbr:base_color=.8,.3,.1", "no-such-model")
        t = nqm.translate("open-pbr:base_color=.8,.3,.1;fuzz_weight=.2", "usd", "a.mtlx", name="clay", n_directions=200)
        self.assertEqual((t.spec.split(":")[0], t.dropped), ("usd-preview", ("fuzz_weight",)))
        self.assertIn("clay", open("a.mtlx").read())


if __name__ == "__main__":
    unittest.main()
