"""Measured tables: CSV with a header line, or NPZ with one array a column. Nothing in them can run code."""

from __future__ import annotations

import csv
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from hamr_description.errors import BagError


def read_columns(path: str | Path) -> dict[str, np.ndarray]:
    """Column name -> (n,) numbers; an empty cell is NaN.

    Raises:
        BagError: there is no such table, or it is none; one sentence.
    """
    path = Path(path)
    if not path.is_file():
        raise BagError(f"There is no table at {path}; give a .csv or .npz file.")
    if path.suffix == ".npz":
        return _npz(path)
    if path.suffix == ".csv":
        return _csv(path)
    raise BagError(f"{path} is neither .csv nor .npz; write the columns into one of these.")


def _csv(path: Path) -> dict[str, np.ndarray]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            header, *rows = [row for row in csv.reader(file) if row]
    except (UnicodeDecodeError, csv.Error, ValueError) as error:
        raise BagError(f"{path} cannot be read as a table ({error}); write comma-separated text with a header line.") from None
    names = [name.strip() for name in header]
    while names and not names[-1]:  # a comma at the end of each line
        names.pop()
    if not names or "" in names or len(set(names)) < len(names):
        raise BagError(f"{path} has no header line with a name of its own for each column; write one.")
    if all(_number(name) is not None for name in names):
        raise BagError(f"{path} begins with numbers; write a header line with the columns' names first.")
    columns = np.empty((len(rows), len(names)))
    for i, row in enumerate(rows):
        if len(row) < len(names) or any(cell.strip() for cell in row[len(names) :]):
            raise BagError(f"{path} has {len(row)} cells in data row {i + 1}, not {len(names)}; mend that line.")
        for j, cell in enumerate(row[: len(names)]):
            if (x := _number(cell)) is None:
                raise BagError(f"{path} has '{cell}' in data row {i + 1} of column {names[j]}; write a number, or nothing.")
            columns[i, j] = x
    return dict(zip(names, columns.T, strict=True))


def _number(cell: str) -> float | None:
    try:
        return float(cell) if cell.strip() else np.nan
    except ValueError:
        return None


def _npz(path: Path) -> dict[str, np.ndarray]:
    try:
        with np.load(path, allow_pickle=False) as file:
            columns = {name: np.asarray(file[name], float).squeeze() for name in file.files}
    except (OSError, ValueError, BadZipFile) as error:
        raise BagError(f"{path} cannot be read as a table ({error}); store plain arrays of numbers in it.") from None
    if not columns or any(x.ndim != 1 for x in columns.values()) or len({len(x) for x in columns.values()}) > 1:
        raise BagError(f"{path} needs arrays of one dimension and one length, one for each column.")
    return columns
