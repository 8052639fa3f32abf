"""The hand's model: its equations, with the layouts of all that they read and write."""

from hannes.core.layout import Layout
from hannes.simulation.compiler.assemble import Equations
from hannes.simulation.hand import equations, variables
from hannes.simulation.hand.jacobian import sparsity

EQUATIONS = Equations(
    equations,
    Layout(variables.PARAMETER_SLOTS),
    Layout(variables.STATES),
    Layout(variables.CHANNELS),
    Layout(variables.OUTPUTS),
    shape=sparsity.shape,
    numbers=Layout(variables.NUMBERS),
)
