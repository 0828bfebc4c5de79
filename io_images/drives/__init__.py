"""Words of AMCI's networked drives and controllers: SMD23E2, SMD24E2, SD17060E2, ANG1, ANF2.

| file | contents |
|---|---|
| `bits` | the bits of all words of the family |
| `models` | a row for each model: words, bits, ranges, functions |
| `configuration` | the words of configuration mode, and their checks |
| `command` | the words of command mode |
| `translation` | translates words of a 3601 to words of a drive, and back, for axes and motion blocks |
| `status` | the status, with the bits' names on a drive |
| `rules` | refused commands and reported errors, one row per rule, with its page |
| `differences` | bits and words of a 3601 that have another meaning on a drive |

Short names of the sources: "SMD" is the manual 940-0S15x of SMD23E2 and SMD24E2, "17" the manual of the
SMD17E2, "SD" of the SD17060E, "SD2" of SD17060E2 and SD31045E2, "K" of SD17060E-K. "EDS" is the vendor's EDS
file of the SMD23E2, version 1.6.
"""
