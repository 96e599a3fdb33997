"""The compiled functions of a structure, to which numbers are bound, and how long they take.

Terms are nodes of the scalar graph. Before anything is made, their number is estimated from what
each free coordinate moves, and the time from their number by measurements (`docs/kernel.md`).
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.program import (
    GeneratedProgram,
    Kernel,
    Program,
    bind_kernel,
    write_functions_of,
    write_program,
)
from linkages.kernel.code.statements import Routine
from linkages.kernel.code.writer import write_assembly
from linkages.kernel.inputs import definition_vector
from linkages.kernel.layout import Layout
from linkages.kernel.lru_cache import LRUCache
from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar
from linkages.kernel.state_jumps import (
    constraints,
    jump_places,
    transition_nodes,
    variations,
    write_jacobian,
)
from linkages.kernel.switches import LONGEST_STEP
from linkages.kernel.system import MOST_STRUCTURES, System
from linkages.solvers.flow import UPDATES, Flow, Switching
from linkages.topology.topology import Topology

Floats = NDArray[np.float64]

LOGGER = logging.getLogger(__name__)

PATIENCE = 10.0
"""Seconds from which on a computation says what to expect before it begins."""

PER_MEMBER = 110
"""Terms of a body of a tree that is eliminated body by body."""

PER_BODY, PER_MOVED, PER_PAIR = 50, 20, 5
"""Terms of other bodies; of a point and a coordinate that moves it; of a point and two of these."""

PER_TANGENT = 2
"""Terms of a derivative, for each that is differentiated."""

EACH = 6e-5
"""Seconds for generating and compiling a term."""


def expected_terms(topology: Topology) -> float:
    """About how many terms the accelerations of the free coordinates have."""
    bodies = len(topology.mechanism.bodies)
    if topology.hangs:
        return float(PER_MEMBER * bodies)
    moving = [moved.bit_count() for moved in _moved(topology).values()]
    pairs = sum(count * (count + 1) / 2 for count in moving)
    solved = sum(size**3 / 3 for size in _coupled(_moved(topology).values()))
    return PER_BODY * bodies + PER_MOVED * sum(moving) + PER_PAIR * pairs + solved


def _moved(topology: Topology) -> dict[str, int]:
    """Point → bits of the free coordinates that move it."""
    turning = {name: 1 << place for place, name in enumerate(topology.free)}
    at: dict[str, int] = {}

    def turned(body: str) -> int:
        result = turning.get(body, 0)
        for master in (*topology.orientations[body].masters, *topology.orientations[body].moved):
            result |= turning.get(master, 0)
        return result

    for block in topology.blocks:
        if block.unknowns:
            ends = [point for loop in block.loops for point in (loop.start, loop.end)]
            bodies = [step.body for loop in block.loops for step in loop.steps]
            known = 0
            for moved in (*(at.get(point, 0) for point in ends), *map(turned, bodies)):
                known |= moved
            turning |= dict.fromkeys(block.unknowns, known)
        for body, entry, labels in block.placements:
            at |= dict.fromkeys(labels, at.get(entry, 0) | turned(body))
    return at


def _coupled(moved: Iterable[int]) -> list[int]:
    """Sizes of the sets of coordinates that are solved together."""
    sets: list[int] = []
    for bits in dict.fromkeys(moved):
        apart = []
        for other in sets:
            if bits & other:
                bits |= other
            else:
                apart.append(other)
        sets = [*apart, bits]
    return [bits.bit_count() for bits in sets]


def expected_seconds(terms: float) -> float:
    """About how long it takes to generate and compile so many terms."""
    return EACH * terms


def announce(terms: float, what: str) -> None:
    """Say what to expect of something that takes long to begin."""
    seconds = expected_seconds(terms)
    if seconds > PATIENCE:
        LOGGER.warning(
            "%s: about %s terms, which take about %.2g %s to generate and compile; the result is "
            "kept for the next run",
            what,
            f"{float(f'{terms:.2g}'):,.0f}",
            *((seconds, "s") if seconds < 120 else (seconds / 60, "min")),
        )


EventFunction = Callable[[Model], tuple[Scalar, Scalar]]
"""Equations → a function of position and velocity, and its rate."""


@dataclass(frozen=True)
class KernelSource:
    """What a kernel is made of."""

    model: Model  # the equations
    accelerations: tuple[Scalar, ...]  # second derivatives of all integrated coordinates
    # Cosines, sines and speeds of dependent angles whose whole turns are counted
    counted: tuple[Scalar, ...] = ()
    switched: tuple[Scalar, ...] = ()  # functions whose signs are modes, then their rates

    @cached_property
    def program(self) -> Program:
        """The generated kernel."""
        return write_program(
            self.model, self.accelerations, counted=self.counted, switched=self.switched
        )


def kernel_source(topology: Topology, layout: Layout | None = None) -> KernelSource:
    """The equations that are integrated, in a graph of their own.

    The work is the rate of one more coordinate, whose acceleration is the power of drives and
    loads; so are losses. A tangent has n more coordinates, which obey the linearised equations.
    Without a `layout`, the motion alone is integrated.
    """
    layout = Layout.of(topology) if layout is None else layout
    model = Model(topology, layout.more, layout.slopes)
    moving = model.integrated_accelerations(model.changes)
    accelerations = [*moving, model.power] if layout.work else moving
    accelerations = [*accelerations, *(model.losses if layout.losses else ())]
    accelerations = [*accelerations, *variations(model, layout)]
    counted = tuple(model.counted) if layout.counted else ()
    watched = model.switches.watched
    switched = (*watched, *model.switches.rates(watched, moving))
    return KernelSource(model, tuple(accelerations), counted, switched)


def switching_of(model: Model, layout: Layout) -> Switching | None:
    """The switches of equations whose kernel has been made; None where there are none."""
    switches = model.switches
    if not switches.switches:
        return None
    return Switching(
        names=tuple(switch.name for switch in switches.switches),
        active=tuple(-1 if s.active is None else s.active for s in switches.switches),
        owners=tuple(memory.owner for memory in switches.memories),
        jumps=jump_places(model),
        sticks=tuple(switch.stick for switch in switches.switches),
        couples_others=tuple(
            UPDATES if switch.updates else int(switch.couples_others)
            for switch in switches.switches
        ),
        free=layout.moved,
        tangents=layout.tangents,
        constraints=tuple((own.mode, own.touch) for own in constraints(model, layout)),
    )


@dataclass(frozen=True)
class Plan:
    """The compiled equations of all mechanisms of a structure, without any of their numbers.

    Equal structures have equal plans. A plan can be pickled; another process compiles it, or finds
    its kernel in the cache.

    Parameters
    ----------
    key
        The structure, and what is integrated.
    layout
        What stands where.
    rotates
        Which integrated coordinates are kept within one turn.
    program
        The generated kernel.
    switching
        What modes there are; None where there are none.
    """

    key: tuple[Hashable, ...] = field(repr=False)
    layout: Layout
    rotates: tuple[bool, ...]
    program: GeneratedProgram = field(compare=False, repr=False)
    switching: Switching | None = field(default=None, repr=False)

    @classmethod
    def of(
        cls,
        of: System | Mechanism,
        *,
        work: bool = False,
        losses: bool = False,
        tangents: int = 0,
        counting: bool = False,
        sensitive: Collection[str] = (),
    ) -> Plan:
        """The plan of a mechanism's structure: generated once, then remembered.

        Parameters
        ----------
        of
            A mechanism with free coordinates, or the same, assembled.
        work
            Whether to integrate the work of drives and loads.
        losses
            Whether to integrate what contacts lose, and the sliding of those that wear.
        tangents
            Number of solutions of the variational equations to integrate.
        counting
            Whether to count the whole turns of dependent angles.
        sensitive
            Dotted paths of numbers that stay arguments of the kernel whatever their value: a zero,
            a right angle or a ratio of one among them is no structure.

        Raises
        ------
        InputError
            If the mobility is wrong or the mechanism cannot be assembled.
        """
        if sensitive:
            of = (of.mechanism if isinstance(of, System) else of).keeping(sensitive)
        system = of if isinstance(of, System) else System(of)
        fed = () if system.effects is None else system.effects.fed
        key = (system.structure.key, work, losses, tangents, counting, fed)

        def made() -> Plan:
            topology = system.topology
            own = (*system.mechanism.contacts, *system.mechanism.rubbing)
            lost = 2 * len(own) if losses else 0
            layout = replace(Layout.of(topology, work, lost, tangents, counting), fed=fed)
            terms = expected_terms(topology) * (1 + PER_TANGENT * tangents)
            announce(terms, f"equations of motion of {len(topology.free)} free coordinates")
            source = kernel_source(topology, layout)
            switches = source.model.switches
            modes = len(switches.switches)
            layout = replace(
                layout,
                parameters=tuple(source.model.inputs.parameters),
                modes=switches.names[:modes],
                memories=switches.names[modes:],
            )
            bodies, names = system.mechanism.bodies, layout.coordinates
            turning = {name for name in bodies if bodies[name].rotates}
            rotates = [name in turning and not topology.unwrapped(name) for name in names]
            rotates += [False] * (layout.size - len(names))
            program = GeneratedProgram.of(source.program)
            switching = switching_of(source.model, layout)
            return cls(key, layout, tuple(rotates), program, switching)

        return _PLANS.get(key, made)

    def __getstate__(self) -> dict[str, object]:
        """Without what belongs to this process."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}

    def numbers(self, mechanism: Mechanism) -> Floats:
        """The parameters of a mechanism of this structure as its definition gives them, shape (p,).

        Sides of blocks are 1 and whole turns 0: those are found by assembling, as `System` does.
        """
        return definition_vector(mechanism, self.layout.parameters)

    def numbers_along(self, mechanism: Mechanism, values: Mapping[str, Sequence[object]]) -> Floats:
        """Parameters of a mechanism with other values, assembled, shape (lanes, p).

        Parameters
        ----------
        mechanism
            What is varied.
        values
            Dotted paths → equally many values, as `Mechanism.with_values` takes them.

        Raises
        ------
        InputError
            If a path names nothing, a value cannot be used or a mechanism not be assembled.
        ValueError
            If values change the structure: these need plans of their own.
        """
        from linkages.kernel.varying import Varying

        points = [dict(zip(values, row, strict=True)) for row in zip(*values.values(), strict=True)]
        along = Varying(mechanism).along(points)
        result = np.empty((len(points), len(self.layout.parameters)))
        for index, row in enumerate(result):
            system = along.system(index)
            self._require(system)
            row[:] = system.parameters
        return result

    def _require(self, system: System) -> None:
        key = system.structure.key
        if key is not self.key[0] and key != self.key[0]:
            name = system.mechanism.name
            raise ValueError(f"{name} has another structure than this plan; expected a plan of it")

    def bind(
        self,
        system: System,
        flipped: Collection[int] = (),
        least_margin: Floats | None = None,
    ) -> Flow:
        """The flow of a system of this structure.

        Parameters
        ----------
        system
            Whose numbers and assembly branch are taken.
        flipped
            Blocks that are in the other branch.
        least_margin
            Relative margins below which an integration stops, shape (blocks,).

        Raises
        ------
        ValueError
            If the system has another structure.
        """
        self._require(system)
        parameters = _flipped(system, flipped)
        kernel = bind_kernel(self.program, parameters)
        layout = self.layout

        def linearise() -> Kernel:
            return bind_kernel(self._jacobian(system.topology), parameters)

        def wide(lanes: int) -> Kernel:
            return _with_code(kernel, self._wide(system.topology, lanes))

        def routines() -> Sequence[Routine]:
            return kernel_source(system.topology, layout).program.routines

        return Flow(
            clock=kernel.clock,
            rates=kernel.rates,
            parameters=kernel.parameters,
            timed_size=kernel.timed_size,
            coordinates=layout.size,
            rotates=self._rotates,
            margin_scale=system.margin_scale,
            least_margin=least_margin,
            first_carried=layout.moved,
            carried=len(layout.carried),
            counted=len(layout.counted),
            keepalive=kernel,
            linearise=linearise,
            switching=self._switching(system, parameters),
            wide=wide,
            routines=routines,
            stiff=is_stiff(system),
            longest_step=longest_step(system),
        )

    @cached_property
    def _rotates(self) -> NDArray[np.bool_]:
        return np.array(self.rotates)

    def _switching(self, system: System, parameters: Floats) -> Switching | None:
        """The switches, with what they do to a state bound to numbers."""
        switching = self.switching
        if switching is None or not (switching.values or switching.tangents):
            return switching

        def written() -> Program:
            model = kernel_source(system.topology, self.layout).model
            nodes = transition_nodes(model, self.layout)
            return write_functions_of(model, nodes, "what becomes of the state")

        kernel = bind_kernel(self._further("transitions", written), parameters)
        return replace(switching, transition=kernel)

    def _further(self, key: Hashable, write: Callable[[], Program]) -> GeneratedProgram:
        """Other functions of the structure, generated once."""
        return _FURTHER.get((self.key, key), lambda: GeneratedProgram.of(write()))

    def watch(
        self,
        system: System,
        function: EventFunction,
        key: Hashable = None,
        flipped: Collection[int] = (),
    ) -> Kernel:
        """A function of position and velocity, compiled for an event in the flow of a system.

        Parameters
        ----------
        system
            Whose numbers and assembly branch are taken.
        function
            The model → the function and its rate, which may depend on accelerations.
        key
            Equal for equal functions, which are generated once for a plan; None to do it anew.
        flipped
            Blocks that are in the other branch.
        """

        def written() -> Program:
            model = Model(system.topology, self.layout.more, self.layout.slopes)
            what = "a function of position and velocity, its rate"
            return write_functions_of(model, function(model), what)

        parameters = _flipped(system, flipped)
        if key is None:
            return bind_kernel(GeneratedProgram.of(written()), parameters)
        result = bind_kernel(self._further(key, written), parameters)

        def wide(lanes: int) -> Kernel:
            code = _WIDE.get((self.key, key, lanes), lambda: _in_lanes(written(), lanes))
            return _with_code(result, code)

        return replace(result, wide=wide)

    def _wide(self, topology: Topology, lanes: int) -> MachineCode:
        """The machine code of the kernel for some lanes."""
        source = partial(kernel_source, topology, self.layout)
        return _WIDE.get((self.key, lanes), lambda: _in_lanes(source().program, lanes))

    def _jacobian(self, topology: Topology) -> GeneratedProgram:
        """The generated derivatives of the accelerations."""

        def written() -> Program:
            derivatives = 2 * self.layout.size
            terms = expected_terms(topology) * (1 + PER_TANGENT * derivatives)
            announce(terms, f"derivatives of accelerations by {derivatives} coordinates and rates")
            source = kernel_source(topology, self.layout)
            return write_jacobian(source.model, source.accelerations)

        return self._further("jacobian", written)


_PLANS: LRUCache[Hashable, Plan] = LRUCache(4 * MOST_STRUCTURES)
_FURTHER: LRUCache[Hashable, GeneratedProgram] = LRUCache(MOST_STRUCTURES)
_WIDE: LRUCache[Hashable, MachineCode] = LRUCache(MOST_STRUCTURES)


def _in_lanes(program: Program, lanes: int) -> MachineCode:
    return MachineCode(write_assembly(program.routines, lanes))


def _flipped(system: System, flipped: Collection[int]) -> Floats:
    """The parameters of a system with some blocks in their other assembly branch."""
    parameters = system.parameters.copy()
    for block in flipped:
        parameters[system.model.inputs.parameters["side", block]] *= -1.0
    return parameters


def longest_step(system: System) -> float:
    """Length in seconds of a step in which no update of a sampled state can be missed."""
    places = system.model.inputs.parameters
    periods = [
        system.parameters[places[state.period.parameter.path]]
        for state in system.mechanism.sampled.values()
        if state.period is not None
    ]
    return LONGEST_STEP * min(periods, default=math.inf)


def is_stiff(system: System) -> bool:
    """Whether oil films bound the steps of explicit methods."""
    return any(contact.filled for contact in system.mechanism.contacts)


def _with_code(kernel: Kernel, code: MachineCode) -> Kernel:
    """The same kernel as other machine code."""
    clock, rates = code.address("clock"), code.address("rates")
    return replace(kernel, clock=clock, rates=rates, keepalive=code)


def build_flow(system: System, work: bool = False) -> Flow:
    """The differential equation of a system, compiled."""
    return Plan.of(system, work=work).bind(system)
