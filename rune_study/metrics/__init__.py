"""Metrics of human-robot interaction, in numpy alone.

`registry.measure(trial, spec)` computes all of them from a `trial.TrialData`. `registry.METRICS` is
the table from which data dictionaries are made. The reader of logs fills the `TrialData`; its times
are those that `trial_time` freed of freezes and pauses. Each file also works alone, on arrays.

| file | what |
| --- | --- |
| `trial` | the data of a trial, and the numbers that a study fixes |
| `trial_time` | times of the trial, without freezes and pauses |
| `episodes` | interaction effort IE, attention |
| `effectiveness` | task effectiveness TE(t) |
| `neglect` | neglect tolerance NT, censored |
| `fan_out` | RAD, FT, FO |
| `analysis` | these of one trial, each computed once; what cannot be identified says so |
| `victims`, `coverage`, `map_quality` | what was found |
| `bumps`, `driving`, `steering`, `shortest_path` | how it was driven |
| `latency`, `awareness`, `questionnaires` | what the operator saw, knew and felt |
"""
