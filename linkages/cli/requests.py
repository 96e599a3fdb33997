"""What commands are asked for: mechanisms, files, options, ranges, initial states."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from linkages.cli.published import EndedError, Published, published
from linkages.cli.terminal import (
    changes_in_words,
    console,
    counter,
    print_changes,
    print_json,
    print_report,
    progress,
)
from linkages.components.mechanisms.definition import load
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, InputError, Interrupted, Problem
from linkages.options.option import OptionError, asked_in, given_options, options_in
from linkages.options.run import RunOptions, SimulationOptions
from linkages.reading.document import shipped
from linkages.reading.output_files import replaced
from linkages.reading.overrides import NEXT, parse_assignment
from linkages.reading.wording import shown
from linkages.reports.report import Notes, Report
from linkages.solution.run_options import options_of
from linkages.stamps import FORMATS, stamped

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from linkages.solution.solution import Solution
    from linkages.sweeps.axes import Axis

Given = TypeVar("Given")
Found = TypeVar("Found")


def mechanism_from(
    file: str,
    assignments: Sequence[str],
    tables_from: Path | None = None,
    label: str | None = None,
) -> Mechanism:
    """Read a definition file with the values of ``--set`` put in.

    With a label it is a file of branches: the mechanism is that of the point with this label.
    """
    values = overrides("--set", assignments)
    if label is None:
        return load(file, set=values, tables_from=tables_from)
    from linkages.opened import open as opened
    from linkages.orbits.starting_states import at_label

    if Path(file).suffix.lower() != ".nc":
        message = f"expected a file of branches, such as follow.nc; found {file}"
        raise InputError("--at", [Problem(message=message)])
    try:
        result = at_label(load(file, tables_from=tables_from), opened(file).data, label)
    except ValueError as error:
        raise InputError("--at", [Problem(message=f"{file}: {error}")]) from None
    return result.with_values(values) if values else result


INTEGRATION = ("method", "rtol", "atol", "step", "change_points")
"""Options that files of results say for every command."""


OF_START = ("state", "skip", "periods", "locus", "other")
"""Options of searches for orbits that say where they begin."""


def results_in(file: str, wanted: str = "simulate") -> str:
    """Of a folder of results, the file to compute from: the one that is wanted, or the only one.

    A store of a sweep is what it is: `sweep --status` describes it.
    """
    folder = Path(file)
    if not folder.is_dir() or file in shipped() or (folder / "manifest.json").is_file():
        return file
    result = sorted(folder.glob("*.nc"))
    chosen = [path for path in result if path.stem == wanted] or result
    return str(chosen[0]) if len(chosen) == 1 else file


def arguments_in(file: str, verb: str, assigned: Collection[str]) -> dict[str, Any]:
    """What a file of results was computed with, as far as a command takes it over.

    A definition file says nothing. What the assigned paths of ``--set`` say takes its place.
    """
    path = Path(file)
    origin = stamped(path) if path.suffix.lower() in FORMATS and path.is_file() else None
    if origin is None:
        return {}
    from linkages.analyses import options_of_analysis

    result = asked_in(origin.arguments, file, options_of_analysis(verb))
    if isinstance(outputs := result.get("outputs"), list):  # those that were computed
        result["outputs"] = None if origin.command else ",".join(outputs)
    same = origin.verb in (verb, None)
    return {
        name: value
        for name, value in result.items()
        if (same or name in INTEGRATION) and not {"simulate", f"simulate.{name}"} & set(assigned)
    }


def overrides(option: str, assignments: Sequence[str]) -> dict[str, object]:
    """Path → value of assignments that an option has."""
    return dict(each_read(option, assignments, parse_assignment))


def each_read(option: str, values: Sequence[Given], read: Callable[[Given], Found]) -> list[Found]:
    """What the values of an option are read as; an InputError lists all that cannot be read."""
    result: list[Found] = []
    problems: list[Problem] = []
    for value in values:
        try:
            result.append(read(value))
        except InputError as error:
            problems += error.problems
        except ValueError as error:
            problems.append(Problem(message=str(error)))
    if problems:
        raise InputError(option, problems)
    return result


def require_folder(folder: Path) -> None:
    """Refuse a folder that cannot be made or written to, before results are computed."""
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not existing.is_dir():
        message = f"expected a folder for results, found a file: {existing}"
    elif not os.access(existing, os.W_OK | os.X_OK):
        message = f"expected a folder for results; {existing} cannot be written to"
    else:
        return
    raise InputError(str(folder), [Problem(message=message)])


Written: TypeAlias = "str | xr.Dataset | Mapping[str, Any] | Figure | Callable[[Path], None] | None"
"""What a file holds: a text, a dataset, columns of a table, or a figure, if there is one; or what
writes a file of another kind."""

File: TypeAlias = tuple[str, Written]
"""Its name, with an ending if it is a text or writes itself, and what it holds."""


@dataclass(frozen=True, kw_only=True)
class Request:
    """What a command is asked for.

    `kind` is the class of the options of the computation, and `given` those that are given: keyword
    arguments of the public function that answers the command. `own` is what else is given, with the
    types of these `flags`. `at` is the label of a point, where the file is one of branches. `notes`
    say what became of files of other runs.
    """

    verb: str
    file: str
    assignments: Sequence[str] = ()
    tables_from: Path | None = None
    at: str | None = None
    out: Path | None = None
    json: bool = False
    figures: bool = True
    format: str = "png"
    kind: type[RunOptions] | None = None
    given: Mapping[str, Any] = field(default_factory=dict)
    own: Mapping[str, Any] = field(default_factory=dict)
    flags: Mapping[str, Any] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def again(self) -> Request:
        """The same with what a file of results was computed with, unless something else is said.

        A folder of results stands for the file in it, and is where those of this command go. The
        options of the command that wrote it are taken over, and by all others those that say
        how motions are integrated.
        """
        file = results_in(self.file, "simulate" if self.at is None else "follow")
        out = self.out
        if out is None and file != self.file:  # of a labelled point, beside those of the branches
            out = Path(self.file) / self.at if self.at is not None else Path(self.file)
        assigned = [text.partition("=")[0] for text in self.assignments]
        said = arguments_in(file, self.verb, assigned)
        if self.at is not None:  # the point says where to begin
            said = {name: value for name, value in said.items() if name not in OF_START}
        known = {option.name for option in options_in(self.kind)} if self.kind else set()
        given = {name: value for name, value in said.items() if name in known}
        own = {n: said[n] for n, value in self.own.items() if value is None and n in said}
        try:  # as strictly as what is typed
            if self.kind is not None:
                given_options(self.kind, given, SimulationOptions())
            own = {name: _read_flag(name, self.flags[name], value) for name, value in own.items()}
        except (TypeError, ValueError) as error:
            problem = Problem(path="origin.arguments", message=str(error))
            raise InputError(file, [problem]) from None
        given |= self.given
        return replace(self, file=file, out=out, given=given, own={**self.own, **own})

    @property
    def folder(self) -> Path:
        """Where results go."""
        at = "" if self.at is None else f"-{self.at}"
        return Path("results") / f"{Path(self.file).stem}{at}" if self.out is None else self.out

    @cached_property
    def mechanism(self) -> Mechanism:
        """The mechanism with all values put in; its folder for results can be written."""
        result = mechanism_from(self.file, self.assignments, self.tables_from, self.at)
        require_folder(self.folder)
        return result

    @property
    def differences(self) -> str:
        """In what the mechanism differs from its file, in words; empty if in nothing."""
        return changes_in_words(self.mechanism.changes)

    @property
    def asked(self) -> dict[str, Any]:
        """All options of the computation: those that are given, and those of the file."""
        return (
            {} if self.kind is None else asdict(options_of(self.kind, self.mechanism, self.given))
        )

    @contextmanager
    def computing(
        self, label: str, what: str = "of simulated time", *, counted: bool = False
    ) -> Iterator[Callable[..., None]]:
        """Show the progress of a computation; turn what it raises into what the program says.

        Where nobody knows how much there is to do, it is `counted`, see `counter`. Arguments that
        make no sense are a ValueError of an analysis: that is wrong input. What an analysis has
        when it must end early is written.
        """
        from linkages.errors import UnfinishedError

        title = f"{label} {self.mechanism.name}"
        try:
            shown = (
                counter(title, not self.json) if counted else progress(title, not self.json, what)
            )
            with shown as watch:
                yield watch
        except OptionError as error:
            flag = f"--{error.name.replace('_', '-')}"
            raise InputError(flag, [Problem(message=str(error))]) from None
        except ValueError as error:
            raise InputError(self.file, [Problem(message=str(error))]) from None
        except UnfinishedError as error:
            message = f"stopped {error}{self._keep(error.kept, interrupted=False)}"
            raise ComputationError(message, time=error.time) from None
        except Interrupted as error:
            raise EndedError(f"stopped {error}{self._keep(error.kept, interrupted=True)}") from None

    def _keep(self, kept: Mapping[str, Any], *, interrupted: bool) -> str:
        """Write what an analysis has that ended early, and say where."""
        if not kept:
            return ""
        files = self.write(kept.items(), complete=False, interrupted=interrupted)
        return "\nup to there: " + " and ".join(str(path) for path in files)

    @contextmanager
    def publishing(
        self,
        options: Mapping[str, Any] | None = None,
        *,
        name: str = "",
        complete: bool = True,
        interrupted: bool = False,
    ) -> Iterator[Published]:
        """Where to write the files of the run, see `published`; it is not always as was asked."""
        # what commands say of options themselves, such as a start both ways, is what was asked
        own = {name: value for name, value in self.own.items() if value is not None}
        how = {**self.own, **(self.asked if options is None else options), **own}
        state = {"complete": complete, "interrupted": interrupted}
        with published(name or self.verb, self.folder, self.mechanism, how, **state) as place:
            yield place
        self.notes.extend(place.notes)

    def write(
        self,
        files: Iterable[File],
        options: Mapping[str, Any] | None = None,
        *,
        name: str = "",
        **state: bool,
    ) -> list[Path]:
        """Write the files of the run, one as soon as it is made; returns where they are.

        Their endings follow from what they hold. Files of a command that draws something else each
        time are not those of its last run: their `name` tells them apart.
        """
        with self.publishing(options, name=name, **state) as place:
            for file, content in files:
                _write(place.folder / file, content, self.format, self.differences)
        return place.files

    def publish(
        self,
        report: Report,
        files: Iterable[File],
        figures: Callable[[], Iterable[File]] = tuple,
        options: Mapping[str, Any] | None = None,
        *,
        name: str = "",
        failure: str | None = None,
        interrupted: bool = False,
    ) -> int:
        """Write the files of the run, and figures if they are wanted; then print, see `report`."""

        def made() -> Iterator[File]:
            yield from files
            yield from figures() if self.figures else ()

        state = {"complete": failure is None, "interrupted": interrupted}
        written = self.write(made(), options, name=name, **state)
        return self.report(report, written, failure=failure)

    def report(
        self,
        report: Report,
        files: Sequence[Path],
        *,
        failure: str | None = None,
        listed: bool = True,
    ) -> int:
        """Print what was found, where files are, and why a motion stopped; gives the exit code."""
        if self.json:
            more = {"changes": list(self.mechanism.changes), "moved": self.notes}
            said = {name: texts for name, texts in more.items() if texts}
            print_json({**report.data, **said, "files": [str(path) for path in files]})
        else:
            screen = console()
            print_changes(self.mechanism.changes, screen)
            place = [f"{len(files)} files in {files[0].parent}"] if files and listed else []
            print_report(replace(report, parts=[*report.parts, Notes(self.notes), *place]), screen)
            if failure is not None:
                print(f"stopped {failure}", file=sys.stderr)
        return 0 if failure is None else 1


def _read_flag(name: str, kind: Any, value: Any) -> Any:
    """A value of a result file as the flag of this type has it; ValueError if it has none such."""
    from pydantic import TypeAdapter, ValidationError

    try:
        return TypeAdapter(kind).validate_python(value)
    except ValidationError:
        raise ValueError(f"{name} has no value {shown(value)}") from None


def _write(path: Path, content: Written, picture: str, remark: str) -> None:
    """Write a file, with the ending that its content has; figures with a remark."""
    import xarray as xr

    from linkages.solution.files import save_columns, save_netcdf

    if isinstance(content, str):
        with replaced(path) as temporary:
            temporary.write_text(content, encoding="utf-8")
    elif callable(content):
        with replaced(path) as temporary:
            content(temporary)
    elif isinstance(content, xr.Dataset):
        save_netcdf(content, path.with_name(f"{path.name}.nc"))
    elif isinstance(content, Mapping):
        save_columns(content, path.with_name(f"{path.name}.csv"), blank=True)
    elif content is not None:
        from linkages.plots.figures import write_figure

        write_figure(content, path.with_name(f"{path.name}.{picture}"), remark)


def as_far_as_possible(mechanism: Mechanism, **given: Any) -> tuple[Solution, str | None, bool]:
    """A motion; why it stopped before its end, if it did, and whether somebody stopped it.

    What is given is as `linkages.simulate` takes it.
    """
    from linkages.solution.simulate import simulate
    from linkages.solution.solution import IncompleteError

    try:
        return simulate(mechanism, **given), None, False
    except (IncompleteError, Interrupted) as error:
        return error.solution, str(error), isinstance(error, Interrupted)


def how_far(solution: Solution, failure: str | None) -> dict[str, Any]:
    """Whether a motion came to its end, as JSON says it."""
    stopped = None if failure is None else {"time": solution.motion.stop_time, "reason": failure}
    return {
        "mechanism": solution.mechanism.name,
        "completed": failure is None,
        "stopped": stopped,
    }


def ranges(option: str, texts: Sequence[str]) -> Axis:
    """One axis from the ranges of an option, in lockstep if there are several."""
    from linkages.sweeps.axes import parse_range, together

    axes = each_read(option, texts, parse_range)
    return each_read(option, [axes], together)[0]


def initial_states(texts: Sequence[str]) -> list[dict[str, object]]:
    """Overrides for each initial state, from ``path=value,path=value``."""
    states = each_read("--initial", texts, lambda text: overrides("--initial", NEXT.split(text)))
    return states or [{}]
