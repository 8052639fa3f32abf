"""Examples that `hannes COMMAND --help` shows, by command."""

from hannes.commands import (
    cli_bench,
    cli_compare,
    cli_firmware,
    cli_learning,
    cli_live,
    cli_panel,
    cli_recordings,
    cli_trust,
    cli_views,
)
from hannes.identification.diagnosis.settings import Settings

SCATTER = f"{100.0 * Settings.scatter:g} %"
RUN_SCATTER = f"{100.0 * Settings.run_scatter:g} %"

EXAMPLES = {
    "": """\
hannes run dynamometer           simulate a shipped experiment, write results/dynamometer
hannes experiments               what there is to run
hannes reproduce                 the paper's figures and tables beside ours, one page
hannes calibrate campaign.toml   parameters from recordings, with intervals that hold
hannes diagnose campaign.toml    what a model is missing that recordings disagree with""",
    "run": """\
hannes run void-closure
hannes run my.toml --out results/mine
hannes run dynamometer --method Radau --rtol 1e-6 --json""",
    "experiments": """\
hannes experiments""",
    "effects": """\
hannes effects
hannes effects leader_slack
hannes effects my_effect.py:EFFECT""",
    "hand": """\
hannes hand
hannes hand results/closure/hand.toml
hannes hand --equations | less
hannes hand --schematic > hand.svg
hannes hand --mjcf > hand.xml                   for MuJoCo; its head says what it leaves out""",
    "reproduce": """\
hannes reproduce
hannes reproduce --out results/paper --json""",
    "calibrate": """\
hannes calibrate campaign.toml
hannes calibrate campaign.toml --out results/mine --json

campaign.toml, after its [[recording]]s; all of it may be left out:
  [calibrate]
  parameters = ["motor.resistance", "motor.dry_friction"]
  channels = ["current", "position"]
  features = ["closing time", "I_max"]    # of the paper's Table II
  loss = "soft_l1"                        # linear, soft_l1, huber, cauchy
  starts = 4                              # multi-start: number of searches
  scan = 64                               # points evaluated before them
  doubt = "2 %"                           # of all values that are not fitted; without it 3 %
  limit = "10 %"                          # half-width beyond which nothing is identified
  model_error = "1 %"                     # error of any model, as a share of the channel
  accept = ["gap", "saturated"]           # what `hannes check` finds, taken as it is
  [calibrate.spread]                      # standard deviation of a nominal value
  "motor.resistance" = "20 %"
  [calibrate.bounds]
  "motor.resistance" = ["2 ohm", "5 ohm"]
  [calibrate.nuisance]                    # run-to-run standard deviation
  start_time = "10 ms"
  "motor.dry_friction" = "1 %\"""",
    "diagnose": f"""\
hannes diagnose campaign.toml
hannes diagnose campaign.toml --out results/verdict --json
hannes diagnose campaign.toml --describe      # what cannot be named, as a law of free shape

campaign.toml (docs/reference/campaign.md has all of it):
  plant = "hand"                          # or "axis", "finger", "module:Class" of your own
  effects = ["my_effect.py:EFFECT"]       # beside those of `hannes effects`
  [[recording]]
  file = "void_*.csv"                     # repeats under one command
  experiment = "void-closure"             # what was done: a shipped name, or a .toml
  condition = "void, full speed"
  role = "fit"                            # or select, show; drawn where absent
  [diagnose]                              # standard deviations; may be left out
  scatter = "2 %"                         # of nominal values ({SCATTER})
  scatter_apart = "0.5 %"                 # each joint for itself (1 %)
  run_scatter = "0.5 %"                   # of friction from run to run ({RUN_SCATTER})
  start_time = "0.2 ms"                   # of when a run starts (10 ms for a hand)
  work = 2                                # twice as long, where a search was ended""",
    **cli_recordings.EXAMPLES,
    **cli_compare.EXAMPLES,
    **cli_learning.EXAMPLES,
    **cli_bench.EXAMPLES,
    **cli_live.EXAMPLES,
    **cli_firmware.EXAMPLES,
    **cli_panel.EXAMPLES,
    **cli_views.EXAMPLES,
    **cli_trust.EXAMPLES,
}
