"""Finds what a model lacks, while everything uncertain about the machine is fitted too.

Recordings are reduced to bin means. Around a hundred quantities of a simulation are not known
exactly: every parameter of the machine within its own spread (`parameter_space`), what differs
from run to run, start times, sensor noise (`noise_model`), and the discretisation error of the
sampled controller (`simulator`). All of them are free in every fit, with a Gaussian prior
(`gauss_newton`). An effect is credited only with what none of them can explain. Simulations are
quick enough to refit all parameters for the baseline and for every effect on the shortlist. Linear
guesses only make the shortlist (`score_test`).

Chi-squared is the squared distance of all recordings from the simulation, in standard deviations,
plus the squared distance of all parameters from their nominal values in theirs. With nothing
missing it is about the number of bins. An effect's `delta_chi2` is by how much it falls when the
effect is added.
"""
