"""Addresses and sizes that the compiled loops share.

Every field is an integer: a size, or the address of an array of 8-byte entries.
"""

from __future__ import annotations

import math
from typing import NamedTuple

WORD = 8


class SystemView(NamedTuple):
    """A flow and the workspace for its steps.

    `rows` is a workspace with one row ``[q (n), v (n), a (n), margin (b), margin_rate (b),
    settled (c), settled_rate (c), cosine (d), sine (d), speed (d), function (m),
    function_rate (m)]`` for each stage, so that the state is ``row[:2n]``, its derivative
    ``row[n:3n]``, and the kernel writes straight into ``row[2n:]``. Row 0 is the start of the
    step, row `TableView.end` its end, and the last row a scratch row for samples.
    """

    clock: int
    rates: int
    parameters: int
    timed: int  # what `clock` wrote last
    rotates: int  # (n,) of int64, 0 or 1
    margin_scale: int  # (b,) of float64
    smallest_margins: int  # (b,) of float64
    n: int
    blocks: int
    first_carried: int
    carried: int
    counted: int  # number d of dependent angles whose turns are counted
    backward: int  # 1 where time runs backward, otherwise 0
    holding: int  # number h of modes, of what is remembered, and of its tangents
    held: int  # (h,) of float64: these, the last ones of the parameters
    rows: int
    width: int  # of a row
    pointers: int  # address of the addresses named by POINTERS
    stepper: int  # of 8-byte entries: see FROM and those behind it
    attempt: int  # functions of the step: see `linkages.solvers.loops.explicit_steps`
    further: int
    interpolate: int
    between: int  # as `interpolate`, for samples
    first: int
    sample: int


class TableView(NamedTuple):
    """A tableau for a workspace, with its rows as in `Tableau.extended_A` but without zeros.

    Row r takes the coefficients ``weights[starts[r]:starts[r + 1]]`` of the derivatives that
    begin at the same ``places`` in the workspace.
    """

    starts: int  # (rows + 1,) of int64
    places: int  # of int64
    weights: int  # of float64
    c: int  # (rows,) of float64
    dense: int  # (rows, degree) of float64
    rows: int
    end: int
    degree: int
    cost: int  # evaluations of a step; 0 where the step counts them itself


class Control(NamedTuple):
    """How long the steps of a motion are; further numbers stand in the stepper."""

    advance: int  # address of the function that makes steps by the tolerance
    start: int  # and of that which begins a motion that nothing watches, or 0
    atol: int  # (2n,) of float64
    budget: int  # number of steps
    equal: int  # number of equal steps, or 0
    grid: int  # (3,) of float64: start and length of equal steps, number of the next end of one


class Lanes(NamedTuple):
    """Motions that advance side by side, W at a time; all of them have the same sizes.

    Arrays of the pointers consist of rows of W entries, one of each lane.
    """

    lanes: int  # their number W
    pointers: int
    parameters: int  # arrays of the pointers
    rows: int
    stepper: int
    atol: int
    scale: int
    smallest: int
    turns: int
    angles: int
    values: int
    levels: int
    size: int  # number of parameters
    events: int  # their number e
    functions: int  # (e, 4) of int64: as `Events.functions`, for W lanes
    function_sizes: int  # (e,) of int64: numbers of their parameters
    advance: int  # address of the traced function that makes steps
    further: int  # of those that compute the rows behind the end of a step
    between: int  # and evaluate states within it
    sampling: int  # (W, OF_SAMPLING) of int64: see `sample_lanes`
    begin: int  # of the functions of `loops.step_loop` that begin a motion
    conclude: int  # and finish a step that needs more than arithmetic
    motions: int  # (number,) of int64: their contexts, see `step_loop`
    number: int  # of motions
    outcomes: int  # (number,) of int64
    places: int  # (W,) of int64: the motion in each lane, or -1
    control: int  # (3,) of float64: motions that have ended, whether to stop, steps made alone


class CollocationView(NamedTuple):
    """A collocation method with s stages, in rows 1 to s of the workspace, and its memory.

    A `history` describes a step: `HISTORY` numbers, what its end is too small by, (2n,), the
    accelerations of its stages, (s, n), and those at its end, (n,).
    """

    stages: int
    c: int  # (s,) of float64
    A: int  # (s, s) of float64
    AA: int  # (s, s) of float64: A²
    b: int  # (s,) of float64
    bA: int  # noqa: N815 (s,) of float64: b A
    dense: int  # (2, s, s) of float64: integrals and double integrals of cardinal polynomials
    nodes: int  # (m,) of float64: nodes that starting values continue, m = s or s + 1
    continued: int  # their number m
    ahead: int  # (s, m) of float64: weights of starting values
    ratio: int  # (1,) of float64: of step lengths, for which these weights are
    weights: int  # (2s,) of float64
    timed: int  # (s, timed_size) of float64: what `clock` wrote for each stage
    timed_size: int
    kept: int  # (s, n) of float64: accelerations
    changes: int  # (2,) of float64: largest change of an acceleration, and largest acceleration
    committed: int  # history of the step before row 0
    tried: int  # and of the last trial
    newton: int  # 1 where Newton's method solves the stages, 0 for fixed-point iteration
    linear: int  # (4,) of int64: clock, rates, parameters, timed of derivatives; or zeros
    start: int  # (1 + 3n + h,) of float64: time, row 0 and modes with which they are known
    slopes: int  # of float64: derivatives of accelerations by the state in row 0, (n, 2n)
    matrix: int  # (sn, sn) of float64
    residual: int  # (sn,) of float64
    pivots: int  # (sn,) of int64
    scale: int  # (2n,) of float64: allowed errors at row 0
    error: int  # (s + 1,) of float64: see `Collocation.error`
    newton_tolerance: int  # (2,) of float64, in units of the allowed error; iterations made


# Numbers of a history: the times between which its step goes, and its length.
BEGUN, REACHED, SPAN = range(3)
HISTORY = 3


class Record(NamedTuple):
    """Where results are written."""

    samples: int  # number m of sample times
    time: int  # (m,) of float64
    state: int  # (m, 2n) of float64
    turns: int  # (m, n) of int64
    acceleration: int  # (m, n) of float64
    final_turns: int  # (n,) of int64
    angles: int  # (d,) of float64: dependent angles in row 0, with their turns
    ahead: int  # (d,) of float64: about where they are in the row that is written next
    sampled: int  # (m, d) of float64
    sampled_held: int  # (m, h) of float64
    counters: int  # (6,) of int64
    control: int  # (2,) of float64, which the calling thread reads and writes meanwhile
    observer: int  # a compiled function ``(context, t, when, t)`` that follows every step, or 0
    observed: int  # its context


class Events(NamedTuple):
    """What crossings are looked for, and where they are written."""

    events: int  # their number e
    weights: int  # (e, 2n) of float64
    functions: int  # (e, 4) of int64: clock, rates, parameters, timed; zeros for a linear function
    values: int  # (e, 5) of float64: value and rate of a function now; time, value, rate before
    level: int  # (e,) of float64
    period: int  # (e,) of float64, 0 where the level stands for itself alone
    direction: int  # (e,) of int64: -1, 0 or 1
    terminal: int  # (e,) of int64: number of the crossing that ends the run, or 0
    first: int  # (e + 1,) of int64: row at which each event's record begins
    found: int  # (e,) of int64
    time: int  # (rows,) of float64
    state: int  # (rows, 2n) of float64
    turns: int  # (rows, n) of int64
    angles: int  # (rows, d) of float64
    held: int  # (rows, h) of float64


class SwitchesView(NamedTuple):
    """Modes that change where functions of time and state cross zero."""

    modes: int  # their number m
    memories: int  # number of what is remembered
    tangents: int
    free: int  # number of free coordinates and internal states, and of entries of a tangent
    values: int  # number of new values that `transition` writes
    active: int  # (m,) of int64: see `flow.Switching`
    owners: int  # (memories,) of int64
    jumps: int  # (m,) of int64
    sticks: int  # (m,) of int64, 0 or 1
    couples_others: int  # (m,) of int64, 0 or 1
    transition: int  # (4,) of int64: clock, rates, parameters, timed; zeros if there is none
    written: int  # what it wrote, of float64
    before: int  # (3n,) of float64: state and accelerations before a change
    copies: int  # (c, 2) of int64: where what is held is needed as well, and how much of it
    copied: int  # their number c
    events: int  # number of events
    values_of_events: int  # see `Events.values`
    pending: int  # (2,) of int64: the switch that changes next; changes in a row
    kind: int  # see `SwitchingView`
    halved: int  # (1,) of int64: how often a step has been halved to see what functions do
    rows: int  # of int64: stages at which functions are compared with cubics
    compared: int  # their number
    since: int  # (1,) of float64: time of the first of them
    capacity: int  # of the record of changes
    found: int  # (m,) of int64: changes of each switch
    noted: int  # (1,) of int64: all changes
    time: int  # (capacity,) of float64
    which: int  # (capacity,) of int64
    rises: int  # (capacity,) of int64, 0 or 1
    state: int  # (capacity, 2n) of float64, before the change
    turns: int  # (capacity, n) of int64
    held: int  # (capacity, h) of float64, behind the change
    constraints: int  # number c of functions that modes keep constant
    holders: int  # (c, 2) of int64: see `flow.Switching.constraints`


class Tangents(NamedTuple):
    """Tangents that are renormalised; see `tangents.Renormalisation`."""

    size: int
    placed: int
    columns: int
    every: int
    offset: int
    orthogonal: int  # 0 or 1
    project: int  # a compiled function that projects tangents where modes constrain them, or 0
    context: int  # and its context: see `transitions.project`
    seen: int  # (1,) of int64: samples that are done
    lengths: int  # (times, columns) of float64: logarithms of lengths before
    grown: int  # (columns,) of float64: those since the last of these times
    copy: int  # (2·columns·size,) of float64: room for tangents
    tolerances: int  # (2,) of float64: relative and absolute
    memories: int  # number of what is remembered
    moved: int  # (columns, memories) of float64: its tangents


class Hook(NamedTuple):
    """A compiled function that sees every accepted step; both are 0 if there is none.

    ``function(context, t, h, t_end)`` returns the fraction of the step at which the run ends, or
    more than 1. `context` is the address of a `SystemView`, `TableView`, `Record` and `Events` in a
    row.
    """

    function: int
    context: int


class SwitchingView(NamedTuple):
    """Compiled functions that find and make the changes of modes; 0 if there are none.

    ``find(context, t, h, t_end)`` returns the fraction of an accepted step at which a mode
    changes, with the workspace holding the step up to there, or more than 1, or less than 0 where
    the step is to be halved; `estimate` about the same for a rejected step. Then ``apply`` of the
    same arguments makes the change at the state in row 0 and returns an `Outcome`. `context` is the
    address of a `SystemView`, `TableView`, `Record` and `SwitchesView` in a row.
    """

    find: int
    estimate: int
    apply: int
    context: int
    kind: int  # (1,) of int64: what the last change was, 2·switch, and 1 more for a rise
    first_steps: int  # (2m,) of float64: lengths of the steps behind the last changes of each kind


# When an observer is called: behind a step, at the start, before and behind a change of a mode.
STEP, START, BEFORE_CHANGE, BEHIND_CHANGE = 0.0, 1.0, 2.0, 3.0
# Entries of `counters`.
SAMPLES, STEPS, REJECTED, EVALUATIONS, BLOCK, SWITCH = range(6)
# Entries of `control`: the time reached, whether to stop, and steps of lanes made alone.
NOW, STOP, SCALAR_STEPS = range(3)
# Entries of a lane of `Lanes.sampling`.
OF_SAMPLING = 7
# Entries per event of `Events.functions` and `Events.values`.
FUNCTION, VALUES = 4, 5
# Arrays that generated code finds by their pointers. Those of a single motion alone:
SINGLE = (
    "counters", "times", "states", "sampled_turns", "accelerations", "sampled", "collocation",
)  # fmt: skip
# Of lanes alone: the function that takes their samples, and its context.
SEVERAL = ("sampler", "lanes")
POINTERS = (
    "clock", "rates", "parameters", "held", "timed", "rows", "stepper", "atol", "scale", "smallest",
    "turns", "angles", "ahead", "functions", "values", "levels", *SINGLE, *SEVERAL,
)  # fmt: skip
ATOL, TURNS, ANGLES, FUNCTIONS, EVENT_VALUES, LEVELS, COLLOCATION = map(
    POINTERS.index, ("atol", "turns", "angles", "functions", "values", "levels", "collocation")
)
# Entries of the stepper, the state of step control. The step in the workspace: start, length, end,
# and what the end is too large by.
FROM, LENGTH, TO, NEXT_CARRY = range(4)
# Its result: status of the kernel (an integer), error norm, factor to the next length, acceptance.
STATUS, ERROR, FACTOR, ACCEPTED = range(4, 8)
# The motion: time, what it is too large by, length of the next step, and final time.
T, CARRY, H, END = range(8, 12)
# Length of the first step, error norm of the last one, whether the last trial was rejected, and the
# time of the next sample.
FIRST, BEFORE, REJECTED_BEFORE, SAMPLE = range(12, 16)
# Status of the last trial that could not be evaluated; whether the step follows a mode switch, and
# of which kind that was.
LAST_STATUS, AFTER_SWITCH, SWITCH_KIND = range(16, 19)
# Whether every step needs `step_loop`, whether the lane is in use, the relative tolerance, and
# steps accepted and rejected since they were counted last.
FORCE_SCALAR, ACTIVE, RTOL, ACCEPTED_STEPS, REJECTED_STEPS = range(19, 24)
# Whether nothing observes the motion, so that the fast path takes its samples; fraction of the step
# at which the state is interpolated; how often the step has been halved to resolve mode switches
# (an integer); the time at which lanes are evaluated there.
UNOBSERVED, THETA, HALVED, EVALUATION_TIME = range(24, 28)
# Length of the step behind the last mode switch, once it has been accepted; 0 before.
FIRST_LENGTH = 28
STEPPER_SIZE = 29
# Steps below this many units in the last place of time no longer move it reliably.
SMALLEST_STEP = 16 * 2.220446049250313e-16
# A word of two halves: the lower ones, and the number of bits of each.
HALF, LOWER = 32, 2**32 - 1
QUARTER, LOWEST = 16, 2**16 - 1
NOT_FINITE = -1
# The iteration for the stages of an implicit step does not converge.
NOT_SETTLED = -2
LARGEST_STATE = 1e150
# An angle that moves by this much within one step has nothing to do with the motion any more.
LARGEST_ANGLE = 1e9
TWO_PI = 2 * math.pi
# 2π minus its nearest double: subtracting both parts keeps an angle right to its last digit
# after any number of turns.
TWO_PI_TAIL = 2.4492935982947064e-16
