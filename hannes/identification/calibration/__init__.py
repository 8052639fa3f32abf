"""Fits a plant's parameters to recordings, with honest intervals and what the data cannot show.

A machine differs slightly from itself in every run: friction, winding and springs by 0.3 to 1 %.
That, and not sensor noise, limits a calibration. So the run is the unit of every interval.

Estimate: the residual of each run's bin means and features is whitened by a working covariance
V = D + U U'. D holds each channel's noise and model error. U holds the run-to-run variability:
each varying parameter's sensitivity times its spread, and the start time. All runs are fitted
together by bounded least squares, with a weak prior at the nominal values. D is then estimated
from the residual, and the fit repeated until it is stable.

Interval: the spread of the runs' influences on each parameter, a sandwich estimate clustered by
run. With six to sixteen runs that estimate is biased low. It is corrected for bias, and has its
degrees of freedom under the working covariance (Bell & McCaffrey 2002; Pustejovsky & Tipton 2018).
A wrong V costs efficiency, and hardly coverage. A single run is cut into segments.

Labels: a parameter is identified where its interval is narrow against its value. It is confounded
where knowing another one would make it so. A residual that is the same in all runs is no noise but
model error, and no interval includes that.
"""
