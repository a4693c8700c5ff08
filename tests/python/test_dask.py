# SPDX-License-Identifier: MIT
"""nqm.dask on a local cluster of two workers: the rows of one process, also when a worker is killed. Skipped without Dask's distributed."""
import importlib.util
import os
import signal
import sys
import tempfile
import time
import unittest

import numpy as np

import nqm

if importlib.util.find_spec("distributed") is None or importlib.util.find_spec("pandas") is None:
    print("skipped: there is no Dask with distributed")
    sys.exit(77)
import pandas as pd  # noqa: E402
from dask.distributed import Client, LocalCluster  # noqa: E402

MATERIALS = """{"asset": {"version": "2.0"}, "materials": [
    {"name": "a", "pbrMetallicRoughness": {"roughnessFactor": 0.3}}, {"name": "b", "pbrMetallicRoughness": {"roughnessFactor": 0.6}}]}"""


class Dask(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, local_directory=tempfile.mkdtemp())
        cls.client = Client(cls.cluster)

    @classmethod
    def tearDownClass(cls):
        cls.client.close()
        cls.cluster.close()

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def write(self, name, rows):
        path = os.path.join(self.folder, name)
        pd.DataFrame(rows).to_csv(path, index=False)
        return path

    def check(self, scores, pairs):
        """Bit for bit the rows of one process."""
        expected = nqm.batch(pairs)
        self.assertEqual(list(zip(scores["reference"], scores["test"])), pairs)
        for name in expected.dtype.names:
            np.testing.assert_array_equal(scores[name].to_numpy(), expected[name], name)

    def test_rows(self):
        """Several files, a column of the user, rows that cannot be scored, a file of two materials, and scores as files."""
        with open(self.folder + "/two.gltf", "w", encoding="utf-8") as file:
            file.write(MATERIALS)
        two = self.folder + "/two.gltf"
        tests = ["ward:nickel", "missing.binary", "", "perturb:gloss=.9;of=sgd:nickel"]
        self.write("list0.csv", {"Reference": ["sgd:nickel"] * 4, "test": tests, "id": list("wxyz")})
        self.write("list1.csv", {"Reference": ["sgd:brass"] * 2, "test": [two, "ward:brass"], "id": list("pq")})
        frame = nqm.dask.score(nqm.dask.read(self.folder + "/list*.csv"))
        self.assertEqual(frame.npartitions, 2)
        scores = frame.compute()
        self.check(scores, [("sgd:nickel", t) for t in tests] + [("sgd:brass", t) for t in (two + ":a", two + ":b", "ward:brass")])
        self.assertEqual("".join(scores["id"]), "wxyzppq")
        self.assertEqual(dict(frame.dtypes), dict(scores.dtypes))
        names = frame.to_csv(self.folder + "/scores-*.csv", index=False)
        written = pd.concat(map(pd.read_csv, names))
        np.testing.assert_array_equal(written["jod"].to_numpy(), scores["jod"].to_numpy())

    def test_killed_worker(self):
        pairs = [("ggx:kd=.2;ks=.1;alpha=%.4f;f0=.04" % (.1 + .0001 * i), "ggx:kd=.2;ks=.1;alpha=.2;f0=.04") for i in range(3000)]
        path = self.write("list.csv", {"reference": [p[0] for p in pairs], "test": [p[1] for p in pairs]})
        frame = nqm.dask.score(nqm.dask.read(path, blocksize=8000))
        self.assertGreater(frame.npartitions, 20)
        victims = self.client.run(os.getpid)
        future = self.client.compute(frame)
        while len(self.client.who_has()) < 4:  # some partitions are done, and their scores on a worker
            time.sleep(.01)
        os.kill(next(iter(victims.values())), signal.SIGKILL)
        self.check(future.result(timeout=1800), pairs)
        self.assertNotEqual(victims, self.client.run(os.getpid))

    def test_errors(self):
        for columns, message in (({"reference": ["a"]}, "no column test"), ({"reference": ["a"], "test": ["b"], "jod": ["1"]}, "column jod")):
            with self.assertRaisesRegex(ValueError, message):
                nqm.dask.score(nqm.dask.read(self.write("list.csv", columns)))

    @unittest.skipUnless(importlib.util.find_spec("pyarrow") or importlib.util.find_spec("fastparquet"), "Parquet needs pyarrow")
    def test_parquet(self):
        pairs = [("sgd:nickel", "ward:nickel"), ("sgd:brass", "ward:brass")]
        pd.DataFrame(pairs, columns=["reference", "test"]).to_parquet(self.folder + "/list.parquet")
        nqm.dask.score(nqm.dask.read(self.folder + "/list.parquet")).to_parquet(self.folder + "/scores")
        self.check(pd.read_parquet(self.folder + "/scores"), pairs)


if __name__ == "__main__":
    unittest.main()
