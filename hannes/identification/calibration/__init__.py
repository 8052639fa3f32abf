"""Fits a plant's parameters to recordings, with intervals that hold and what the data cannot see.

Statistics, in short. A hand differs a little from itself in every run (friction, winding, springs
by 0.3 to 1 %), and that, not the sensors' noise, is what limits a calibration. So the run is the
unit of every interval.

Estimate: each run's bin means and features, minus the simulation's, are whitened by a working
covariance V = D + U U': D the channel's noise and what no model of such a machine gets better, U
the directions in which runs may differ (each restless parameter's sensitivity times its spread,
and the start time). Bounded least squares of all runs together, with a weak prior at the given
values, then D from what remains, until it stands still.

Interval: the spread of the runs' own pulls on each parameter (a sandwich clustered by run). With
six to sixteen runs that is too small and too sure of itself, so it is freed of its bias and given
its degrees of freedom under the working covariance (Bell & McCaffrey 2002; Pustejovsky & Tipton
2018). A wrong V costs efficiency, hardly coverage. One run alone is cut into stretches.

Labels: a parameter is identified where its interval is narrow against its value, confounded where
knowing another one would make it so. What stays the same in all runs after the fit is no noise: it
is the model that is wrong, and no interval speaks of that.
"""
