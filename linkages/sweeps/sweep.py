"""Measures at many points: grids, lists and draws of numbers of a definition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.varying import Varying
from linkages.options.option import takes
from linkages.options.run import SimulationKeywords, SimulationOptions
from linkages.reading.overrides import parse_assignment
from linkages.solution.measure_names import example_measure
from linkages.solution.run_options import options_of
from linkages.spec.measures import Measure, read_measure
from linkages.sweeps.axes import parse_axis
from linkages.sweeps.engine import Computed, Watch, marks
from linkages.sweeps.places import Cluster, swept
from linkages.sweeps.point_measures import MeasureQuestion
from linkages.sweeps.points import points_of
from linkages.sweeps.running import Executor, Threads

if TYPE_CHECKING:
    import xarray as xr


@takes(SimulationOptions)
def sweep(
    mechanism: Mechanism,
    over: Mapping[Any, Any],
    measure: str | Sequence[str] | Mapping[str, str],
    *,
    draws: int | None = None,
    seed: int = 0,
    sequence: str = "random",
    store: str | Path | None = None,
    cores: int | None = None,
    scheduler: str | None = None,
    device: str = "cpu",
    executor: Executor | None = None,
    time_per_point: float | None = None,
    nominal: Mechanism | None = None,
    watch: Watch | None = None,
    **options: Unpack[SimulationKeywords],
) -> xr.Dataset:
    """Measures of the motion at many points: a grid, draws from distributions, or both.

    Parameters
    ----------
    mechanism
        From a file or made in Python.
    over
        Dotted path of the definition → values: numbers in SI, texts with one unit, or a quantity
        of pint, one axis for each. A tuple of paths → rows of values that vary in lockstep. A path
        → a distribution: ``"normal(40 mm, 0.02 mm)"``, ``"uniform(…)"``, ``"triangular(…)"`` or a
        frozen one of SciPy; these are drawn together.
    measure
        What is asked, as `linkages.measure` reads it: one, several, or name → measure.
    draws
        How often numbers are drawn from distributions.
    seed, sequence
        Of the draws: ``"random"``, of which draw i depends on seed, path and i alone, ``"sobol"``
        or ``"latin-hypercube"``.
    store
        Folder in which results are kept as they come; the same call goes on there.
    cores
        Computations at the same time; those that this process may use if not given.
    scheduler
        Address of a Dask scheduler, on whose workers points are computed instead.
    device
        ``"cuda"``: motions are integrated on the first graphics processor of this machine.
    executor
        Where points are computed instead, as `linkages.bifurcation` takes it.
    time_per_point
        Seconds after which a point is given up.
    nominal
        Whose motion ``error(…)`` in measures is against; that of `mechanism` if not given.
    watch
        Called now and then with the progress.
    options
        As `SimulationOptions` describes them.

    Returns
    -------
    Dataset with a dimension for each axis and ``draw``; a variable for each measure, nan where
    there is none; `outcome`: a code, in words in its attribute ``flag_meanings``; `reason`: a text;
    `stop_time` of motions that stopped, in seconds; and `evaluations`, what a point cost.

    Raises
    ------
    InputError, ValueError, TypeError
        For what makes no sense, at all points or before any.
    ComputationError
        If the store cannot take more.
    DeviceError
        If there is no graphics processor, or it fails.
    Interrupted
        After Ctrl-C; ``kept["sweep"]`` has the points so far.
    """
    points = points_of(over, draws, seed, sequence)
    options_of(SimulationOptions, mechanism, options)
    if time_per_point is not None and not time_per_point > 0:
        raise ValueError(f"time_per_point must be seconds > 0, found {time_per_point!r}")
    if sum(where is not None for where in (cores, scheduler, executor)) > 1:
        raise ValueError("cores, scheduler and executor say where to compute; expected one of them")
    if executor is None:
        executor = Threads(cores) if scheduler is None else Cluster(scheduler)
    measures = named_measures(measure)
    if not measures:
        example = example_measure(mechanism)
        raise ValueError(f"nothing is measured; expected a measure such as {example!r}")
    if same := [path for path in points.paths if path in measures]:
        raise ValueError(f"{same[0]} is varied itself; expected a measure of something else")
    given = {name: value for name, value in options.items() if value is not None}
    question = MeasureQuestion(Varying(mechanism), points, measures, given, time_per_point, nominal)
    question.prepare()
    units = question.units()  # what is wrong everywhere shows here
    made = partial(_dataset, mechanism, question, units)
    return swept(
        question, mechanism, "sweep", "points", made,
        device=device, executor=executor, store=store, watch=watch,
    )  # fmt: skip


def measure_name(text: str) -> str:
    """What a measure without a name is called: as it is written, but for slashes."""
    return text.strip().replace("/", "÷")


def named_measures(given: str | Sequence[str] | Mapping[str, str]) -> dict[str, Measure]:
    """Name → measure."""
    texts = [given] if isinstance(given, str) else given
    named = texts if isinstance(texts, Mapping) else {measure_name(t): t for t in texts}
    return {name: read_measure(text) for name, text in named.items()}


def _dataset(
    mechanism: Mechanism, question: MeasureQuestion, units: Mapping[str, str], found: Computed
) -> xr.Dataset:
    import xarray as xr

    points = question.points
    dims, shape = points.dims, points.shape
    variables: dict[str, Any] = {}
    for name, each in question.measures.items():
        attrs = {"units": units[name], "long_name": each.text}
        variables[name] = (dims, found.arrays[name].reshape(shape), attrs)
    cost = {"long_name": "evaluations of the equations of motion"}
    variables |= marks(found.arrays, dims, shape)
    variables["evaluations"] = (dims, found.arrays["evaluations"].reshape(shape), cost)
    about: dict[str, Any] = {"name": mechanism.name, "source": mechanism.file_name}
    if points.drawn:
        about |= {"draws": points.draws, "seed": points.seed, "sequence": points.sequence}
        about |= {"drawn": "; ".join(f"{path}={d.text}" for path, d in points.drawn.items())}
    about["interrupted"] = int(found.interrupted)
    return xr.Dataset(variables, points.coordinates(mechanism), about)


@takes(SimulationOptions)
def sweep_asked(
    mechanism: Mechanism,
    measure: Sequence[str],
    vary: Sequence[str] = (),
    sample: Sequence[str] = (),
    *,
    draws: int | None = None,
    seed: int = 0,
    sequence: str = "random",
    time_per_point: float | None = None,
    **options: Unpack[SimulationKeywords],
) -> xr.Dataset:
    """The sweep of a command: measures, ``PATH=VALUES`` and ``PATH=DISTRIBUTION`` are texts."""
    over: dict[Any, Any] = {}
    for axis in map(parse_axis, vary):
        over[axis.paths if len(axis.paths) > 1 else axis.label] = axis
    over |= dict(map(parse_assignment, sample))
    return sweep(
        mechanism, over, measure, draws=draws, seed=seed, sequence=sequence,
        time_per_point=time_per_point, **options,
    )  # fmt: skip
