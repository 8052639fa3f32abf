"""Finds what a model lacks, with the whole of what is not known of the machine priced in.

Recordings are reduced to bin means. A simulation that a recording is compared with has about a
hundred things that nobody knows exactly: every parameter of the machine, each with its own spread
(`space`), what differs from run to run, when a run starts, sensors (`noise`), and the grain of the
firmware (`grain`). All of them are free, held by their spreads, in every fit (`fit`): what an
effect is credited with is only what none of them can do. Simulations are quick enough to refit
all of it, for the base and for every effect on the short list, instead of ruling by signs or by
a linear guess; guesses only make the short list (`screen`).

The misfit is the squared distance of all recordings from the simulation in standard deviations,
plus the squared distance of all parameters from their given values in theirs. With nothing missing
it is about the number of bins; an effect's gain is how much it falls when the effect is let in.
"""
