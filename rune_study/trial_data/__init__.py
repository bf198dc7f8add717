"""What recordings say of a trial, as arrays that metrics take.

| file | what |
| --- | --- |
| `trial_log` | the messages of a trial, by robot and kind, in seconds of the trial |
| `track` | where a robot was and how it moved |
| `operator` | what the operator pressed, and which robot he had chosen |
| `sightings` | marks, and where the camera looked |
| `truth` | the true arena: ground and victims |
| `measured` | all of this as the data that metrics take |
"""
