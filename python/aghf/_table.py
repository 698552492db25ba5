"""Tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any


class Table(dict[str, list[Any]]):
    """A table as a dict of columns, lists of the same length, for ``pandas.DataFrame`` or ``polars.DataFrame``."""

    @classmethod
    def from_rows(cls, rows: Iterable[Mapping[str, Any]]) -> Table:
        """The table of these rows, with None for missing values."""
        rows = list(rows)
        names = dict.fromkeys(name for row in rows for name in row)
        return cls({name: [row.get(name) for row in rows] for name in names})

    def rows(self) -> list[dict[str, Any]]:
        """The rows as dicts."""
        return [dict(zip(self, row, strict=True)) for row in zip(*self.values(), strict=True)]

    def to_pandas(self) -> Any:
        """The table as a ``pandas.DataFrame``, which needs pandas."""
        import pandas

        return pandas.DataFrame(dict(self))

    def to_polars(self) -> Any:
        """The table as a ``polars.DataFrame``, which needs polars."""
        import polars

        return polars.DataFrame(dict(self), strict=False)
