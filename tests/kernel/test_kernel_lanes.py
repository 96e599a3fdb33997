"""Kernels for several lanes against the kernel for one state, to the last bit."""

import numpy as np
import pytest
from kernel_lanes import run_routines, states_of

import linkages
from linkages.kernel.system import System
from linkages.mechanisms import names
from linkages.solution.moving.plan import kernel_source

LANES = (2, 4, 8, 16)
