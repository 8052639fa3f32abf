"""Verdicts of a diagnosis, fields of verdict.json, and exit statuses."""

from dataclasses import fields

from hannes.commands.edge import INTERRUPTED, PIPE_CLOSED, UNFORESEEN
from hannes.core.errors import BadInput, ComputationFailed
from hannes.identification.next_step import STEPS
from hannes.identification.verdict import SENTENCES, Verdict
from tools.reference.markdown import code, table

MEANINGS = {
    "named": "one effect, or two, explain what was missing",
    "named_with_remainder": "the same, and something else is left",
    "one_of": "one of `effects`; these recordings do not decide which",
    "unknown": "something is missing, and which effect is not decidable",
    "recalibrated": "refitted values explain all that is seen; what is missing, if anything, is "
    "smaller than `smallest_detectable`",
    "no_gap": "the simulation agrees as given",
    "undecided": "too few recordings for an answer; `reason` says what is lacking",
}
FIELDS = {
    "verdict": "one of the words above",
    "effects": "names of the effects; for `one_of`, the class",
    "parameters": "full name -> `value`, `unit`, `low`, `high` (95 % interval), `off`",
    "gap": "channel -> RMS residual `as_given`, `before` (base refitted), `after` (with the "
    "effect), and the noise `floor`; the same in percent of the recorded signal",
    "where": "channel, phase, times, recordings in which the refitted base disagrees, worst first",
    "candidates": "what each rival gains, best first; by a linear estimate where not `refitted`; "
    "`sizes` of those fitted alone",
    "reason": "why this verdict, in one sentence",
    "tried": "every effect, whether it applies, and why it was accepted or not",
    "alpha": "false-alarm level",
    "recordings": "names by role",
    "seed": "of drawn roles",
    "gap_on": "which recordings `gap` is of",
    "floor_from": "where the noise floor comes from",
    "cut": "how records were cut into segments",
    "cautions": "what the data check, and the diagnosis itself, warn of",
    "next_run": "the run that best separates the two best explanations, or null",
    "smallest_detectable": "effect -> parameter -> smallest size seen with 80 % power",
    "confusability": "`effects` and their `cosines`: how similar the signatures of two are here",
    "baseline": "`parameters` refitted without any new effect, moved most first: `name`, `of` "
    "(the object, where it is not the machine's), `unit`, `nominal`, `value`, `low`, `high` "
    "(95 % interval), `moved` (in prior standard deviations); `intervals_from` says whence",
    "nearest": "of an `unknown`: the candidates that come nearest, each with its `effects`, the "
    "share that it `explains` of what is missing, and `why_not`",
    "goes_with": "`baseline`: what the refitted base leaves, `left`: what the result leaves; each "
    "a `sentence` and its `statements` (`what`, the figure `value`, `low`, the least it is): where "
    "it is, what it grows with, both ways alike; empty where nothing is beyond chance, and not "
    "`tested` without three repeats of a command",
    "shape": "of an `unknown`: the likeliest generic disturbance: `name`, `meaning`, its `axis` "
    "(`name`, `unit`, `values`) and over it the `value` (`name`, `unit`, `values`, and the 95 % "
    "band `low` to `high`), `parameters`, `closes`, the share of the reducible gap on the "
    "recordings in role show, whether they have `shown` it, "
    "and `explains`, the share of the misfit beyond noise; "
    "where none helps, `name` is empty and `why_not` says it",
    "each_explains": "of several named effects each: the share of the reducible gap that it alone "
    "`explains` on recordings that were not fitted, and the RMS of each channel `without` it, the "
    "machine following",
    "probabilities": "of the `answer`; that `nothing` is missing, that it is `something_else` (no "
    "effect of the catalogue), and of `effects`, each a set with its `probability`; empty where "
    "they are not known",
    "versions": "of the libraries",
}
STATUSES = (
    (0, "done; any verdict of a diagnosis ends so"),
    (BadInput.exit_status, "bad input: one line says what was expected, what came, what to do"),
    (
        ComputationFailed.exit_status,
        "the computation failed (solver, fit): one line says what to try",
    ),
    (UNFORESEEN, "a fault that nobody foresaw: one line says where its details are kept"),
    (INTERRUPTED, "stopped by Ctrl-C, SIGTERM or SIGHUP; earlier results are as they were"),
    (PIPE_CLOSED, "whoever read the output has gone"),
)


def page() -> str:
    """Text of the page; a verdict, or a field, without a meaning here is an error."""
    verdicts = [(code(each), MEANINGS[each], " ".join(STEPS[each])) for each in SENTENCES]
    keys = [(code(each.name), FIELDS[each.name]) for each in fields(Verdict)]
    return f"""# Verdicts and exit statuses

`hannes diagnose` writes `report.html` for people, `hand.toml` (the plant with what was found),
and `verdict.json`.

## Verdicts

{table(("`verdict`", "means", "next"), verdicts)}

Where `next_run` is given, it is the run to record: its `experiment`, with the channels of
`also_log` too.

## Fields of verdict.json

{table(("key", "holds"), keys)}

## Exit statuses

{table(("status", "means"), STATUSES)}

With `--json` a command prints one JSON object on standard output and nothing else there.
Results are written whole or not at all: a killed command leaves the old results or the new ones.
"""
