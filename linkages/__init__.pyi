"""Names of the package: the one list that editors, type checkers and `linkages` itself read."""

from typing import Any

from linkages.attractors.basins import basins as basins
from linkages.attractors.hysteresis import attractor_diagram as attractor_diagram
from linkages.bridges.pmks import from_pmks as from_pmks
from linkages.bridges.pylinkages import from_pylinkage as from_pylinkage
from linkages.chaos.bifurcation import bifurcation as bifurcation
from linkages.chaos.findings import verdict as verdict
from linkages.chaos.lyapunov import lyapunov as lyapunov
from linkages.chaos.maps import chaos_map as chaos_map
from linkages.chaos.sections import poincare as poincare
from linkages.components.actuators import Drive as Drive
from linkages.components.actuators import SliderDrive as SliderDrive
from linkages.components.external_loads import BarTorque as BarTorque
from linkages.components.external_loads import JointForce as JointForce
from linkages.components.external_loads import SliderForce as SliderForce
from linkages.components.external_loads import TorqueBetweenBars as TorqueBetweenBars
from linkages.components.joint_clearances import Clearance as Clearance
from linkages.components.joint_clearances import ContactClearance as ContactClearance
from linkages.components.joint_clearances import GuideClearance as GuideClearance
from linkages.components.mechanisms.definition import load as load
from linkages.components.mechanisms.definition import loads as loads
from linkages.components.mechanisms.mechanism import Mechanism as Mechanism
from linkages.components.rigid_bodies import Bar as Bar
from linkages.components.rigid_bodies import GroundJoint as GroundJoint
from linkages.components.rigid_bodies import JointMass as JointMass
from linkages.components.rigid_bodies import Plate as Plate
from linkages.components.rigid_bodies import Slider as Slider
from linkages.components.rigid_bodies import Weld as Weld
from linkages.components.scene import AssemblyHint as AssemblyHint
from linkages.components.scene import FreeAngle as FreeAngle
from linkages.components.scene import FreePosition as FreePosition
from linkages.components.scene import SimulationDefaults as SimulationDefaults
from linkages.components.scene import UniformGravity as UniformGravity
from linkages.components.springs import BarSpring as BarSpring
from linkages.components.springs import ClearanceDamper as ClearanceDamper
from linkages.components.springs import DamperBetweenBars as DamperBetweenBars
from linkages.components.springs import GuideDamper as GuideDamper
from linkages.components.springs import JointDamper as JointDamper
from linkages.components.springs import JointSpring as JointSpring
from linkages.components.springs import LineDamper as LineDamper
from linkages.components.springs import SpringBetweenBars as SpringBetweenBars
from linkages.components.transmissions import Gear as Gear
from linkages.design.duty import MotorLine as MotorLine
from linkages.design.duty import duty as duty
from linkages.design.fit import Fitted as Fitted
from linkages.design.fit import fit as fit
from linkages.design.optimise import Optimum as Optimum
from linkages.design.optimise import optimise as optimise
from linkages.design.sensitivities import sensitivities as sensitivities
from linkages.design.tolerance import tolerance as tolerance
from linkages.design.workspace import workspace as workspace
from linkages.equilibria.equilibrium import equilibrium as equilibrium
from linkages.equilibria.equilibrium import state_space as state_space
from linkages.errors import ComputationError as ComputationError
from linkages.errors import InputError as InputError
from linkages.errors import Interrupted as Interrupted
from linkages.errors import LinkagesError as LinkagesError
from linkages.exports import export as export
from linkages.opened import Opened as Opened
from linkages.opened import open as open  # noqa: A004
from linkages.orbits.follow import follow as follow
from linkages.orbits.orbit import orbit as orbit
from linkages.plots import charts as charts
from linkages.plots.films.animation import animate as animate
from linkages.registering import register as register
from linkages.registering import unregister as unregister
from linkages.reports.sheets import save_report as save_report
from linkages.reports.tables import save_table as save_table
from linkages.solution.measuring import measure as measure
from linkages.solution.propagator import Propagator as Propagator
from linkages.solution.rhs import Equations as Equations
from linkages.solution.rhs import compile as compile  # noqa: A004
from linkages.solution.simulate import simulate as simulate
from linkages.solution.solution import IncompleteError as IncompleteError
from linkages.solution.solution import Solution as Solution
from linkages.sweeps.sweep import sweep as sweep
from linkages.tribology.cycle_jumps import wear as wear
from linkages.tribology.life import wear_life as wear_life
from linkages.viewer.content import view as view

__version__: str

def __getattr__(name: str) -> Any: ...  # components that others register
