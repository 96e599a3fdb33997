"""Names of the package: the one list that editors, type checkers and `linkages` itself read."""

from typing import Any

from linkages.bridges.pmks import from_pmks as from_pmks
from linkages.bridges.pylinkages import from_pylinkage as from_pylinkage
from linkages.chaos.growth.lyapunov import lyapunov as lyapunov
from linkages.chaos.sections.section import poincare as poincare
from linkages.chaos.sweeps.bifurcation import bifurcation as bifurcation
from linkages.chaos.sweeps.maps import chaos_map as chaos_map
from linkages.chaos.verdicts.report import verdict as verdict
from linkages.components.assembly import AssemblyHint as AssemblyHint
from linkages.components.bar import Bar as Bar
from linkages.components.clearance import Clearance as Clearance
from linkages.components.contact_clearance import ContactClearance as ContactClearance
from linkages.components.damper import GuideDamper as GuideDamper
from linkages.components.damper import LineDamper as LineDamper
from linkages.components.drive import Drive as Drive
from linkages.components.drive import SliderDrive as SliderDrive
from linkages.components.free import FreeAngle as FreeAngle
from linkages.components.free import FreePosition as FreePosition
from linkages.components.gear import Gear as Gear
from linkages.components.gravity import UniformGravity as UniformGravity
from linkages.components.ground import GroundJoint as GroundJoint
from linkages.components.guide_clearance import GuideClearance as GuideClearance
from linkages.components.load import JointForce as JointForce
from linkages.components.load import SliderForce as SliderForce
from linkages.components.mass import JointMass as JointMass
from linkages.components.mechanisms.definition import load as load
from linkages.components.mechanisms.definition import loads as loads
from linkages.components.mechanisms.mechanism import Mechanism as Mechanism
from linkages.components.plate import Plate as Plate
from linkages.components.simulation import SimulationDefaults as SimulationDefaults
from linkages.components.slider import Slider as Slider
from linkages.components.spring import JointSpring as JointSpring
from linkages.components.torque import BarTorque as BarTorque
from linkages.components.torque import TorqueBetweenBars as TorqueBetweenBars
from linkages.components.torsional_damper import ClearanceDamper as ClearanceDamper
from linkages.components.torsional_damper import DamperBetweenBars as DamperBetweenBars
from linkages.components.torsional_damper import JointDamper as JointDamper
from linkages.components.torsional_spring import BarSpring as BarSpring
from linkages.components.torsional_spring import SpringBetweenBars as SpringBetweenBars
from linkages.components.weld import Weld as Weld
from linkages.design.fitting.fit import Fitted as Fitted
from linkages.design.fitting.fit import fit as fit
from linkages.design.optimising.optimise import optimise as optimise
from linkages.design.optimising.optimum import Optimum as Optimum
from linkages.design.sensitivity.sensitivities import sensitivities as sensitivities
from linkages.design.tolerances.tolerance import tolerance as tolerance
from linkages.errors import ComputationError as ComputationError
from linkages.errors import InputError as InputError
from linkages.errors import Interrupted as Interrupted
from linkages.errors import LinkagesError as LinkagesError
from linkages.exports import export as export
from linkages.plots import charts as charts
from linkages.plots.films.animation import animate as animate
from linkages.registering import register as register
from linkages.registering import unregister as unregister
from linkages.reports.report import save_report as save_report
from linkages.reports.tables import save_table as save_table
from linkages.solution.functions.propagator import Propagator as Propagator
from linkages.solution.functions.rhs import Equations as Equations
from linkages.solution.functions.rhs import compile as compile  # noqa: A004
from linkages.solution.measuring.measure import measure as measure
from linkages.solution.opened import Opened as Opened
from linkages.solution.opened import open as open  # noqa: A004
from linkages.solution.simulate import simulate as simulate
from linkages.solution.solution import IncompleteError as IncompleteError
from linkages.solution.solution import Solution as Solution
from linkages.sweeps.sweep import sweep as sweep
from linkages.viewer.view import view as view

__version__: str

def __getattr__(name: str) -> Any: ...  # components that others register
