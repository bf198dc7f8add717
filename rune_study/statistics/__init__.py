"""Statistics of studies with repeated measures, in numpy alone.

| file | what |
| --- | --- |
| `distributions` | p-values and quantiles: normal, t, F, chi-square |
| `survival` | Kaplan-Meier curve, its median, quantiles and restricted mean |
| `log_rank` | log-rank test of two or more groups, stratified if wanted |
| `repeated_measures` | analysis of variance within participants, Greenhouse-Geisser always |
| `ranks` | Friedman's test, Hodges-Lehmann estimate with its exact interval |
| `paired` | the difference of two conditions: mean, dz, Hodges-Lehmann, t, sign flips |
| `sign_flips` | exact test of a mean difference |
| `bootstrap` | intervals of any statistic: percentile and BCa |
| `holm` | p-values of several tests |
| `means` | mean and share with their intervals |

Each takes plain arrays. NaN is a missing value: incomplete participants are left out, and the
result says which. A number that cannot be known is an `Estimate` with a reason, or a result whose
`why` says it. Data with a wrong shape or range raise `rune_study.errors.DataError`.
"""
