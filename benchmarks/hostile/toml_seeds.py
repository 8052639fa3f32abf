"""Sound TOML files of every kind, of which mutants are made."""

EXPERIMENT = """
title = "a ball"
hand = "hannes"
duration = "0.6 s"
sampling = "1 kHz"
controller = "continuous"
effects = ["supply_sag"]
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.4 s", "5 rad"], ["0.6 s", "0 rad"]]
[object]
shape = "sphere"
radius = "36 mm"
position = ["4 mm", "-47 mm", "0 mm"]
material = { stiffness = "800 N/m", damping = "20 N s/m", friction = "0.4" }
sensor = true
[noise]
current = "10 mA"
seed = 1
[parameters]
"motor.dry_friction" = "0.0055 N m"
[sweep]
"object.radius" = ["36 mm", "35 mm"]
"""
HAND = """
base = "hannes"
effects = ["supply_sag", "capstan"]
[parameters]
"motor.dry_friction" = "0.0055 N m"
"supply_sag.resistance" = "0.2 ohm"
"""
CAMPAIGN = """
title = "two runs"
plant = "hand"
base = "hand.toml"
out = "results"
effects = ["gear_load"]
[[recording]]
file = "recording.csv"
condition = "closure"
experiment = "experiment.toml"
role = "fit"
[[recording]]
file = "recording.h5"
runs = "0:1"
[calibrate]
parameters = ["motor.dry_friction"]
starts = 2
[diagnose]
run_scatter = "0.01"
"""
AXIS = """
title = "two runs of an axis"
plant = "axis"
out = "results"
[[recording]]
file = "axis.csv"
condition = "back and forth"
[[recording]]
file = "axis_again.csv"
condition = "back and forth"
[calibrate]
starts = 2
"""
FINGER = """
plant = "finger"
[[recording]]
file = "finger.csv"
mapping = "rh56"
condition = "pressed"
runs = "0:2"
"""
OWN = """
plant = "mutant.py:PLANT"
effects = ["mutant.py:EFFECT"]
"""
SPEC = """
title = "some"
seed = 1
duration = "0.3 s"
sampling = "1 kHz"
border = "5 kN/m"
channels = ["current", "force"]
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.3 s", "5 rad"]]
[values]
"motor.dry_friction" = { spread = "0.05" }
"noise.current" = "10 mA"
[[grasps]]
name = "balls"
shape = "sphere"
role = "train"
draws = 3
[grasps.values]
"object.stiffness" = ["800 N/m", "2000 N/m"]
"""
EVALUATION = """
title = "known"
[[object]]
name = "Ball"
class = "soft"
file = "forces.csv"
stiffness = "800 N/m"
"""
BOARD = """
experiment = "experiment.toml"
variant = 1
seed = 1
[board]
watchdog = "200 ms"
current_limit = "6 A"
[misbehaviour]
lost = "0.1 %"
late = "5 ms"
cut = "3 s"
drift = "0.004 %"
garbled = false
"""
ALONE = EXPERIMENT.partition("[sweep]")[0]  # one simulation
