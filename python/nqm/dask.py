# SPDX-License-Identifier: MIT
"""Scores of partitioned lists of pairs by Dask, on as many machines as its cluster has.

Dask schedules the partitions, tries those of lost workers again, and shows the work in its dashboard. Rows are those of `nqm.batch`. Each
worker needs this package, and the files of the list under the same paths: absolute, or relative to the folder where the worker was started.
"""
from __future__ import annotations

import os
from typing import Any, Dict

import dask.dataframe as dd
import pandas as pd

from ._call import PathLike
from ._metric import batch, expand_pairs

__all__ = ["read", "score"]


def read(path: PathLike, *, blocksize: Any = "1MB", **options: Any) -> dd.DataFrame:
    """A list of pairs in partitions: CSV files, or Parquet files (`*.parquet` or a folder; needs pyarrow), `*` in the name for several.

    Args:
        path: of the files, which all workers see
        blocksize: bytes of a partition of a CSV: at most what a worker may compute again. 1 MB has about 10,000 pairs (two seconds)
        options: as for `dask.dataframe.read_csv` or `read_parquet`, where row groups are partitions
    """
    text = os.fspath(path)
    if text.endswith(".parquet") or os.path.isdir(text):
        return dd.read_parquet(text, **options)
    return dd.read_csv(text, dtype=str, keep_default_na=False, skipinitialspace=True, blocksize=blocksize, **options)


def score(pairs: dd.DataFrame, *, model: PathLike = "default", metrics: bool = False, **options: Any) -> dd.DataFrame:
    """Score the pairs of a list. Nothing is computed before `.compute()`, `.to_parquet(...)` or `.to_csv("scores-*.csv")`: write one file for
    each partition, which a second try replaces.

    >>> from dask.distributed import Client
    >>> client = Client("tcp://scheduler:8786")
    >>> nqm.dask.score(nqm.dask.read("pairs/*.csv")).to_csv("scores/*.csv", index=False)

    Args:
        pairs: a frame with the columns `reference` and `test`, as from `read`; other columns are copied
        model: name of a built-in model, or a file that all workers see
        metrics, options: as for `nqm.batch`

    Returns:
        a frame of the same partitions: their columns and those of `nqm.batch`. A file of several materials has a row for each
    """
    names = {name.lower(): name for name in pairs.columns}
    missing = [name for name in ("reference", "test") if name not in names]
    if missing:
        raise ValueError("the list has no column %s" % " and ".join(missing))
    pairs = pairs.rename(columns={names["reference"]: "reference", names["test"]: "test"})
    options.update(model=model if isinstance(model, str) else os.fspath(model), metrics=metrics)
    columns = batch([], **options).dtype.names
    taken = sorted(set(columns) & set(pairs.columns))
    if taken:
        raise ValueError("the list has the column %s, which the scores have too: rename it" % taken[0])
    return pairs.map_partitions(_score, options, meta=_score(pairs._meta, options))


def _score(frame: pd.DataFrame, options: Dict[str, Any]) -> pd.DataFrame:
    rows = [(i, pair) for i, row in enumerate(zip(frame["reference"], frame["test"])) for pair in expand_pairs([row])]
    table = batch([pair for _, pair in rows], **options)
    scored = frame.iloc[[i for i, _ in rows]].reset_index(drop=True)
    scored["reference"] = pd.Series([str(pair[0]) for _, pair in rows], dtype=frame["reference"].dtype)
    scored["test"] = pd.Series([str(pair[1]) for _, pair in rows], dtype=frame["test"].dtype)
    return scored.assign(**{name: table[name] for name in table.dtype.names})
