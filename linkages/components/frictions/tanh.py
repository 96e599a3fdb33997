"""μ tanh(v/vs): smooth, so that nothing sticks and everything creeps."""

from linkages.components.contributed.friction_laws import Coefficients, FrictionLaw
from linkages.components.contributed.functions import Function, V, applied


def _resists(numbers: Coefficients) -> Function:
    return numbers["friction"] * applied("tanh", V / numbers["slip"])


LAW = FrictionLaw("tanh", ("slip",), _resists)
