"""Memory of a motion: the tables that arrays are made from and that compiled code reads.

An `Int` is a size, and any other entry the address of an array, whose shape is beside it, or of a
function.
"""

from __future__ import annotations

import math

from linkages.kernel.code.operands import Entry, Function, Int, IntArray, Numbers, RealArray, Table

WORD = 8


class KernelTable(Table):
    """A kernel: its functions, what both of them read, and what `clock` writes for `rates`."""

    clock: Function
    rates: Function
    parameters: RealArray
    timed: RealArray


class Stepper(Numbers):
    """State of step control."""

    # the step in the workspace: start, length, end, and what the end is too large by
    start, length, stop, next_carry = Entry(), Entry(), Entry(), Entry()
    status = Entry(Int)  # of the kernel in the last trial
    error = Entry()  # its norm
    factor = Entry()  # to the length of the next trial
    accepted = Entry()
    # the motion: time, what it is too large by, length of the next step, and final time
    t, carry, h, end = Entry(), Entry(), Entry(), Entry()
    first = Entry()  # length of the first step
    before = Entry()  # error norm of the last step
    rejected_before = Entry()  # whether the last trial was rejected
    sample = Entry()  # time of the next sample
    last_status = Entry()  # of the last trial that could not be evaluated
    after_switch, switch_kind = Entry(), Entry()  # whether the step follows a switch, and of what
    force_scalar = Entry()  # whether every step needs `step_loop`
    active = Entry()  # whether the lane is in use
    rtol = Entry()
    accepted_steps, rejected_steps = Entry(), Entry()  # since they were counted last
    unobserved = Entry()  # whether nothing looks at the motion: the fast path takes its samples
    theta = Entry()  # fraction of the step at which the state is interpolated
    halved = Entry(Int)  # how often the step has been halved to resolve mode switches
    evaluation_time = Entry()  # at which lanes are evaluated there
    first_length = Entry()  # of an accepted step behind the last mode switch; 0 before
    longest = Entry()  # length of a step


class Counters(Numbers):
    """Numbers of samples, steps, rejected steps and evaluations; block and switch concerned."""

    samples, steps, rejected = Entry(Int), Entry(Int), Entry(Int)
    evaluations, block, switch = Entry(Int), Entry(Int), Entry(Int)


class Progress(Numbers):
    """Time reached, or number of motions that ended; whether to stop; steps of lanes made alone."""

    now, stop, scalar_steps = Entry(), Entry(), Entry()


class EventValues(Numbers):
    """Value and rate of the function of an event; time, value and rate at the last step's end."""

    value, rate, before, value_before, rate_before = Entry(), Entry(), Entry(), Entry(), Entry()


class Sampling(Numbers):
    """What is known of the samples of a lane."""

    open = Entry(Int)  # whether some are left
    known, broken = Entry(Int), Entry(Int)  # rows behind the end: counted; cannot be evaluated
    between = Entry(Int)  # whether the next sample is before the end
    first_sample, first_evaluation, first_time = Entry(Int), Entry(Int), Entry()  # at first


class Pointers(KernelTable):
    """What generated steps read, and lanes and slots have: the kernel, and arrays of a motion.

    `rows` is a workspace with one row ``[q (n), v (n), a (n), margin (b), margin_rate (b), settled
    (c), settled_rate (c), cosine (d), sine (d), speed (d), function (m), function_rate (m)]`` for
    each stage, so that the kernel writes straight into ``row[2n:]``. Row 0 is the start of the
    step, row `Motion.end` its end, and the last row a scratch row for samples. Arrays of W lanes
    consist of rows of W entries.
    """

    held: RealArray  # (h,): modes, what is remembered, and its tangents; the last parameters
    rows: RealArray
    stepper: Stepper
    atol: RealArray  # (2n,)
    scale: RealArray  # (b,): of margins
    smallest: RealArray  # (b,): margins at which the motion ends
    turns: IntArray  # (n,)
    angles: RealArray  # (d,): dependent angles in row 0, with their turns
    ahead: RealArray  # (d,): about where they are in the row that is written next
    functions: IntArray  # (e, FUNCTION): a `KernelTable` of each event; zeros for a linear one
    values: RealArray  # (e, VALUES): `EventValues` of each event
    levels: RealArray  # (e,)
    counters: Counters
    times: RealArray  # (m + 1,): of samples, and one that is never reached
    states: RealArray  # (m, 2n)
    sampled_turns: IntArray  # (m, n)
    accelerations: RealArray  # (m, n)
    sampled: RealArray  # (m, d): dependent angles
    sampler: Function  # takes the samples of lanes: see `lane_loop.sample_lanes`

    def event_values(self, event: Int | int) -> EventValues:
        """What is kept of an event."""
        return EventValues(self.code, self.values.after(VALUES * event).pointer)


class Events(Table):
    """What crossings are looked for, and where they are written."""

    watch: Function  # ``(motion, t, h, t_end)``: see `crossings.watch_step`
    number: Int  # e
    weights: RealArray  # (e, 2n)
    period: RealArray  # (e,), 0 where the level stands for itself alone
    direction: IntArray  # (e,): -1, 0 or 1
    terminal: IntArray  # (e,): number of the crossing that ends the run, or 0
    first: IntArray  # (e + 1,): row at which each event's record begins
    found: IntArray  # (e,)
    time: RealArray  # (rows,)
    state: RealArray  # (rows, 2n)
    turns: IntArray  # (rows, n)
    angles: RealArray  # (rows, d)
    held: RealArray  # (rows, h)


class Switches(Table):
    """Modes that change where functions of time and state cross zero.

    ``find(motion, t, h, t_end)`` returns the fraction of an accepted step at which a mode changes,
    with the workspace holding the step up to there, or more than 1, or less than 0 where the step
    is to be halved; ``estimate(motion, h)`` about the same for a rejected step. Then
    ``apply(motion, t)`` makes the change at the state in row 0 and returns an `Outcome`.
    """

    find: Function
    estimate: Function
    apply: Function
    modes: Int  # their number m
    memories: Int  # number of what is remembered
    tangents: Int
    free: Int  # number of free coordinates and internal states, and of entries of a tangent
    values: Int  # number of new values that `transition` writes
    active: IntArray  # (m,): see `flow.Switching`
    owners: IntArray  # (memories,)
    jumps: IntArray  # (m,)
    sticks: IntArray  # (m,), 0 or 1
    couples_others: IntArray  # (m,): see `flow.Switching`
    transition: KernelTable  # zeros if there is none
    written: RealArray  # what it wrote
    before: RealArray  # (3n,): state and accelerations before a change
    copies: IntArray  # (c, 2): where what is held is needed as well, and how much of it
    copied: Int  # their number c
    pending: IntArray  # (2,): the switch that changes next; changes in a row
    last: IntArray  # (1,): what the last change was, 2·switch, and 1 more for a rise
    first_steps: RealArray  # (2m,): lengths of the steps behind the last changes of each kind
    rows: IntArray  # stages at which functions are compared with cubics
    compared: Int  # their number
    since: RealArray  # (1,): time of the first of the changes in a row
    capacity: Int  # of the record of changes
    found: IntArray  # (m,): changes of each switch
    noted: IntArray  # (1,): all changes
    time: RealArray  # (capacity,)
    which: IntArray  # (capacity,)
    rises: IntArray  # (capacity,), 0 or 1
    state: RealArray  # (capacity, 2n), before the change
    turns: IntArray  # (capacity, n)
    held: RealArray  # (capacity, h), behind the change
    constraints: Int  # number c of functions that modes keep constant
    holders: IntArray  # (c, 2): see `flow.Switching.constraints`


class Tangents(Table):
    """Tangents that are renormalised; see `flow.Renormalisation`."""

    watch: Function  # ``(motion, t, when)``: see `renormalised.watch_tangents`
    project: Function  # ``(motion, t, behind)`` where modes constrain tangents
    size: Int
    placed: Int
    columns: Int
    every: Int
    offset: Int
    orthogonal: Int  # 0 or 1
    seen: IntArray  # (1,): samples that are done
    lengths: RealArray  # (times, columns): logarithms of lengths before
    grown: RealArray  # (columns,): those since the last of these times
    copy: RealArray  # (2·columns·size,): room for tangents
    tolerances: RealArray  # (2,): relative and absolute
    memories: Int  # number of what is remembered
    moved: RealArray  # (columns, memories): its tangents


class CollocationTable(Table):
    """A collocation method with s stages, in rows 1 to s of the workspace, and its memory.

    A history describes a step: `HISTORY` numbers, what its end is too small by, (2n,), the
    accelerations of its stages, (s, n), and those at its end, (n,).
    """

    stages: Int
    A: RealArray  # (s, s)
    AA: RealArray  # (s, s): A²
    b: RealArray  # (s,)
    bA: RealArray  # noqa: N815 (s,): b A
    dense: RealArray  # (2, s, s): integrals and double integrals of cardinal polynomials
    nodes: RealArray  # (m,): nodes that starting values continue, m = s or s + 1
    continued: Int  # their number m
    ahead: RealArray  # (s, m): weights of starting values
    ratio: RealArray  # (1,): of step lengths, for which these weights are
    weights: RealArray  # (2s,)
    timed: RealArray  # (s, timed_size): what `clock` wrote for each stage
    timed_size: Int
    kept: RealArray  # (s, n): accelerations
    changes: RealArray  # (2,): largest change of an acceleration, and largest acceleration
    committed: RealArray  # history of the step before row 0
    tried: RealArray  # and of the last trial
    newton: Int  # 1 where Newton's method solves the stages, 0 for fixed-point iteration
    linear: KernelTable  # derivatives of the flow; or zeros
    start: RealArray  # (1 + 3n + h,): time, row 0 and modes with which they are known
    slopes: RealArray  # derivatives of accelerations by the state in row 0, (n, 2n)
    matrix: RealArray  # (sn, sn)
    residual: RealArray  # (sn,)
    pivots: IntArray  # (sn,)
    scale: RealArray  # (2n,): allowed errors at row 0
    error: RealArray  # (s + 1,): see `Collocation.error`
    newton_tolerance: RealArray  # (2,), in units of the allowed error; iterations made


# Numbers of a history: the times between which its step goes, and its length.
BEGUN, REACHED, SPAN = range(3)
HISTORY = 3


class Motion(Pointers):
    """All that compiled code knows of a motion: flow, method, interval, and what to watch."""

    rotates: IntArray  # (n,), 0 or 1
    n: Int
    blocks: Int  # their number b
    first_carried: Int
    carried: Int  # number c
    counted: Int  # number d of dependent angles whose turns are counted
    holding: Int  # number h of modes, of what is remembered, and of its tangents
    width: Int  # of a row
    backward: Int  # 1 where time runs backward, otherwise 0
    c: RealArray  # nodes of the rows
    end: Int  # row that holds the end of a step
    scratch: Int  # row behind all stages
    cost: Int  # evaluations of a step; 0 where the step counts them itself
    attempt: Function
    further: Function
    interpolate: Function
    between: Function  # as `interpolate`, for samples
    first: Function
    sample: Function
    commit: Function
    expect_end: Function
    expect_between: Function
    count: Function
    advance: Function  # makes steps by the tolerance
    begin: Function  # begins a motion that nothing watches, if there is one
    budget: Int  # number of steps
    equal: Int  # number of equal steps, or 0
    grid: RealArray  # (3,): start and length of equal steps, number of the next end of one
    samples: Int  # number m of sample times
    sampled_held: RealArray  # (m, h)
    control: Progress
    events: Events
    switches: Switches
    tangents: Tangents
    collocation: CollocationTable

    def row(self, row: Int | int, place: Int | int = 0) -> RealArray:
        """A row of the workspace, from one of its entries on."""
        return self.rows.after(row * self.width + place)


class Lanes(Pointers):
    """Motions that advance side by side, W at a time; all of them have the same sizes."""

    lanes: Int  # their number W
    size: Int  # number of parameters
    events: Int  # number e of events
    function_sizes: IntArray  # (e,): numbers of parameters of what they watch
    advance: Function  # makes steps
    further: Function  # computes the rows behind the end of a step
    between: Function  # evaluates states within it
    sampling: IntArray  # (W, 7): `Sampling` of each lane
    begin: Function  # of `step_loop`: begins a motion
    conclude: Function  # finishes a step that needs more than arithmetic
    motions: IntArray  # (number,): their addresses
    number: Int  # of motions
    outcomes: IntArray  # (number,)
    occupants: IntArray  # (W,): the motion in each lane, or -1
    control: Progress


# When an observer is called: behind a step, at the start, before and behind a change of a mode.
STEP, START, BEFORE_CHANGE, BEHIND_CHANGE = 0.0, 1.0, 2.0, 3.0
# Entries per event of `Pointers.functions` and `Pointers.values`.
FUNCTION, VALUES = KernelTable.words(), len(EventValues.entries())
STEPPER_SIZE = len(Stepper.entries())
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
# Trials of a round, between two looks at whether to stop.
TICKS = 64
# Where `step_loop` goes on, and what it returns if there is more to do.
START_OF_MOTION, FLAGGED_STEP, BEHIND_STEP = range(3)
PAUSED = -1
