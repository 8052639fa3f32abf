"""Two linearly implicit methods, stiffly accurate and L-stable, for tight and loose tolerances.

Rodas4P2: order 4 with an embedded method of order 3, six evaluations a step. Steinebach (2020),
Improvement of Rosenbrock-Wanner method RODASP, in Progress in Differential-Algebraic Equations
II, pp. 165-184. It keeps order 4 on stiff and differential-algebraic problems, and order 2 with a
wrong J.

Rodas3: order 3 with an embedded method of order 2, three evaluations a step. Sandu et al. (1997),
Benchmarking stiff ODE solvers for atmospheric chemistry problems II, Atmospheric Environment 31,
3459-3472. Where contacts come and go steps are short for any order, and the cheaper step wins.

Both in the form of Hairer & Wanner (1996), Solving Ordinary Differential Equations II, section
IV.7:

    (1 / (gamma h) - J) k_i = f(t + NODES_i h, y + sum_j STAGE_ij k_j)
                              + sum_j COUPLING_ij k_j / h + h DRIFT_i df/dt
    y(t + h) = (argument of the last stage) + k_last,   error = k_last

A stage that is not FRESH has the argument of the one before. Rows of the method for tight
tolerances come first.
"""

import numpy as np

LOOSE = 2e-3  # relative tolerance from which on Rodas3 takes less for as small an error

STAGES = np.array([6, 4])
ORDER = np.array([4.0, 3.0])
GAMMA = np.array([0.25, 0.5])
LOOK = np.array([1, 2])  # the first stage that looks ahead
FRESH = np.array([[True] * 6, [True, False, True, True, False, False]])
NODES = np.array(
    [
        [0.0, 0.75, 0.321448134013046, 0.519745732277726, 1.0, 1.0],
        [0.0, 0.0, 1.0, 1.0, 0.0, 0.0],
    ]
)
DRIFT = np.array(
    [
        [0.25, -0.5, -0.189532918363016, 0.085612108792769, 0.0, 0.0],
        [0.5, 1.5, 0.0, 0.0, 0.0, 0.0],
    ]
)


def _lower(*rows: tuple[float, ...]) -> np.ndarray:
    """Fill a strictly lower triangular matrix."""
    full = np.zeros((6, 6))
    for i, row in enumerate(rows):
        full[i, : len(row)] = row
    return full


_LAST = (7.089566927282776, 4.573591406461604, -8.423496976860259, -0.959280113459775)

STAGE = np.array(
    [
        _lower(
            (),
            (3.0,),
            (0.906377755268814, -0.189707390391685),
            (3.758617027739064, 1.161741776019525, -0.849258085312803),
            _LAST,
            (*_LAST, 1.0),
        ),
        _lower((), (), (2.0,), (2.0, 0.0, 1.0)),
    ]
)

COUPLING = np.array(
    [
        _lower(
            (),
            (-12.0,),
            (-6.354581592719008, 0.338972550544623),
            (-8.575016317114033, -7.606483992117508, 12.224997650124820),
            (-5.888975457523102, -8.157396617841821, 24.805546872612922, 12.790401512796979),
            (
                -4.408651676063871,
                -6.692003137674639,
                24.625568527593117,
                16.627521966636085,
                -5.714285714285718,
            ),
        ),
        _lower((), (4.0,), (1.0, -1.0), (1.0, -1.0, -8.0 / 3.0)),
    ]
)

# y(t + x h) = (1 - x) y + x (y_1 + (1 - x) (c_1 + x c_2)), c_i = sum_j DENSE_ij k_j; that of
# Rodas3, of order 2 inside a step, leaves only one of the two conditions of order 3 unmet
DENSE = np.array(
    [
        [
            [
                -5.323528268423303,
                -10.042123754867493,
                17.175254928256965,
                -5.079931171878093,
                -0.016185991706112,
                0.0,
            ],
            [
                6.984505741529879,
                6.914061169603662,
                -0.849178943070653,
                18.104410789349338,
                -3.516963011559032,
                0.0,
            ],
        ],
        [[3.0, -1.0, -1.0, -1.0, 0.0, 0.0], [0.0, 0.0, -1.0, -1.0, 0.0, 0.0]],
    ]
)
