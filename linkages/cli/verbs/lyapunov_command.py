"""``lyapunov``: exponents with errors, their sum, how they settle."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape

from linkages.cli.requests import File, Request
from linkages.cli.swept import contact_content, print_remarks
from linkages.cli.terminal import number, table
from linkages.reading.wording import to_error

if TYPE_CHECKING:
    import xarray as xr

BEYOND = 3.0
"""Standard errors beyond which an exponent is said to differ from zero."""


def run(request: Request) -> int:
    """Compute exponents; returns the exit code."""
    from linkages.chaos.lyapunov import lyapunov

    with request.computing("exponents of") as watch:
        data = lyapunov(request.mechanism, watch=watch, **request.given)
    columns = {"time (s)": data["time"].to_numpy()} | {
        f"exponent {index} (1/s)": data["history"].sel(index=index).to_numpy()
        for index in data["index"].to_numpy()
    }

    def made() -> Iterator[File]:
        yield "lyapunov", data
        yield "lyapunov", columns
        if request.figures:
            from linkages.plots.chaos.chaos_figures import exponent_figure

            yield "lyapunov", exponent_figure(data)

    files = request.write(made())
    rows, known, said = exponent_rows(data), certificate_rows(data), data.attrs
    end = float(data["time"][-1])

    def show(screen: Console) -> None:
        title = f"[bold]{escape(said['name'])}[/bold]"
        counted = ""
        if request.given.get("interval") is not None:
            counted = f" over {said['periods']} intervals of {number(said['period'])} s,"
        screen.print(f"{title}: Lyapunov exponents{counted} up to t = {number(end)} s")
        cells = [[r["index"], r["sign"], *to_error(r["value"], r["error"])] for r in rows]
        heads = ["exponent", "sign", "value (1/s)", "standard error"]
        if rows:
            screen.print(table("Lyapunov exponents", heads, cells, numbers=2))
            total, by = to_error(said["sum"], said["sum_error"])
            screen.print(f"sum of these: {total} ± {by} 1/s")
        if lost := int(said["lost"]):
            screen.print(
                f"{lost}{' more' if rows else ''} {'is' if lost == 1 else 'are'} −∞: where "
                "rigid contacts close or friction sticks, motions merge with their neighbours"
            )
        if "least_touch" in said:
            screen.print(
                f"slowest touch: {number(said['least_touch'])} in {escape(said['least_touch_of'])} "
                f"at t = {number(said['least_touch_time'])} s; exponents converge slowly where "
                "that tends to zero"
            )
        if known:
            heading, heads, cells = certificate_table(known)
            screen.print(table(f"\n{heading}", heads, cells, numbers=len(heads) - 1))
        print_remarks(data, [said["warning"]] if said["warning"] else [], screen)

    content = {
        "mechanism": said["name"],
        "end": end,
        "periods": int(said["periods"]),
        "period": float(said["period"]),
        "exponents": rows,
        "sum": {"value": said["sum"], "error": said["sum_error"]},
        "lost": int(said["lost"]),
        "least_touch": said.get("least_touch"),
        "certificate": known,
        "contact": contact_content(data),
        "settled": bool(said["settled"]),
        "warning": said["warning"] or None,
    }
    return request.report(content, files, show)


def exponent_rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """Each exponent with its error and what can be said about its sign."""
    rows = []
    for index in data["index"].to_numpy():
        value = float(data["exponent"].sel(index=index))
        error = float(data["error"].sel(index=index))
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


def certificate_table(rows: list[dict[str, Any]]) -> tuple[str, list[str], list[list[str]]]:
    """Heading, heads and cells of the same."""
    cells = [
        [
            row["name"] + ("" if row["holds"] else ": VIOLATED"),
            number(row["found"]),
            number(row["expected"]),
            f"{row['tolerance']:.2g}",
        ]
        for row in rows
    ]
    heads = ["invariant", "found (1/s)", "known (1/s)", "tolerance"]
    return "Certificate of the Lyapunov exponents", heads, cells
