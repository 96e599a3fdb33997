"""Public names for writing components; docs/howto/component.md has an example.

A component is a frozen dataclass (`component`, `Component`, `ListedComponent`) whose fields have
types of `linkages.spec.quantities`. It names the joints and bodies that it uses (`References`) and
returns terms: most often a `Load`, which is a law (a `Function` of the value `X` and the rate `V`)
along a measure (`Distance`, `Turn`, `Slide`, `Coordinate`). Attachments (`BetweenJoints`,
`OnSlider`, `OnBar`, `BetweenBars`, `AtJoint`) are bases with the keys, references and problems of
what a load acts along; their `acting` makes the load of a law.
"""

from linkages.components.contributed.attachments import (
    AtJoint,
    BetweenBars,
    BetweenJoints,
    OnBar,
    OnSlider,
    ends,
    two_joints,
)
from linkages.components.contributed.component import (
    Component,
    ListedComponent,
    References,
    Section,
    component,
)
from linkages.components.contributed.functions import (
    TIME,
    Function,
    Number,
    Operation,
    V,
    X,
    applied,
)
from linkages.components.contributed.load_measures import (
    Coordinate,
    Distance,
    Load,
    Slide,
    Turn,
    damper_law,
    spring_law,
)
from linkages.components.contributed.terms import Parameter
from linkages.reading.paths import KeyPath

__all__ = [
    "TIME",
    "AtJoint",
    "BetweenBars",
    "BetweenJoints",
    "Component",
    "Coordinate",
    "Distance",
    "Function",
    "KeyPath",
    "ListedComponent",
    "Load",
    "Number",
    "OnBar",
    "OnSlider",
    "Operation",
    "Parameter",
    "References",
    "Section",
    "Slide",
    "Turn",
    "V",
    "X",
    "applied",
    "component",
    "damper_law",
    "ends",
    "spring_law",
    "two_joints",
]
