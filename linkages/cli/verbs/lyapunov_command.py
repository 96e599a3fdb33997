"""``lyapunov``: exponents with errors, their sum, how they settle."""

from __future__ import annotations

from collections.abc import Iterator

from linkages.cli.requests import File, Request
from linkages.cli.swept import contact_content, remarks
from linkages.reading.wording import to_error
from linkages.reports.report import Part, Report, Table, number
from linkages.reports.verdict_report import certificate_rows, certificate_tables, exponent_rows


def run(request: Request) -> int:
    """Compute exponents; returns the exit code."""
    from linkages.chaos.lyapunov import lyapunov

    with request.computing("exponents of") as watch:
        data = lyapunov(request.mechanism, watch=watch, **request.given)
    columns = {"time (s)": data["time"].to_numpy()} | {
        f"exponent {index} (1/s)": data["history"].sel(index=index).to_numpy()
        for index in data["index"].to_numpy()
    }

    def figures() -> Iterator[File]:
        from linkages.plots.chaos.chaos_figures import exponent_figure

        yield "lyapunov", exponent_figure(data)

    rows, known, said = exponent_rows(data), certificate_rows(data), data.attrs
    end, lost = float(data["time"][-1]), int(said["lost"])
    over = ""
    if request.given.get("interval") is not None:
        over = f" over {said['periods']} intervals of {number(said['period'])} s,"
    parts: list[Part] = []
    if rows:
        heads = ["exponent", "sign", "value (1/s)", "standard error"]
        cells = [[r["index"], r["sign"], *to_error(r["value"], r["error"])] for r in rows]
        total, by = to_error(said["sum"], said["sum_error"])
        parts = [Table("Lyapunov exponents", heads, cells, 2), f"sum of these: {total} ± {by} 1/s"]
    if lost:
        parts.append(
            f"{lost}{' more' if rows else ''} {'is' if lost == 1 else 'are'} −∞: where "
            "rigid contacts close or friction sticks, motions merge with their neighbours"
        )
    if "least_touch" in said:
        parts.append(
            f"slowest touch: {number(said['least_touch'])} in {said['least_touch_of']} at t = "
            f"{number(said['least_touch_time'])} s; exponents converge slowly where that tends to "
            "zero"
        )
    report = Report(
        name=said["name"],
        summary=f"Lyapunov exponents{over} up to t = {number(end)} s",
        parts=[
            *parts,
            *certificate_tables(known),
            *remarks(data, [said["warning"]] if said["warning"] else []),
        ],
        data={
            "mechanism": said["name"],
            "end": end,
            "periods": int(said["periods"]),
            "period": float(said["period"]),
            "exponents": rows,
            "sum": {"value": said["sum"], "error": said["sum_error"]},
            "lost": lost,
            "least_touch": said.get("least_touch"),
            "certificate": known,
            "contact": contact_content(data),
            "settled": bool(said["settled"]),
            "warning": said["warning"] or None,
        },
    )
    return request.publish(report, [("lyapunov", data), ("lyapunov", columns)], figures)
