"""Lyapunov exponents with their signs, and what is known of them otherwise, as rows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from linkages.reports.report import Column, Table

if TYPE_CHECKING:
    import xarray as xr

BEYOND = 3.0
"""Standard errors beyond which an exponent is said to differ from zero."""


def exponent_rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """Each exponent with its error and what can be said about its sign."""
    rows = []
    for index in data["index"].to_numpy():
        value, error = (float(data[key].sel(index=index)) for key in ("exponent", "error"))
        sign = "zero within its error"
        if abs(value) > BEYOND * error:
            sign = "positive" if value > 0 else "negative"
        rows.append({"index": int(index), "value": value, "error": error, "sign": sign})
    return rows


def certificate_rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """What is known of the exponents, and whether it holds."""
    rows = []
    for place, name in enumerate(data["invariant"].to_numpy()):
        row = {key: float(data[key][place]) for key in ("found", "expected", "tolerance")}
        holds = abs(row["found"] - row["expected"]) <= row["tolerance"]
        rows.append({"name": str(name), **row, "holds": holds})
    return rows


def certificate_tables(rows: list[dict[str, Any]]) -> list[Table]:
    """The same as a table, if anything is known."""
    columns = (
        "name: invariant",
        Column("found", "found", "1/s"),
        Column("known", "expected", "1/s"),
        Column("tolerance", "tolerance", form=".2g"),
    )
    heading = "\nCertificate of the Lyapunov exponents"
    said = [{**r, "name": r["name"] + ("" if r["holds"] else ": VIOLATED")} for r in rows]
    return [Table.of(heading, said, *columns, numbers=3)] if rows else []
